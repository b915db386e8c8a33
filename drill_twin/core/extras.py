# SPDX-License-Identifier: Apache-2.0
"""Packages that come with an extra of drill_twin."""

from importlib import import_module
from typing import Any

from drill_twin.core.errors import ArgumentError


def import_xarray() -> Any:
    """Import xarray, for `to_xarray`.

    Raises:
        ArgumentError: It is not installed.
    """
    return _import("xarray", "to_xarray", "xarray")


def import_lasio() -> Any:
    """Import lasio, for LAS files.

    Raises:
        ArgumentError: It is not installed.
    """
    return _import("lasio", "LAS file", "las")


def import_distributed() -> Any:
    """Import Dask's scheduler and client, for ensembles on many machines.

    Raises:
        ArgumentError: It is not installed.
    """
    return _import("distributed", "--dask", "dask")


def _import(package: str, purpose: str, extra: str) -> Any:
    try:
        return import_module(package)
    except ImportError:
        raise ArgumentError(
            f"{purpose}: expected the package {package}, found none; install it: pip install 'drill_twin[{extra}]'"
        ) from None
