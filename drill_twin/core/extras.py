# SPDX-License-Identifier: Apache-2.0
"""Packages that come with an extra of drill_twin."""

from importlib import import_module
from typing import Any

from drill_twin.core.errors import ArgumentError

_EXTRAS = {"xarray": ("xarray", "to_xarray"), "lasio": ("las", "LAS file"), "distributed": ("dask", "--dask")}
"""Package -> its extra, and what it is for."""


def import_extra(package: str) -> Any:
    """Import a package.

    Args:
        package: `xarray`, `lasio` or `distributed`.

    Raises:
        ArgumentError: It is not installed.
    """
    extra, purpose = _EXTRAS[package]
    try:
        return import_module(package)
    except ImportError:
        raise ArgumentError(
            f"{purpose}: expected the package {package}, found none; install it: pip install 'drill_twin[{extra}]'"
        ) from None
