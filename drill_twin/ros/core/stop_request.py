# SPDX-License-Identifier: Apache-2.0
"""Request to stop, set by SIGINT or SIGTERM; imports nothing that takes long, so that signals are caught first."""

from __future__ import annotations

import ctypes
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from drill_twin.core.process import is_unraisable

END_WITH_PARENT = "DRILL_TWIN_END_WITH_PARENT"
"""Variable of the environment that asks a node to end once the process that started it has: the id of that process."""
_RETRY = 0.02  # s until a signal that came during an import is handled again
_REPEAT = 2.0  # s until Stopped is raised again, where what was called has swallowed it
_SET_PARENT_DEATH_SIGNAL = 1  # linux/prctl.h


class Stopped(BaseException):
    """Raised by a signal during the start of a node; not an Exception, so that no handler of those swallows it."""


class StopRequest:
    """Flag that becomes true once, on SIGINT or SIGTERM, or with the end of the parent where `END_WITH_PARENT` is set.

    Within `with request.at_once():` a signal ends the block immediately, and again where something swallows that.
    """

    def __init__(self) -> None:
        self._requested = False
        self._at_once = False
        self._timer_set = False
        self._parent: int | None = None

    def __bool__(self) -> bool:
        # A launcher that is killed, or whose signal came to nothing, asks no second time.
        return self._requested or (self._parent is not None and os.getppid() != self._parent)

    def set(self) -> None:
        """Request the stop, as a signal would."""
        self._requested = True

    def install(self) -> None:
        """Handle both signals; possible in the main thread of a process only."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):  # the last one is the timer's, see _RETRY
            signal.signal(number, self._on_signal)
        if starter := os.environ.get(END_WITH_PARENT):
            ctypes.CDLL(None, use_errno=True).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGTERM)
            self._parent = os.getppid()
            # It may have ended while this process began: no signal tells that. A wrapper may stand between them.
            if starter != str(self._parent) and (self._parent == 1 or not Path("/proc", starter).exists()):
                self._requested = True

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
            if self:
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
        self._timer_set = True
        signal.setitimer(signal.ITIMER_REAL, _RETRY if is_unraisable(frame) else _REPEAT)
        if not is_unraisable(frame):
            raise Stopped
