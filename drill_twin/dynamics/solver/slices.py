# SPDX-License-Identifier: Apache-2.0
"""Slices of the time loop: the compiled function returns after some work, and Python decides whether it goes on.

Compiled code neither handles a signal nor sees a request to stop. So it pauses between two attempts of a step, and goes
on from there when it is called again: the same instructions in the same order, so the same bits.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np

from drill_twin.core.arrays import Array

WORK = 250_000
"""Newton iterations times elements of a slice: about 0.2 s of the spatial form, 0.03 s of the lateral one."""

_CHECK: ContextVar[Callable[[], None] | None] = ContextVar("check", default=None)


@contextmanager
def checked(check: Callable[[], None]) -> Iterator[None]:
    """Context in which a function is called between slices, in this thread; what it raises ends the frame."""
    token = _CHECK.set(check)
    try:
        yield
    finally:
        _CHECK.reset(token)


def call_check() -> None:
    """Call the function of `checked`, if there is one."""
    check = _CHECK.get()
    if check is not None:
        check()


def make_progress() -> Array:
    """Progress of an advance that has not begun, in a slice without end; see `drill_twin.dynamics.solver.state`."""
    return np.array([np.inf, 0.0, 0.0, 0.0, 0.0])


def iterations_of(elements: int) -> float:
    """Newton iterations of a slice, for a number of elements."""
    return float(max(1, WORK // elements))
