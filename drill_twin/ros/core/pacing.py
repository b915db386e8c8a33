# SPDX-License-Identifier: Apache-2.0
"""Wall time: frames at their times, what happens when the machine cannot keep up, and what is due once a while."""

from __future__ import annotations

import time

_LONGEST_SLEEP = 0.05  # s; a signal waits no longer than this


class Pacer:
    """Holds a loop to one frame every `period` seconds of wall time.

    A late frame is counted as an overrun and the next one comes sooner, so that the mean rate holds. Once the loop is
    further behind than `patience`, the lost time is given up, counted, and pacing starts afresh: simulated time then
    falls behind the wall clock, instead of ever more frames being rushed out.
    """

    def __init__(self, period: float, patience: float = 0.2) -> None:
        self._period = period
        self._patience = patience
        self._deadline: float | None = None
        self.overruns = 0
        """Frames that were not ready at their time."""
        self.given_up = 0.0
        """Wall time by which simulated time has fallen behind for good [s]."""

    def restart(self) -> None:
        """Forget the past: the next frame is on time."""
        self._deadline = None

    def wait(self) -> None:
        """Sleep until the next frame is due; returns at once when it is late."""
        now = time.monotonic()
        if self._deadline is None:
            self._deadline = now
        self._deadline += self._period
        late = now - self._deadline
        if late > 0.0:
            self.overruns += 1
            if late > self._patience:
                self.given_up += late
                self._deadline = now
            return
        while (left := self._deadline - time.monotonic()) > 0.0:
            time.sleep(min(left, _LONGEST_SLEEP))


class Tick:
    """True once every `period` seconds of wall time."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._next = time.monotonic()

    def due(self) -> bool:
        """Whether the period has passed since it was last due."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = max(self._next + self._period, now)
        return True
