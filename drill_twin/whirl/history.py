# SPDX-License-Identifier: Apache-2.0
"""Ring buffer of the last revolutions of the motion, read as contiguous views."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers
from drill_twin.core.compile.jit import as_python, copy, strict_kernel
from drill_twin.whirl.sample_bins import ANGLE, BINS, REVOLUTIONS, TIME, Bin

CAPACITY = 32 * BINS
"""Bins stored: 32 revolutions or more."""
LARGEST_STEP = 0.75
"""Bins farther apart than this [rev] are separated by a gap."""
LONGEST_PAUSE = 1.0
"""Bins farther apart than this [s] are, too."""
NEGLIGIBLE = 1e-9
"""A part of a motion below this share of the position is round-off, and has no direction."""
LEADING = 0.7
"""Least share of the asynchronous part in a motion that is expected to advance with it."""

ASYNCHRONOUS, MOVING, SYNCHRONOUS, POSITION, PHASOR = range(5)
"""Rows of `History.complex_part`: the asynchronous part; position less offset; the same in the rotating frame; position
of the marked point [m] and unit vector of its spin."""
CONTACT, SEEN = 2, 3
"""Rows of `History.real_part` after the unwrapped angles of the asynchronous and the moving part [rad]: share of the
bin in contact with the wall; 1 where the mark was seen, else 0."""
APPENDED, LENGTH = 0, 1
"""Indices into `History.counts`: bins appended in total; bins since the last gap, at most `CAPACITY`."""


class History(NamedTuple):
    """Ring buffer of bins. Each bin is written twice, `CAPACITY` apart, so that the newest n are always contiguous."""

    clock: Array  # (2 CAPACITY, 3) time [s], angle of rotation [rad] and revolutions since the first sample
    complex_part: ComplexArray  # (2 CAPACITY, 5, m)
    real_part: Array  # (2 CAPACITY, 4, m)
    counts: Integers
    angle_now: Array  # (2, m) work: unwrapped angle of the newest bin

    @classmethod
    def of(cls, m: int) -> History:
        """Empty history of m marks."""
        return cls(
            np.zeros((2 * CAPACITY, 3)), np.zeros((2 * CAPACITY, 5, m), complex), np.zeros((2 * CAPACITY, 4, m)),
            np.zeros(2, np.int64), np.zeros((2, m)),
        )  # fmt: skip

    @property
    def time(self) -> Array:
        """Time since the first sample [s]."""
        return self.clock[:, TIME]

    @property
    def angle(self) -> Array:
        """Angle of rotation [rad]."""
        return self.clock[:, ANGLE]

    @property
    def revolutions(self) -> Array:
        """Revolutions since the first sample [rev]."""
        return self.clock[:, REVOLUTIONS]

    @property
    def vector(self) -> ComplexArray:
        """Asynchronous, moving and synchronous part of the centre line [m]."""
        return self.complex_part[:, :POSITION]

    @property
    def sample(self) -> ComplexArray:
        """Position of the marked point [m] and unit vector of its spin."""
        return self.complex_part[:, POSITION:]

    @property
    def unwrapped(self) -> Array:
        """Unwrapped angle of the asynchronous and the moving part [rad]."""
        return self.real_part[:, :CONTACT]

    @property
    def appended(self) -> int:
        """Bins appended in total."""
        return int(self.counts[APPENDED])

    @property
    def length(self) -> int:
        """Bins since the last gap, at most `CAPACITY`."""
        return int(self.counts[LENGTH])

    def newest(self, bins: int) -> slice:
        """Index range of the newest bins, oldest first."""
        end = (self.appended - 1) % CAPACITY + CAPACITY + 1
        return slice(end - bins, end)

    def bins_in(self, revolutions: float) -> int:
        """Number of bins since the last gap within the newest `revolutions` [rev]; at most 4 for each 1/16."""
        return int(as_python(bins_in)(self, revolutions))


@strict_kernel
def end_of(history: History) -> int:
    """Index after the newest bin."""
    return int((history.counts[APPENDED] - 1) % CAPACITY + CAPACITY + 1)


@strict_kernel
def bins_in(history: History, revolutions: float) -> int:
    """As `History.bins_in`."""
    clock, end = history.clock, end_of(history)
    bins = min(history.counts[LENGTH], int(4 * BINS * revolutions))
    least = clock[end - 1, REVOLUTIONS] - revolutions + 0.5 / BINS
    low, high = end - bins, end
    while low < high:
        middle = (low + high) // 2
        if clock[middle, REVOLUTIONS] < least:
            low = middle + 1
        else:
            high = middle
    return int(end - low)


@strict_kernel
def append(history: History, full: Bin, vector: ComplexArray, contact: Array, rate: Array) -> bool:
    """Append a bin, its `vector`, shape (3, m), and `contact`, shape (m,); return whether it follows a gap.

    An orbit of a known `rate` [rad/s], shape (m,), is expected to advance with it, be it by whole turns; 0 where not.
    """
    counts, clock, parts, angle = history.counts, history.clock, history.complex_part, history.angle_now
    gap, last, elapsed = False, end_of(history) - 1, 0.0
    if counts[APPENDED]:
        elapsed = full.numbers[TIME] - clock[last, TIME]
        gap = full.numbers[REVOLUTIONS] - clock[last, REVOLUTIONS] > LARGEST_STEP or elapsed > LONGEST_PAUSE
    for row in range(2):
        for k in range(contact.size):
            step, before, expected = vector[row, k], parts[last, row, k], 0.0
            if abs(step) <= NEGLIGIBLE * abs(full.position[k]):
                step = 0j
            elif counts[APPENDED] and abs(before) <= NEGLIGIBLE * abs(parts[last, POSITION, k]):
                step = 0j  # from a vector that is round-off any angle would be as good
            elif counts[APPENDED]:
                step *= before.conjugate()
                if rate[k] != 0.0 and abs(vector[0, k]) > LEADING * abs(vector[row, k]):
                    expected = rate[k] * elapsed
                    step *= complex(math.cos(expected), -math.sin(expected))
            angle[row, k] = math.atan2(step.imag, step.real) + (angle[row, k] + expected if counts[APPENDED] else 0.0)
    slot = counts[APPENDED] % CAPACITY
    for half in range(2):
        at = slot + half * CAPACITY
        for k in range(3):
            clock[at, k] = full.numbers[k]
        for row in range(POSITION):
            copy(vector[row], parts[at, row])
        copy(full.position, parts[at, POSITION])
        copy(full.phasor, parts[at, PHASOR])
        for row in range(CONTACT):
            copy(angle[row], history.real_part[at, row])
        copy(contact, history.real_part[at, CONTACT])
        for k in range(contact.size):
            history.real_part[at, SEEN, k] = full.valid[k]
    counts[APPENDED] += 1
    counts[LENGTH] = 1 if gap else min(counts[LENGTH] + 1, CAPACITY)
    return gap
