# SPDX-License-Identifier: Apache-2.0
"""Dominant precession of a long run, in bounded memory.

Each bin adds (radius / clearance)^2 x its duration to a histogram over the precession ratio, which becomes the power of
the motion by ratio. The dominant ratio is the centroid of the cells around the highest peak: a run that alternates
between forward whirl and backward rolling gets the ratio of the stronger one, not the mean of both.
"""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array

WIDTH = 0.02
"""Width of a cell, in precession over rotation."""
LARGEST_RATIO = 6.0
"""Largest ratio; larger ones are counted in the outermost cells."""
CELLS = 2 * round(LARGEST_RATIO / WIDTH)
PEAK_CELLS = 3
"""Cells on each side of the peak that belong to it."""


class DominantPrecession:
    """Histogram of the power of each mark's motion over its precession ratio."""

    def __init__(self, marks: int) -> None:
        self._sums = np.zeros((3, marks, CELLS))  # weight, weight x ratio, weight x precession
        self._marks = np.arange(marks)

    def add(self, ratio: Array, precession: Array, radius: Array, seconds: float) -> None:
        """Add a bin: ratio, precession [rev/s], radius over the clearance, shape (m,); nan ratios add nothing."""
        weight = radius * radius * seconds
        known = np.isfinite(ratio) & (weight > 0.0)
        if not known.any():
            return
        weight = np.where(known, weight, 0.0)
        finite_ratio = np.where(known, ratio, 0.0)
        cell = np.clip(((finite_ratio + LARGEST_RATIO) / WIDTH).astype(np.intp), 0, CELLS - 1)
        self._sums[0, self._marks, cell] += weight
        self._sums[1, self._marks, cell] += weight * finite_ratio
        self._sums[2, self._marks, cell] += weight * np.where(known, precession, 0.0)

    def peak(self) -> tuple[int, float, float] | None:
        """Mark with the largest power, its dominant ratio and precession [rev/s]; None if nothing was added."""
        total = self._sums[0].sum(axis=1)
        mark = int(np.argmax(total))
        if total[mark] <= 0.0:
            return None
        weight = self._sums[0, mark]
        smooth = np.convolve(weight, np.ones(2 * PEAK_CELLS + 1), mode="same")
        centre = int(np.argmax(smooth))
        around = slice(max(0, centre - PEAK_CELLS), centre + PEAK_CELLS + 1)
        power = float(weight[around].sum())
        ratio = float(self._sums[1, mark, around].sum()) / power
        return mark, ratio, float(self._sums[2, mark, around].sum()) / power
