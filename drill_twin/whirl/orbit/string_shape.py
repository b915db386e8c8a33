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
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import MOVING, NEGLIGIBLE, POSITION, History, bins_in, end_of

PLANARITY, SECOND_LOBE = 0, 1
"""Indices into `StringShape.numbers`."""


class StringShape(NamedTuple):
    """Radii and phases of the marks relative to the mark with the largest motion."""

    reference: Integers  # (1,) mark with the largest motion
    power: Array  # (m,) of each mark's motion over the window [m^2], a sum over its bins
    phase: Array  # (m,) relative to the reference mark [rad]
    numbers: Array
    levels: Integers  # one mark at each distance from the bit, from the bit up
    relative: ComplexArray  # (m,) work: motion of the marks over that of the reference

    @classmethod
    def of(cls, m: int, levels: Integers) -> StringShape:
        """Shape before the first bin."""
        return cls(
            np.zeros(1, np.int64), np.zeros(m), np.full(m, math.nan), np.array([math.nan, 0.0]), levels,
            np.zeros(m, complex),
        )  # fmt: skip

    @property
    def planarity(self) -> float:
        """1 = in one plane, 0 = a circle."""
        return float(self.numbers[PLANARITY])

    @property
    def second_lobe(self) -> float:
        """Smaller over larger of the largest radii on the two sides of the axis, in the plane of the reference mark."""
        return float(self.numbers[SECOND_LOBE])


@strict_kernel
def find_shape(shape: StringShape, history: History, criteria: Criteria) -> None:
    """Estimate the shape with the newest bin."""
    n, end = bins_in(history, criteria.orbit_window), end_of(history)
    moving, position = history.complex_part[end - n : end, MOVING], history.complex_part[end - n : end, POSITION]
    reference, negligible = 0, 0.0
    for k in range(shape.power.size):
        shape.power[k] = 0.0
        for i in range(n):
            shape.power[k] += abs(moving[i, k]) ** 2
            negligible = max(negligible, n * (NEGLIGIBLE * abs(position[i, k])) ** 2)
        # Of marks that move alike the first is the reference, whatever the round-off.
        if not shape.power[k] <= (1.0 + NEGLIGIBLE) * shape.power[reference] and not math.isnan(shape.power[reference]):
            reference = k
    shape.reference[0] = reference
    largest = shape.power[reference]
    if largest <= negligible:
        shape.phase[:] = math.nan
        shape.numbers[PLANARITY], shape.numbers[SECOND_LOBE] = math.nan, 0.0
        return
    for k in range(shape.power.size):
        relative = 0j
        for i in range(n):
            relative += moving[i, reference].conjugate() * moving[i, k]
        shape.relative[k] = relative / largest
        shape.phase[k] = math.atan2(relative.imag, relative.real)
    this, other, squares, powers = 0.0, 0.0, 0j, 0.0
    for level in shape.levels:
        relative = shape.relative[level]
        this, other = max(this, relative.real), max(other, -relative.real)
        squares += relative * relative
        powers += abs(relative) ** 2
    shape.numbers[PLANARITY] = abs(squares) / powers
    shape.numbers[SECOND_LOBE] = min(this, other) / max(this, other, 1e-300)
