# SPDX-License-Identifier: Apache-2.0
"""Packages that come with an extra of drill_twin."""

from importlib import import_module
from typing import Any

from drill_twin.errors import ArgumentError


def import_xarray() -> Any:
    """Import xarray, for `to_xarray`.

    Raises:
        ArgumentError: It is not installed.
    """
    try:
        return import_module("xarray")
    except ImportError:
        raise ArgumentError(
            "to_xarray: expected the package xarray, found none; install it: pip install 'drill_twin[xarray]'"
        ) from None
