# SPDX-License-Identifier: Apache-2.0
"""Compilations by numba in this thread: counted, or refused where all machine code is expected in the cache."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

_EVENTS: Any = import_module("numba.core.event")
_LISTENER: Any = _EVENTS.Listener
_COMPILE = "numba:compile"


class NotCachedError(Exception):
    """A function is not in the cache of compiled kernels."""


class _Listener(_LISTENER):  # type: ignore[misc]
    """Calls a function before each compilation in the thread that made it."""

    def __init__(self, started: Callable[[], None]) -> None:
        self._started = started
        self._thread = threading.get_ident()

    def on_start(self, event: Any) -> None:
        """Call the function."""
        del event
        if threading.get_ident() == self._thread:
            self._started()

    def on_end(self, event: Any) -> None:
        """No-op: a compilation is counted when it begins."""


@contextmanager
def before_each_compilation(started: Callable[[], None]) -> Iterator[None]:
    """Context in which a function is called before each function that numba compiles, inlined ones included."""
    listener = _Listener(started)
    _EVENTS.register(_COMPILE, listener)
    try:
        yield
    finally:
        _EVENTS.unregister(_COMPILE, listener)


@contextmanager
def from_cache_only() -> Iterator[None]:
    """Context in which nothing is compiled.

    Raises:
        NotCachedError: A function was called whose machine code is not in the cache.
    """

    def refuse() -> None:
        raise NotCachedError

    with before_each_compilation(refuse):
        yield
