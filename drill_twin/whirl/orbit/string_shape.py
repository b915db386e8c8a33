# SPDX-License-Identifier: Apache-2.0
"""Shape of the rotating string, as far as a few marks show it.

The covariance of the marks' moving parts over the last two revolutions, C_ij = sum conj(M_i) M_j, contains their radii
and relative phases, whatever the precession. The row of the mark with the largest motion is the shape s (one step of a
power iteration, exact when the string rotates as one body). Its planarity |sum s^2| / sum |s|^2 is 1 for a curve in one
plane through the axis and 0 for a circle.

Marks half a helix pitch apart lie in a plane: a helix is detected only where marks are closer than that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import MOVING, History
from drill_twin.whirl.marks import MarkInfo


class StringShape:
    """Radii and phases of the marks relative to the mark with the largest motion."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria) -> None:
        m = len(marks)
        self._criteria = criteria
        distances = [mark.distance_from_bit for mark in marks]
        self._levels = [distances.index(level) for level in sorted(set(distances))]
        """One mark at each level, from the bit up."""
        self.reference = 0
        """Mark with the largest motion."""
        self.power = np.zeros(m)
        """Power of each mark's motion over the window [m^2], a sum over its bins."""
        self.phase = np.full(m, math.nan)
        """Phase relative to the reference mark [rad]."""
        self.planarity = math.nan
        """1 = in one plane, 0 = a circle."""
        self.second_lobe = 0.0
        """Smaller over larger of the largest radii on the two sides of the axis, in the plane of the reference mark."""

    def update(self, history: History) -> None:
        """Estimate the shape with the newest bin."""
        window = history.newest(history.bins_in(self._criteria.orbit_window))
        moving = history.vector[window, MOVING]
        power = (moving.real**2 + moving.imag**2).sum(axis=0)
        self.power = power
        self.reference = int(np.argmax(power))
        largest = float(power[self.reference])
        if largest <= 0.0:
            self.phase = np.full_like(self.phase, math.nan)
            self.planarity, self.second_lobe = math.nan, 0.0
            return
        row = (moving[:, self.reference].conj()[:, None] * moving).sum(axis=0) / largest
        self.phase = np.arctan2(row.imag, row.real)
        shape = row[self._levels]
        self.planarity = float(np.abs((shape**2).sum()) / (np.abs(shape) ** 2).sum())
        this, other = max(0.0, float(shape.real.max())), max(0.0, float(-shape.real.min()))
        self.second_lobe = min(this, other) / max(this, other, 1e-300)

    @property
    def levels(self) -> int:
        """Number of different distances from the bit with a mark."""
        return len(self._levels)
