# SPDX-License-Identifier: Apache-2.0
"""Streaming rainflow count of one stress (ASTM E1049-85, 5.4.4), with the damage of each cycle (Miner 1945).

A sample that turns back by less than the smallest range is no turning point. Turning points are kept until their ranges
are closed; the kept ranges decrease from the first range on. As the standard says, a range is one cycle when a range at
least as large follows it, and half a cycle if it contains the first point; ranges left at the end count half. At most
`DEPTH` turning points are kept. Where more would be needed, as after a long decay, the largest kept range counts half
at once, as it would at the end unless a larger range follows.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel

DEPTH = 64
"""Most turning points that are kept."""
EXTREME, DIRECTION, POINTS, CLOSED, CYCLES = range(5)
"""Indices into the memory of a count: latest extreme, NaN before the first sample; 1 upwards, -1 downwards, 0 as long
as neither; turning points kept; damage of the whole cycles; cycles and half cycles that are counted for good."""
MEMORY = 5
LEAST_SHARE = 1e-3
"""Smallest 1 - mean / tensile strength in the correction by the mean stress."""


class Law(NamedTuple):
    """Cycles to failure by stress range: `cycles` (range / `knee`)^-slope, above and below the knee."""

    knee: float  # stress range [Pa]
    cycles: float
    slope: float  # above the knee
    slope_below: float  # 0: no damage
    smallest: float  # range that is counted [Pa]


@kernel
def damage_of(law: Law, one: float, other: float, factor: float, tensile: float) -> float:
    """Damage of a cycle between two stresses [Pa]: 1 / N of the range, a tensile mean after Goodman (1899).

    Args:
        law: S-N curve.
        one: Turning point.
        other: The other one.
        factor: Stress concentration.
        tensile: Tensile strength [Pa]; infinite: no correction.
    """
    share = max(1.0 - max(0.5 * (one + other), 0.0) / tensile, LEAST_SHARE)
    ratio = factor * abs(one - other) / (share * law.knee)
    if ratio >= 1.0:
        return float(ratio**law.slope / law.cycles)
    return float(ratio**law.slope_below / law.cycles) if law.slope_below > 0.0 else 0.0


@kernel
def drop_first(points: Array, halves: Array, count: int) -> None:
    """Drop the first of `count` points; its half cycle stays in `halves`, a sum from the start on."""
    for i in range(count - 1):
        points[i], halves[i] = points[i + 1], halves[i + 1]


@kernel
def add_turning_point(
    law: Law, factor: float, tensile: float, value: float, memory: Array, points: Array, halves: Array
) -> None:
    """Add a turning point [Pa], and close the ranges that it closes."""
    n = int(memory[POINTS])
    if n == DEPTH:
        drop_first(points, halves, n)
        memory[CYCLES] += 0.5
        n -= 1
    while n >= 2 and abs(value - points[n - 1]) >= abs(points[n - 1] - points[n - 2]):
        if n == 2:
            drop_first(points, halves, n)
            memory[CYCLES] += 0.5
            n = 1
        else:
            memory[CLOSED] += 2.0 * (halves[n - 1] - halves[n - 2])
            memory[CYCLES] += 1.0
            n -= 2
    points[n] = value
    halves[n] = halves[n - 1] + 0.5 * damage_of(law, points[n - 1], value, factor, tensile) if n > 0 else 0.0
    memory[POINTS] = n + 1


@kernel
def add_stress(
    law: Law, factor: float, tensile: float, value: float, memory: Array, points: Array, halves: Array
) -> bool:
    """Add a sample of the stress [Pa]; returns whether the extreme before it was a turning point."""
    extreme, direction = memory[EXTREME], memory[DIRECTION]
    if np.isnan(extreme):
        memory[EXTREME] = value
        return False
    back = (extreme - value) * direction if direction != 0.0 else abs(extreme - value)
    if back < law.smallest:
        if back < 0.0:
            memory[EXTREME] = value
        return False
    add_turning_point(law, factor, tensile, extreme, memory, points, halves)
    memory[EXTREME], memory[DIRECTION] = value, 1.0 if value > extreme else -1.0
    return True


@kernel
def total_damage(memory: Array, halves: Array) -> float:
    """Damage so far, including half cycles that may still become whole cycles."""
    n = int(memory[POINTS])
    return float(memory[CLOSED] + (halves[n - 1] if n > 0 else 0.0))


@kernel
def total_cycles(memory: Array) -> float:
    """Cycles so far, as `total_damage`."""
    return float(memory[CYCLES] + 0.5 * max(memory[POINTS] - 1.0, 0.0))
