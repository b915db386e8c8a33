# SPDX-License-Identifier: Apache-2.0
"""Pacing by the wall clock: frames at their times, and periodic actions."""

import time
from collections import deque
from collections.abc import Callable

_LONGEST_SLEEP = 0.05  # s; longest delay of a signal
_MAX_LAG = 0.2  # s; above it a lag is dropped
_DROPS = 100  # drops of lag that are kept; there are at most five a second


class Pacer:
    """Limits a loop to one frame every `period` seconds of wall time.

    A late frame is counted as an overrun and the next one comes sooner, so that the mean rate holds. Once the loop is
    later than 0.2 s, the lag is dropped and counted, and pacing starts afresh: simulated time then falls behind
    the wall clock, and no burst of frames follows.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._deadline: float | None = None
        self.overruns = 0
        """Frames that were not ready at their time."""
        self.lag_dropped = 0.0
        """Dropped lag: wall time by which simulated time has fallen behind for good [s]."""
        self._dropped: deque[tuple[float, float]] = deque(maxlen=_DROPS)  # when [s], and how much [s]
        self._on_time = (0.0, 0.0)  # wall and processor time at the last frame that was on time [s]
        self._late_frames = 0  # since then
        self.share = self.need = 0.0
        """While the last lag grew: processor time of this thread over wall time, and over the time of the frames."""

    def restart(self) -> None:
        """Start afresh: the next frame is on time."""
        self._deadline = None

    def dropped_lag_within(self, seconds: float) -> float:
        """Lag that was dropped in the last seconds [s]."""
        since = time.monotonic() - seconds
        return sum(lag for when, lag in self._dropped if when > since)

    def wait(self, spend: Callable[[float], object] = time.sleep) -> bool:
        """Spend the time until the next frame is due; returns False at once when it is late.

        Args:
            spend: Spends at most a time [s]; given 50 ms at most.
        """
        now = time.monotonic()
        self._deadline = (self._begin(now) if self._deadline is None else self._deadline) + self._period
        late = now - self._deadline
        self._late_frames += 1
        if late > 0.0:
            self.overruns += 1
            if late > _MAX_LAG:
                self._drop(now, late)
            return False
        while self._deadline is not None and (left := self._deadline - time.monotonic()) > 0.0:
            spend(min(left, _LONGEST_SLEEP))
        if self._deadline is not None:  # waking up late is no rest, so the deadline counts
            self._begin(self._deadline)
        return True

    def _begin(self, now: float) -> float:
        """Begin with a frame that is on time."""
        self._deadline, self._on_time, self._late_frames = now, (now, time.thread_time()), 0
        return now

    def _drop(self, now: float, late: float) -> None:
        """Drop the lag, and keep what it came from."""
        wall, processor = self._on_time
        used = time.thread_time() - processor
        self.share, self.need = used / (now - wall), used / (self._late_frames * self._period)
        self.lag_dropped += late
        self._dropped.append((now, late))
        self._begin(now)


class Tick:
    """Timer that is due once every `period` seconds of wall time."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._next = time.monotonic()

    def due(self) -> bool:
        """Return True once the period has passed since it was last due."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next += self._period
        if self._next <= now:  # late by more than a period: the turns that were missed are left out
            self._next = now + self._period
        return True
