# SPDX-License-Identifier: Apache-2.0
"""Impacts on the wall, and stick-slip, of the section of a sub, reading by reading.

An impact changes the velocity within a small part of a revolution; an orbit turns it slowly. The change over 1/32
revolution, at least a reading, is compared with the mean of the changes before and after: an impact begins where change
and mean differ by more than a share of the clearance times the rotation, and by more than noise. It ends after 1/16
revolution without such a difference.

The gyroscope gives the speed, and so the share of the time at rest. What it means for the radial accelerometer,
r Omega^2, tells whether radius and scale are right: the regression of the radial acceleration on the square of the
speed has the slope r.
"""

import math
from collections import deque

from drill_twin.whirl import criteria
from drill_twin.whirl.downhole.high_pass import ToolNoise

SHARE = 0.05
"""Least change of velocity over clearance times rotation [-]; chosen, not measured."""
NOISE_FACTOR = 7.0
"""Least change over its standard deviation by noise; with 7, once in 10^10 readings."""
LARGEST_COUNT = 100_000
"""Most impacts whose time and peak are kept; later ones are counted only. They take some 6 MB;
chosen, not measured."""
PART, MOST_READINGS = 1.0 / 32.0, 50
"""Part of a revolution over which the velocity changes [rev], and most readings in it,
which bound the memory; chosen, not measured."""
_SPREAD = 1.5**0.5  # of a reading less the mean of two: root of the sum of 1 + 1/4 + 1/4


class ImpactCounter:
    """Counts impacts and their peaks."""

    def __init__(self, clearance: float, noise: ToolNoise) -> None:
        """Begin before the first reading; clearance of the section [m]."""
        self._clearance, self._noise = clearance, NOISE_FACTOR * _SPREAD * noise.force
        self._velocity: deque[complex] = deque([0j], maxlen=3 * MOST_READINGS + 1)
        self._acceleration: deque[complex] = deque(maxlen=3 * MOST_READINGS)
        self._last, self._largest = -1.0, 0.0
        self.count = 0
        """Impacts so far."""
        self.times: list[float] = []
        """Times of the impacts [s]."""
        self.peaks: list[float] = []
        """Largest lateral acceleration of each impact, over its readings [m/s^2]."""
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
            time: End of the reading [s].
            acceleration: Lateral acceleration in the frame of the hole [m/s^2].
            speed: Speed of rotation [rad/s].
            interval: Length of the reading [s].
        """
        self.seconds += interval
        velocity = self._velocity
        velocity.append(velocity[-1] + acceleration * interval)
        self._acceleration.append(acceleration)
        n = min(max(1, round(PART * math.tau / max(abs(speed) * interval, 1e-9))), MOST_READINGS)
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


VARIES = 0.2
"""Least standard deviation of the square of the speed over its mean for the check; chosen, not measured."""
KNOWN = 0.1
"""Largest standard error of the radius, over the radius, for it to be reported; chosen, not measured."""


class TorsionEstimator:
    """Sums over the readings of a section."""

    def __init__(self) -> None:
        self._stick_slip = self._at_rest = 0.0
        self._sums = [0.0] * 6

    def push(self, speed: float, radial: float, interval: float) -> None:
        """Add a reading: speed [rad/s], radial specific force [m/s^2], length [s]."""
        square = speed * speed
        terms = 1.0, square, -radial, square * square, -square * radial, radial * radial
        self._sums = [total + interval * term for total, term in zip(self._sums, terms, strict=True)]
        self._samples = self._sums[0] / interval

    def push_sticking(self, speed: float, mean: float, interval: float) -> None:
        """Add a low-passed speed and its slow mean [rad/s] during stick-slip."""
        self._stick_slip += interval
        self._at_rest += interval * (math.copysign(1.0, mean) * speed < criteria.STANDSTILL * abs(mean))

    @property
    def share_at_rest(self) -> float | None:
        """Share of the time of stick-slip in which the section is at rest; None without stick-slip."""
        return self._at_rest / self._stick_slip if self._stick_slip > 0.0 else None

    @property
    def radius(self) -> float | None:
        """Distance of the sensor from the axis by its readings [m]; None where the speed varies too little."""
        total, *sums = self._sums
        if not total:
            return None
        mean, radial, squares, products, powers = (part / total for part in sums)
        spread, shared = squares - mean * mean, products - mean * radial
        if spread <= (VARIES * mean) ** 2:
            return None
        slope = shared / spread
        rest = max(powers - radial * radial - slope * shared, 0.0)
        known = math.sqrt(rest / spread / self._samples) < KNOWN * abs(slope)
        return slope if known else None
