# SPDX-License-Identifier: Apache-2.0
"""Request to stop, set by SIGINT or SIGTERM; imports nothing that takes long, so that signals are caught first."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from drill_twin.base.process.unraisable import is_unraisable

_RETRY = 0.02  # s until a signal that came during an import is handled again


class Stopped(BaseException):
    """Raised by a signal during the start of a node; not an Exception, so that no handler of those swallows it."""


class StopRequest:
    """Flag that becomes true once, on SIGINT or SIGTERM.

    Within `with request.at_once():` a signal ends the block immediately.
    """

    def __init__(self) -> None:
        self._requested = False
        self._at_once = False
        self._timer_set = False

    def __bool__(self) -> bool:
        return self._requested

    def set(self) -> None:
        """Request the stop, as a signal would."""
        self._requested = True

    def install(self) -> None:
        """Handle both signals; possible in the main thread of a process only."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):  # the last one is the timer's, see _RETRY
            signal.signal(number, self._on_signal)

    @staticmethod
    def ignore_signals() -> None:
        """Ignore both signals from now on: a second one must not change the exit code of a node that has ended."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Context in which a signal raises Stopped: for long work that needs no completion.

        Raises:
            Stopped: The stop was requested, now or before.
        """
        self._at_once = True
        try:
            if self._requested:
                raise Stopped
            yield
        finally:
            self._at_once = False
            if self._timer_set:  # it must not fire once the interpreter is gone
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                self._timer_set = False

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        del number
        self._requested = True
        if not self._at_once:
            return
        if is_unraisable(frame):
            self._timer_set = True
            signal.setitimer(signal.ITIMER_REAL, _RETRY)
            return
        self._at_once = False
        raise Stopped
