# SPDX-License-Identifier: Apache-2.0
"""Stick-slip of the section of a sub beside its cycles: share of the time at rest, and a check by radial acceleration.

The gyroscope gives the speed; what it means for the radial accelerometer, r Omega^2, tells whether radius and scale are
right: the regression of the radial acceleration on the square of the speed has the slope r.
"""

from __future__ import annotations

import math

AT_REST = 0.15
"""At rest: speed below this share of the mean (`whirl.motion.stick_slip`, STICKING)."""
VARIES = 0.2
"""Least standard deviation of the square of the speed over its mean for the check."""
KNOWN = 0.1
"""Largest standard error of the radius, over the radius, for it to be reported."""


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
        self._at_rest += interval * (math.copysign(1.0, mean) * speed < AT_REST * abs(mean))

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
