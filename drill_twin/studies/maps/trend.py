# SPDX-License-Identifier: Apache-2.0
"""Trend of a motion at the end of a run, and what it becomes in the time asked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array

UNCHANGED = 1.1
"""Change between two stretches up to which a motion that is large already does not grow."""
FLOOR = 1e-6
"""Share of the limit below which a size is taken for this: there it is round-off, which has no trend."""
LARGEST = 700.0
"""Largest exponent of a growth."""


@dataclass(frozen=True)
class Trend:
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
        """Growth of the largest of them [1/s]; NaN where there is none."""
        before, now = float(self.before.max()), float(self.now.max())
        return math.log(now / before) / self.apart if before > 0.0 and now > 0.0 else math.nan

    def reaches(self, limit: float, ahead: float) -> bool:
        """One of them, growing on at its rate, is larger than a limit in a time ahead [s].

        One that is larger already counts where it grew by more than `UNCHANGED`.
        """
        before, now = (np.maximum(size, FLOOR * limit) for size in (self.before, self.now))
        change = np.log(now / before)
        then = now * np.exp(np.clip(change / self.apart * ahead, -LARGEST, LARGEST))
        grows = np.where(now < limit, then >= limit, change > math.log(UNCHANGED))
        return bool(np.any(grows))
