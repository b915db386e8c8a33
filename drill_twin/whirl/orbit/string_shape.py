# SPDX-License-Identifier: Apache-2.0
"""The shape of the turning string, as far as a few marks show it.

The covariance of the marks' moving parts over the last two revolutions, C_ij = sum conj(M_i) M_j, holds their radii
and their angles against each other, whatever the precession. The row of the largest mark is the shape s (one step of
a power iteration, exact when the string turns as one body). Its planarity |sum s^2| / sum |s|^2 is 1 for a curve in
one plane through the axis and 0 for a circle.

Marks half a helix pitch apart look like a plane: a helix is seen only where marks are closer than that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import MOVING, History
from drill_twin.whirl.marks import MarkInfo


class Shape:
    """Radii and angles of the marks against the largest."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria) -> None:
        m = len(marks)
        self._criteria = criteria
        heights = sorted({mark.distance_from_bit for mark in marks})
        self._level = [[mark.distance_from_bit for mark in marks].index(height) for height in heights]
        """One mark at each height, from the bit up."""
        self.leader = 0
        """Mark with the largest motion."""
        self.power = np.zeros(m)
        """Power of each mark's motion over the window [m^2], a sum over its bins."""
        self.phase = np.full(m, math.nan)
        """Angle against the leader [rad]."""
        self.planarity = math.nan
        """1 = in one plane, 0 = a circle."""
        self.sides = 0.0
        """Smallest over largest of the largest radii on the two sides of the axis, in the plane of the leader."""

    def update(self, history: History) -> None:
        """Takes the newest bin into account."""
        window = history.newest(history.span(self._criteria.orbit_window))
        moving = history.vector[window, MOVING]
        power = (moving.real**2 + moving.imag**2).sum(axis=0)
        self.power = power
        self.leader = int(np.argmax(power))
        largest = float(power[self.leader])
        if largest <= 0.0:
            self.phase = np.full_like(self.phase, math.nan)
            self.planarity, self.sides = math.nan, 0.0
            return
        row = (moving[:, self.leader].conj()[:, None] * moving).sum(axis=0) / largest
        self.phase = np.arctan2(row.imag, row.real)
        levels = row[self._level]
        self.planarity = float(np.abs((levels**2).sum()) / (np.abs(levels) ** 2).sum())
        this, other = max(0.0, float(levels.real.max())), max(0.0, float(-levels.real.min()))
        self.sides = min(this, other) / max(this, other, 1e-300)

    @property
    def heights(self) -> int:
        """Number of different heights with a mark."""
        return len(self._level)
