# SPDX-License-Identifier: Apache-2.0
"""Request to stop, set by SIGINT or SIGTERM; imports nothing that takes long, so that signals are caught first."""

import ctypes
import os
import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import FrameType

from drill_twin.core.process import is_unraisable

END_WITH_PARENT = "DRILL_TWIN_END_WITH_PARENT"
"""Variable of the environment that asks a node to end once the process that started it has: the id of that process."""
_RETRY = 0.02  # s until a signal that came during an import is handled again
_REPEAT = 2.0  # s until Stopped is raised again, where what was called has swallowed it
_PATIENCE = 1.0  # s that a loop has to see the request by itself, of the 2 s that a stop may take
_SET_PARENT_DEATH_SIGNAL = 1  # linux/prctl.h


class Stopped(BaseException):
    """Raised by a signal during the start of a node; not an Exception, so that no handler of exceptions swallows it."""


class StopRequest:
    """Flag that becomes true once, on SIGINT or SIGTERM, or with the end of the parent where `END_WITH_PARENT` is set.

    Within `with request.at_once():` a signal ends the block immediately, by an exception that is raised again where
    something has swallowed it; within `with request.soon():` it ends the block that has not seen the request by itself.
    """

    def __init__(self) -> None:
        self._requested = False
        self._patience: float | None = None  # s, in a block
        self._timer_set = False
        self.held = False
        """True while what is being done, such as a record of a bag, must be completed."""
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
            # The starter may have ended while this process began: no signal tells. A wrapper may stand between the two.
            if starter != str(self._parent) and (self._parent == 1 or not Path("/proc", starter).exists()):
                self._requested = True

    @staticmethod
    def ignore_signals() -> None:
        """Ignore both signals from now on: a second one must not change the exit code of a node that has ended."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)

    def at_once(self) -> AbstractContextManager[None]:
        """Context in which a signal raises Stopped: for long work that needs no completion.

        Raises:
            Stopped: The stop was requested, now or before.
        """
        return self._within(0.0)

    def soon(self) -> AbstractContextManager[None]:
        """Context in which a signal raises Stopped a second later: for a loop that asks each turn.

        Raises:
            Stopped: A turn took too long.
        """
        return self._within(_PATIENCE)

    @contextmanager
    def _within(self, patience: float) -> Iterator[None]:
        self._patience = patience
        try:
            if self and not patience:
                raise Stopped
            yield
        finally:
            self._patience = None
            if self._timer_set:  # it must not fire once the interpreter is gone
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                self._timer_set = False

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._requested = True
        if self._patience is None or (self._timer_set and number != signal.SIGALRM and self._patience):
            return
        waits = self._patience if number != signal.SIGALRM else 0.0
        unraisable = self.held or is_unraisable(frame)
        self._timer_set = True
        signal.setitimer(signal.ITIMER_REAL, waits or (_RETRY if unraisable else _REPEAT))
        if not (waits or unraisable):
            raise Stopped
