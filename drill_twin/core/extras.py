# SPDX-License-Identifier: Apache-2.0
"""Packages that come with an extra of drill_twin."""

from importlib import import_module
from typing import Any

from drill_twin.core.errors import ArgumentError, DrillTwinError

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


def missing(error: ModuleNotFoundError, extra: str) -> DrillTwinError:
    """Error of a part of drill_twin whose extra is not installed, from the failed import."""
    module = (error.name or "").partition(".")[0]  # a part of the package may be what was asked for first
    return DrillTwinError(f"expected the Python module {module!r}, found none; pip install 'drill_twin[{extra}]'")
