# SPDX-License-Identifier: Apache-2.0
"""Impacts on the wall from the lateral acceleration of a section, reading by reading.

An impact changes the velocity within a small part of a revolution; an orbit turns it slowly. The change over 1/32
revolution, at least a reading, is compared with the mean of those before and after: an impact begins where they differ
by more than a share of the clearance times the rotation, or than by noise. It ends after 1/16 revolution without.
"""

from __future__ import annotations

import math
from collections import deque

from drill_twin.whirl.downhole.high_pass import ToolNoise

SHARE = 0.05
"""Least change of velocity over clearance times rotation [-]."""
NOISE_FACTOR = 7.0
"""Least change over its standard deviation by noise; with 7, once in 10^10 readings."""
LARGEST_COUNT = 100_000
"""Most impacts whose time and peak are kept; later ones are counted only."""
PART, LONGEST = 1.0 / 32.0, 50
"""Part of a revolution over which the velocity changes [rev], and most readings in it."""
_SPREAD = 1.5**0.5  # of a reading less the mean of two others, over the noise of one


class ImpactCounter:
    """Counts impacts and their peaks."""

    def __init__(self, clearance: float, noise: ToolNoise) -> None:
        """Begin before the first reading; clearance of the section [m]."""
        self._clearance, self._noise = clearance, NOISE_FACTOR * _SPREAD * noise.force
        self._velocity: deque[complex] = deque([0j], maxlen=3 * LONGEST + 1)
        self._acceleration: deque[complex] = deque(maxlen=3 * LONGEST)
        self._last, self._largest = -1.0, 0.0
        self.count = 0
        """Impacts so far."""
        self.times: list[float] = []
        """Their times [s]."""
        self.peaks: list[float] = []
        """Largest lateral acceleration of each, over its readings [m/s^2]."""
        self.seconds = 0.0
        """Time observed [s]."""

    def restart(self) -> None:
        """Go on after a gap."""
        self._acceleration.clear()
        self._velocity.clear()
        self._velocity.append(0j)

    def push(self, time: float, acceleration: complex, speed: float, interval: float) -> None:
        """Add a reading.

        Args:
            time: Its end [s].
            acceleration: Lateral acceleration in the frame of the hole [m/s^2].
            speed: Speed of rotation [rad/s].
            interval: Its length [s].
        """
        self.seconds += interval
        velocity = self._velocity
        velocity.append(velocity[-1] + acceleration * interval)
        self._acceleration.append(acceleration)
        n = min(max(1, round(PART * math.tau / max(abs(speed) * interval, 1e-9))), LONGEST)
        if len(velocity) <= 3 * n:
            return
        last, later, earlier, first = (velocity[-1 - k * n] for k in range(4))
        change = abs(later - earlier - 0.5 * (last - later + earlier - first))
        noise = self._noise * math.sqrt(n) * interval
        if change <= max(SHARE * self._clearance * abs(speed), noise):
            return
        at = time - 1.5 * n * interval
        again, self._last = at - self._last <= 2.0 * n * interval and self.count > 0, at
        if not again:
            self.count += 1
            self._largest = 0.0
        if change <= self._largest or self.count > LARGEST_COUNT:
            return
        del self.times[self.count - 1 :], self.peaks[self.count - 1 :]
        self._largest = change
        self.times.append(at)
        self.peaks.append(max(abs(self._acceleration[-1 - k]) for k in range(n, 2 * n)))
