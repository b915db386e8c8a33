# SPDX-License-Identifier: Apache-2.0
"""Flags with which kernels are compiled."""

import importlib
import pkgutil
from typing import NamedTuple

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from drill_twin.core.arrays import Array
from drill_twin.core.compile import jit
from drill_twin.core.compile.inlined_compiler import _ANSWERS, InlinedLibrary, _remembered

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


class Record(NamedTuple):
    values: Array
    bounds: Array


def total(record, count):
    """Uses a record in several blocks, and variables that are assigned once, in a loop, in a branch, and twice."""
    found, values = 0.0, record.values
    for k in range(count):
        double = 2.0 * values[k]
        if double > record.bounds[0]:
            part = double
            if part > record.bounds[1]:
                found += part
        else:
            part = -1.0
        found += part
    return found if count else double


def test_a_variable_that_is_assigned_once_has_no_place_on_the_stack(monkeypatch):
    """A record of arrays has hundreds of words, which LLVM would move to and from such a place at each use."""
    jit.start()
    lowered, record = [], Record(np.array([0.5, 2.0, 4.0, -1.0, 3.0]), np.array([3.0, 7.0]))
    add = InlinedLibrary.add_ir_module
    monkeypatch.setattr(InlinedLibrary, "add_ir_module", lambda own, made: (lowered.append(str(made)), add(own, made)))
    monkeypatch.setattr(total, "__module__", "drill_twin.core.probe")
    inlined = jit.kernel(total)

    @jit.entry_kernel
    def entry(record, count):
        return inlined(record, count)

    assert entry(record, 5) == total(record, 5) == 24.0
    (text,) = lowered
    assert '%"found' in text
    assert " = alloca" in text  # of what is assigned more than once
    assert '%"record" = alloca' not in text
    assert '%"values" = alloca' not in text


def test_an_answer_is_found_once_for_the_same_arguments_and_an_error_or_none_again():
    asked = []

    def ask(owner, values, more):
        asked.append((owner, values, more))
        return 1.0 / values[0] if values[0] > -1.0 else None

    answer = _remembered(ask, 1)
    assert [answer("a", (2.0,), {}), answer("b", (2.0,), {}), answer("b", (2.0,), {"by": 1})] == [0.5] * 3
    assert len(asked) == 2  # the owner does not count, a keyword does
    assert [answer("a", [4.0], {}), answer("a", [4.0], {})] == [0.25, 0.25]
    assert len(asked) == 4  # a list has no hash
    assert [answer("a", (-2.0,), {}), answer("a", (-2.0,), {})] == [None, None]
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            answer("a", (0.0,), {})
    assert len(asked) == 8


def test_numba_is_left_as_it_was_after_an_entry_that_calls_an_entry_is_compiled():
    jit.start()
    before = [getattr(owner, name) for owner, name, _ in _ANSWERS]
    once = jit.entry_kernel(lambda value: value + value)
    assert jit.entry_kernel(lambda value: 1.0 + once(value))(2.0) == 5.0
    assert [getattr(owner, name) for owner, name, _ in _ANSWERS] == before
