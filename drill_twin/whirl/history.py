# SPDX-License-Identifier: Apache-2.0
"""Ring buffer of the last revolutions of the motion, read as contiguous views."""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.sample_bins import BINS, Bin

CAPACITY = 32 * BINS
"""Bins stored: 32 revolutions or more."""
LARGEST_STEP = 0.75
"""Bins farther apart than this [rev] are separated by a gap."""
LONGEST_PAUSE = 1.0
"""Bins farther apart than this [s] are, too."""

ASYNCHRONOUS, MOVING, SYNCHRONOUS = 0, 1, 2
"""Rows of `History.vector`: the asynchronous part; position less offset; the same in the rotating frame."""


class History:
    """Ring buffer of bins. Each bin is written twice, `CAPACITY` apart, so that the newest n are always contiguous."""

    def __init__(self, marks: int) -> None:
        # Three blocks, so that a bin takes six writes; the attributes are views of them.
        self._clock = np.zeros((2 * CAPACITY, 3))
        self._complex = np.zeros((2 * CAPACITY, 5, marks), complex)
        self._real = np.zeros((2 * CAPACITY, 4, marks))
        self._bin = (np.zeros(3), np.zeros((5, marks), complex), np.zeros((4, marks)))
        self.time = self._clock[:, 0]
        """Time since the first sample [s]."""
        self.angle = self._clock[:, 1]
        """Angle of rotation [rad]."""
        self.revolutions = self._clock[:, 2]
        """Revolutions since the first sample [rev]."""
        self.vector = self._complex[:, :3]
        """Asynchronous, moving and synchronous part of the centre line [m]."""
        self.sample = self._complex[:, 3:]
        """Position of the marked point [m] and unit vector of its spin."""
        self.unwrapped = self._real[:, :2]
        """Unwrapped angle of the asynchronous and the moving part [rad]."""
        self.contact = self._real[:, 2]
        """Share of the bin in contact with the wall."""
        self.seen = self._real[:, 3]
        """1 where the mark was seen, else 0."""
        self.count = 0
        """Bins appended in total."""
        self.length = 0
        """Bins since the last gap, at most `CAPACITY`."""

    def append(self, full: Bin, vector: ComplexArray, contact: Array) -> bool:
        """Append a bin, its `vector`, shape (3, m), and `contact`, shape (m,); return whether it follows a gap."""
        clock, complex_part, real_part = self._bin
        gap = False
        step = vector[:2]
        if self.count:
            last = self._end - 1
            last_time, _, last_revolutions = self._clock[last].tolist()
            gap = full.revolutions - last_revolutions > LARGEST_STEP or full.time - last_time > LONGEST_PAUSE
            step = step * self.vector[last, :2].conj()
            real_part[:2] += np.arctan2(step.imag, step.real)
        else:
            real_part[:2] = np.arctan2(step.imag, step.real)
        clock[:] = (full.time, full.angle, full.revolutions)
        complex_part[:3] = vector
        complex_part[3] = full.position
        complex_part[4] = full.phasor
        real_part[2] = contact
        real_part[3] = full.valid
        slot = self.count % CAPACITY
        for at in (slot, slot + CAPACITY):
            self._clock[at] = clock
            self._complex[at] = complex_part
            self._real[at] = real_part
        self.count += 1
        self.length = 1 if gap else min(self.length + 1, CAPACITY)
        return gap

    @property
    def _end(self) -> int:
        return (self.count - 1) % CAPACITY + CAPACITY + 1

    def newest(self, bins: int) -> slice:
        """Index range of the newest bins, oldest first."""
        return slice(self._end - bins, self._end)

    def bins_in(self, revolutions: float) -> int:
        """Number of bins since the last gap within the newest `revolutions` [rev]; at most 4 for each 1/16."""
        bins = min(self.length, int(4 * BINS * revolutions))
        elapsed = self.revolutions[self.newest(bins)]
        return bins - int(np.searchsorted(elapsed, elapsed[-1] - revolutions + 0.5 / BINS))
