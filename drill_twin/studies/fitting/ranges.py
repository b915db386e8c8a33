# SPDX-License-Identifier: Apache-2.0
"""Ranges of free numbers: uniform in value, in the logarithm where both ends are positive and far apart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array

Ranges = Mapping[str, tuple[float, float]]
"""Lowest and highest value [SI] by key."""
LOGARITHMIC = 20.0
"""Ratio of a range's ends from which it is uniform in the logarithm."""


def in_ranges(cube: Array, ranges: Ranges) -> Array:
    """Values [SI] at positions in the unit cube, both of shape (N, d)."""
    columns = []
    for position, (low, high) in zip(cube.T, ranges.values(), strict=True):
        logarithmic = low > 0.0 and high >= LOGARITHMIC * low
        columns.append(low * (high / low) ** position if logarithmic else low + (high - low) * position)
    return np.array(columns).T
