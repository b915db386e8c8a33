# SPDX-License-Identifier: Apache-2.0
"""Detection of a run whose simulated time stands still."""

from __future__ import annotations

import time
from collections.abc import Callable

from drill_twin.core.errors import RunError

STARTING_TIME = 150.0  # s
"""Longest time in which the nodes compile and connect."""
_STALL_TIME = 20.0  # s; longest time between two changes of the simulated time


class StallDetector:
    """Ends a run whose simulated time stands still."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._since, self._time = clock(), 0.0

    def check(self, simulated: float, *, compiling: bool = False) -> None:
        """Compare the simulated time with that of the last call.

        Args:
            simulated: Simulated time [s].
            compiling: Whether the simulator says that it compiles: no stall, however long.

        Raises:
            RunError: It has not changed for too long.
        """
        now = self._clock()
        if compiling or simulated != self._time:
            self._since, self._time = now, simulated
        limit = _STALL_TIME if simulated else STARTING_TIME
        if now - self._since > limit:
            raise RunError(f"simulated time has stood at {simulated:.2f} s for {limit:g} s; see the logs of the nodes")
