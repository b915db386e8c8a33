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

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.base.exact_jit import Integers, exact_kernel
from drill_twin.base.numpy_loops import absolute, arctan2, complex_total, product, quotient, square, total
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import MOVING, History, bins_in, end_of
from drill_twin.whirl.orbit.orbit import WINDOW
from drill_twin.whirl.row_sums import complex_sum_rows, sum_rows

PLANARITY, SECOND_LOBE = 0, 1
"""Indices into `StringShape.numbers`."""


class StringShape(NamedTuple):
    """Radii and phases of the marks relative to the mark with the largest motion."""

    reference: Integers  # (1,) mark with the largest motion
    power: Array  # (m,) of each mark's motion over the window [m^2], a sum over its bins
    phase: Array  # (m,) relative to the reference mark [rad]
    numbers: Array
    levels: Integers  # one mark at each distance from the bit, from the bit up
    powers: Array  # (WINDOW, m) work
    turned: ComplexArray  # (WINDOW, m) work
    row: ComplexArray  # (m,) work
    work: ComplexArray  # (2, levels)
    size: Array  # (levels,) work
    single: ComplexArray  # (1,) work

    @classmethod
    def of(cls, m: int, levels: Integers) -> StringShape:
        """Shape before the first bin."""
        return cls(
            np.zeros(1, np.int64), np.zeros(m), np.full(m, math.nan), np.array([math.nan, 0.0]), levels,
            np.zeros((WINDOW, m)), np.zeros((WINDOW, m), complex), np.zeros(m, complex),
            np.zeros((2, levels.size), complex), np.zeros(levels.size), np.zeros(1, complex),
        )  # fmt: skip

    @property
    def planarity(self) -> float:
        """1 = in one plane, 0 = a circle."""
        return float(self.numbers[PLANARITY])

    @property
    def second_lobe(self) -> float:
        """Smaller over larger of the largest radii on the two sides of the axis, in the plane of the reference mark."""
        return float(self.numbers[SECOND_LOBE])


@exact_kernel
def find_shape(shape: StringShape, history: History, criteria: Criteria) -> None:
    """Estimate the shape with the newest bin."""
    n, end = bins_in(history, criteria.orbit_window), end_of(history)
    m, parts, row, work, size = shape.power.size, history.complex_part, shape.row, shape.work, shape.size
    for i in range(n):
        for k in range(m):
            moving = parts[end - n + i, MOVING, k]
            shape.powers[i, k] = moving.real * moving.real + moving.imag * moving.imag
    sum_rows(shape.powers[:n], shape.power)
    reference = 0
    for k in range(1, m):
        if not shape.power[k] <= shape.power[reference] and not math.isnan(shape.power[reference]):
            reference = k
    shape.reference[0] = reference
    largest = shape.power[reference]
    if largest <= 0.0:
        shape.phase[:] = math.nan
        shape.numbers[PLANARITY], shape.numbers[SECOND_LOBE] = math.nan, 0.0
        return
    for i in range(n):
        row[:] = parts[end - n + i, MOVING, reference].conjugate()
        product(row, parts[end - n + i, MOVING], shape.turned[i])
    complex_sum_rows(shape.turned[:n], row)
    shape.turned[0, :] = largest
    quotient(row, shape.turned[0], row)
    arctan2(row.imag, row.real, shape.phase)
    this, other = 0.0, 0.0
    for i in range(size.size):
        work[0, i] = row[shape.levels[i]]
        this, other = max(this, work[0, i].real), max(other, -work[0, i].real)
    square(work[0], work[1])
    work[1, 0] = complex_total(work[1], shape.single)
    absolute(work[0], size)
    for i in range(size.size):
        size[i] *= size[i]
    powers = total(size, shape.single.real)
    absolute(work[1, :1], size[:1])
    shape.numbers[PLANARITY] = size[0] / powers
    shape.numbers[SECOND_LOBE] = min(this, other) / max(this, other, 1e-300)
