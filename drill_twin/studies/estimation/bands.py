# SPDX-License-Identifier: Apache-2.0
"""Band of a quantity over the members."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array

SHARE = 0.9
"""Share of the members in a band: the probability of the true value if the members were draws of what is known."""


def held_text(with_sub: bool) -> str:
    """Shares that bands have held on twins with hidden numbers, as measured by `drill-twin estimator-score`."""
    held = "54 to 100 % (by kind of quantity) with a sub" if with_sub else "67 to 100 % (by kind of quantity)"
    return f"low and high hold {SHARE:.0%} of the members; on twins with hidden numbers they held the truth in {held}"


@dataclass(frozen=True)
class Band:
    """Mean, standard deviation, and band of 90 % of the members; how often it holds the truth: `held_text`."""

    mean: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Array) -> Band:
        """Band of the values of the members, shape (N,)."""
        low, high = np.quantile(values, (0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE))
        return cls(float(values.mean()), float(values.std(ddof=1)), float(low), float(high))
