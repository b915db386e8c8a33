# SPDX-License-Identifier: Apache-2.0
"""Flags with which kernels are compiled."""

import importlib
import pkgutil

import pytest
from numba.core.dispatcher import Dispatcher

ROOMS = ("core", "physics", "dynamics.solver", "dynamics.audit", "whirl")


@pytest.mark.parametrize("room", ROOMS)
def test_no_function_of_the_time_loop_counts_references(room):
    """The flag is set by the name of the module, so a room that is renamed would lose it without another sign."""
    package = importlib.import_module(f"drill_twin.{room}")
    names = [module.name for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")]
    defined = {
        f"{name}.{key}": value.targetoptions["_nrt"]
        for name in names
        for key, value in vars(importlib.import_module(name)).items()
        if isinstance(value, Dispatcher) and value.py_func.__module__ == name and "_nrt" in value.targetoptions
    }
    assert defined
    assert not [name for name, counts in defined.items() if counts]
