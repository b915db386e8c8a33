# SPDX-License-Identifier: Apache-2.0
"""Band of a quantity over the members."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array

SHARE = 0.9
"""Probability that a band holds the true value."""


@dataclass(frozen=True)
class Band:
    """Mean, standard deviation, and 90 % band of the members."""

    mean: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Array) -> Band:
        """Band of the values of the members, shape (N,)."""
        low, high = np.quantile(values, (0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE))
        return cls(float(values.mean()), float(values.std(ddof=1)), float(low), float(high))
