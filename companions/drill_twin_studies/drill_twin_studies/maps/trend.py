# SPDX-License-Identifier: Apache-2.0
"""Growth of a motion from one stretch of time to the next."""

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array

UNCHANGED = 1.1
"""Ratio of two stretches up to which a motion that is large already does not grow; not measured."""
FLOOR = 1e-6
"""Share of the limit that smaller sizes are raised to: below it they are round-off, which has no trend; not
measured."""
LARGEST = 700.0
"""Largest exponent of a growth: exp(709.8) is the largest double."""


class Trend(NamedTuple):
    """Sizes in two stretches of time, one after the other.

    Attributes:
        before: Sizes in the first, shape (n,).
        now: Sizes in the second, shape (n,).
        apart: Time from one to the other [s].
    """

    before: Array
    now: Array
    apart: float

    @property
    def rate(self) -> float:
        """Growth of the largest size [1/s]; NaN where there is none."""
        before, now = float(self.before.max()), float(self.now.max())
        return math.log(now / before) / self.apart if before > 0.0 and now > 0.0 else math.nan

    def reaches(self, limit: float, ahead: float) -> bool:
        """True if a size that goes on growing at its rate is larger than a limit in a time ahead [s].

        A size that is larger already counts if it grew by more than `UNCHANGED`.
        """
        before, now = (np.maximum(size, FLOOR * limit) for size in (self.before, self.now))
        change = np.log(now / before)
        then = now * np.exp(np.clip(change / self.apart * ahead, -LARGEST, LARGEST))
        grows = np.where(now < limit, then >= limit, change > math.log(UNCHANGED))
        return bool(np.any(grows))
