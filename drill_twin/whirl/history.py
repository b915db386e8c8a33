# SPDX-License-Identifier: Apache-2.0
"""Ring buffer of the last revolutions of the motion, read as contiguous views."""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.compile.jit import any_of, as_python, strict_kernel
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.sample_bins import BINS

CAPACITY = 32 * BINS
"""Bins stored: 32 revolutions or more, for `criteria.LONGEST_SWEEP_WINDOW` and the steady position before it."""
LARGEST_STEP = 0.75
"""Bins farther apart than this [rev] are separated by a gap: the angle between them is not known. Chosen."""
LONGEST_PAUSE = 1.0
"""Bins farther apart than this [s] are separated by a gap, too; chosen, not measured."""
NEGLIGIBLE = 1e-9
"""A part of a motion below this share of the position is round-off, and has no direction."""
LEADING = 0.7
"""Least share of the asynchronous part in a motion that is expected to advance with it; chosen, not measured."""

ASYNCHRONOUS, MOVING, SYNCHRONOUS = range(3)
"""Rows of `vector`: the asynchronous part; position less offset; the same in the rotating frame."""


def new_history(m: int) -> Columns:
    """Empty ring buffer of bins of m marks.

    Each bin is written twice, `CAPACITY` apart, so that the newest n are always contiguous.
    """
    return columns(
        "History",
        2 * CAPACITY,
        time=0.0,  # since the first sample [s]
        angle=0.0,  # of rotation [rad]
        revolutions=0.0,  # since the first sample [rev]
        vector=np.zeros((2 * CAPACITY, 3, m), complex),  # parts of the centre line [m], by the rows above
        position=np.zeros((2 * CAPACITY, m), complex),  # of the marked point [m]
        phasor=np.zeros((2 * CAPACITY, m), complex),  # unit vector of its spin
        unwrapped=np.zeros((2 * CAPACITY, 2, m)),  # angle of the asynchronous and of the moving part [rad]
        contact=np.zeros((2 * CAPACITY, m)),  # share of the bin in contact with the wall
        seen=np.zeros((2 * CAPACITY, m), bool),
        turned=np.zeros(m),  # angle by which each mark was seen to turn [rad], signed: far down it starts after the top
        last_seen=np.zeros(1),  # revolutions at the last bin in which a mark was seen [rev]
        appended=np.zeros(1, np.int64),  # bins in total
        length=np.zeros(1, np.int64),  # bins since the last gap, at most `CAPACITY`
        angle_now=np.zeros((2, m)),  # work: unwrapped angle of the newest bin
    )


def newest(history: Columns, bins: int) -> slice:
    """Index range of the newest bins, oldest first."""
    end = as_python(end_of)(history)
    return slice(end - bins, end)


def newest_in(history: Columns, revolutions: float) -> int:
    """As `bins_in`, called by Python."""
    return int(as_python(bins_in)(history, revolutions))


@strict_kernel
def end_of(history: Columns) -> int:
    """Index after the newest bin."""
    return int((history.appended[0] - 1) % CAPACITY + CAPACITY + 1)


@strict_kernel
def bins_in(history: Columns, revolutions: float) -> int:
    """Number of bins since the last gap within the newest `revolutions` [rev]; at most 4 for each 1/16."""
    end = end_of(history)
    bins = min(history.length[0], int(4 * BINS * revolutions))
    least = history.revolutions[end - 1] - revolutions + 0.5 / BINS
    low, high = end - bins, end
    while low < high:  # as numpy.searchsorted, which imports scipy in compiled code
        middle = (low + high) >> 1
        below = history.revolutions[middle] < least
        low, high = (middle + 1, high) if below else (low, middle)
    return int(end - low)


@strict_kernel
def append(history: Columns, full: Columns, vector: ComplexArray, contact: Array, rate: Array) -> bool:
    """Append a bin, its `vector`, shape (3, m), and `contact`, shape (m,); return whether it follows a gap.

    An orbit of a known `rate` [rad/s], shape (m,), is expected to advance with it, be it by whole turns; 0 where not.
    """
    angle, appended = history.angle_now, history.appended[0]
    gap, last, elapsed = False, end_of(history) - 1, 0.0
    if appended:
        elapsed = full.time[0] - history.time[last]
        gap = full.revolutions[0] - history.revolutions[last] > LARGEST_STEP or elapsed > LONGEST_PAUSE
        gap = gap or (any_of(full.valid) and full.revolutions[0] - history.last_seen[0] > LARGEST_STEP)
    for row in range(2):
        for k in range(contact.size):
            step, before, expected = vector[row, k], history.vector[last, row, k], 0.0
            if abs(step) <= NEGLIGIBLE * abs(full.position[k]):
                step = 0j
            elif appended and abs(before) <= NEGLIGIBLE * abs(history.position[last, k]):
                step = 0j  # from a vector that is round-off any angle would be as good
            elif appended:
                step *= before.conjugate()
                if rate[k] != 0.0 and abs(vector[0, k]) > LEADING * abs(vector[row, k]):
                    expected = rate[k] * elapsed
                    step *= complex(math.cos(expected), -math.sin(expected))
            angle[row, k] = math.atan2(step.imag, step.real) + (angle[row, k] + expected if appended else 0.0)
    for k in range(contact.size):
        turn = full.phasor[k] * history.phasor[last, k].conjugate()
        history.turned[k] += math.atan2(turn.imag, turn.real)
    for at in (appended % CAPACITY, appended % CAPACITY + CAPACITY):
        history.time[at], history.angle[at] = full.time[0], full.angle[0]
        history.revolutions[at] = full.revolutions[0]
        for k in range(contact.size):
            history.position[at, k], history.phasor[at, k] = full.position[k], full.phasor[k]
            history.contact[at, k], history.seen[at, k] = contact[k], full.valid[k]
            for row in range(3):
                history.vector[at, row, k] = vector[row, k]
            for row in range(2):
                history.unwrapped[at, row, k] = angle[row, k]
    if any_of(full.valid):
        history.last_seen[0] = full.revolutions[0]
    history.appended[0] += 1
    history.length[0] = 1 if gap else min(history.length[0] + 1, CAPACITY)
    return bool(gap)
