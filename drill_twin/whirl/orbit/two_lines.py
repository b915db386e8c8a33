# SPDX-License-Identifier: Apache-2.0
"""The two strongest lines of a motion, and the share of its power that neither of them has.

Two whirls at once, and an ellipse, change their radius and their pace in every turn, and yet are regular: each is two
turns exp(i omega t) of steady rate. The lines are found on a grid of rates, half a line's width apart, one after the
other; then each is refined beside the other. What is left is irregular.
"""

import math

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import ASYNCHRONOUS, end_of

FEWEST = 32
"""Fewest bins, two revolutions: fewer cannot tell two lines from a change of one."""
REFINED = 4
"""Times that each line is refined; a further time changes the rates by less than 1e-3 of a width (`test_kinds`)."""
BAND = 0.45
"""Largest rate on the grid, in turns in a bin: a little less than half a turn, where the senses cannot be told."""


@strict_kernel
def find_lines(history: Columns, k: int, carrier: float, rest: ComplexArray, turn: ComplexArray, lines: Array) -> float:
    """Find the two strongest lines of the asynchronous part of mark k over as many of the newest bins as `rest` has.

    Args:
        history: The bins.
        k: Index of the mark.
        carrier: Rate about which a fast orbit is sought, or 0 [rad/s].
        rest: Work, shape (n,): the motion without the lines [m].
        turn: Work, shape (n,).
        lines: Rate [rad/s] and radius [m] of the lines, the stronger first, shape (2, 2): the result.

    Returns:
        The share of the power in neither, 0 to 1; 1 for fewer than `FEWEST` bins, or where nothing moves.
    """
    n, end, power = rest.size, end_of(history), 0.0
    first = end - n
    lines[:] = 0.0
    if n < FEWEST or not history.time[end - 1] > history.time[first]:
        return 1.0
    time = history.time[first:end]
    middle, span = 0.5 * (time[0] + time[n - 1]), time[n - 1] - time[0]
    for i in range(n):
        vector, angle = history.vector[first + i, ASYNCHRONOUS, k], -carrier * (time[i] - middle)
        rest[i] = vector * complex(math.cos(angle), math.sin(angle))
        power += vector.real * vector.real + vector.imag * vector.imag
    if power == 0.0:
        return 1.0
    width = math.tau / span
    one = _strongest(rest, time, middle, turn, width)
    size_one = _take(rest, time, middle, one, 0j)
    other = _strongest(rest, time, middle, turn, width)
    size_other = _take(rest, time, middle, other, 0j)
    for _ in range(REFINED):
        _take(rest, time, middle, one, -size_one)
        one = _refined(rest, time, middle, one, 0.25 * width)
        size_one = _take(rest, time, middle, one, 0j)
        _take(rest, time, middle, other, -size_other)
        other = _refined(rest, time, middle, other, 0.25 * width)
        size_other = _take(rest, time, middle, other, 0j)
    if abs(size_other) > abs(size_one):
        one, other, size_one, size_other = other, one, size_other, size_one
    lines[0, 0], lines[0, 1], lines[1, 0], lines[1, 1] = one + carrier, abs(size_one), other + carrier, abs(size_other)
    left = 0.0
    for i in range(n):
        left += rest[i].real * rest[i].real + rest[i].imag * rest[i].imag
    return min(left / power, 1.0)


@strict_kernel
def _strongest(rest: ComplexArray, time: Array, middle: float, turn: ComplexArray, width: float) -> float:
    """Rate of the strongest line on the grid [rad/s]."""
    n, step = rest.size, 0.5 * width
    most = int(2.0 * BAND * n)
    for i in range(n):
        angle = step * most * (time[i] - middle)
        turn[i] = rest[i] * complex(math.cos(angle), math.sin(angle))
    best, strongest = 0.0, -1.0
    for j in range(-most, most + 1):
        total = 0j
        for i in range(n):
            total += turn[i]
        if abs(total) > strongest:
            best, strongest = j * step, abs(total)
        for i in range(n):
            angle = -step * (time[i] - middle)
            turn[i] *= complex(math.cos(angle), math.sin(angle))
    return best


@strict_kernel
def _size(rest: ComplexArray, time: Array, middle: float, rate: float) -> complex:
    """Radius and phase of the line of a rate [rad/s] that fits best [m]."""
    total = 0j
    for i in range(rest.size):
        angle = -rate * (time[i] - middle)
        total += rest[i] * complex(math.cos(angle), math.sin(angle))
    return total / rest.size


@strict_kernel
def _take(rest: ComplexArray, time: Array, middle: float, rate: float, size: complex) -> complex:
    """Take the line of a rate [rad/s] and a size [m], or of the size that fits best where it is 0, from the motion."""
    if size == 0j:
        size = _size(rest, time, middle, rate)
    for i in range(rest.size):
        angle = rate * (time[i] - middle)
        rest[i] -= size * complex(math.cos(angle), math.sin(angle))
    return size


@strict_kernel
def _refined(rest: ComplexArray, time: Array, middle: float, rate: float, step: float) -> float:
    """Rate [rad/s] at the top of the parabola through the powers at a rate and `step` beside."""
    low, here, high = (
        abs(_size(rest, time, middle, rate - step)) ** 2,
        abs(_size(rest, time, middle, rate)) ** 2,
        abs(_size(rest, time, middle, rate + step)) ** 2,
    )
    bend = low - 2.0 * here + high
    if bend >= 0.0:
        return rate
    return rate + step * min(max(0.5 * (low - high) / bend, -1.0), 1.0)  # formula of a parabola's top
