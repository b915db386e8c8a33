# SPDX-License-Identifier: Apache-2.0
"""The last revolutions of the motion, in bounded memory and as contiguous views."""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.sample_bins import BINS, Bin

CAPACITY = 32 * BINS
"""Bins remembered: 32 revolutions or more."""
LARGEST_STEP = 0.75
"""Bins farther apart than this [rev] are not one motion."""
LONGEST_PAUSE = 1.0
"""Nor are bins farther apart than this [s]."""

ASYNCHRONOUS, MOVING, SYNCHRONOUS = 0, 1, 2
"""Rows of `History.vector`: the asynchronous part; all that moves; the same as seen from the turning string."""


class History:
    """Ring of bins. Each bin is written twice, `CAPACITY` apart, so that the newest n always lie side by side."""

    def __init__(self, marks: int) -> None:
        # Views of three blocks, so that a bin is six writes.
        self._clock = np.zeros((2 * CAPACITY, 3))
        self._complex = np.zeros((2 * CAPACITY, 5, marks), complex)
        self._real = np.zeros((2 * CAPACITY, 4, marks))
        self._bin = (np.zeros(3), np.zeros((5, marks), complex), np.zeros((4, marks)))
        self.time = self._clock[:, 0]
        """Time since the first sample [s]."""
        self.angle = self._clock[:, 1]
        """Angle of rotation [rad]."""
        self.travel = self._clock[:, 2]
        """Revolutions turned [rev]."""
        self.vector = self._complex[:, :3]
        """Asynchronous, moving and synchronous part of the centre line [m]."""
        self.sample = self._complex[:, 3:]
        """Position of the marked point [m] and unit vector of its spin."""
        self.turned = self._real[:, :2]
        """Unwrapped angle of the asynchronous and the moving part [rad]."""
        self.contact = self._real[:, 2]
        """Share of the bin in contact with the wall."""
        self.seen = self._real[:, 3]
        """1 where the mark was seen, else 0."""
        self.count = 0
        """Bins ever."""
        self.length = 0
        """Bins since the last gap, at most `CAPACITY`."""

    def append(self, full: Bin, vector: ComplexArray, contact: Array) -> bool:
        """Appends a bin, its `vector`, shape (3, m), and `contact`, shape (m,); returns whether it follows a gap."""
        clock, complex_part, real_part = self._bin
        gap = False
        turn = vector[:2]
        if self.count:
            last = self._end - 1
            then, _, travel = self._clock[last].tolist()
            gap = full.travel - travel > LARGEST_STEP or full.time - then > LONGEST_PAUSE
            turn = turn * self.vector[last, :2].conj()
            real_part[:2] += np.arctan2(turn.imag, turn.real)
        else:
            real_part[:2] = np.arctan2(turn.imag, turn.real)
        clock[:] = (full.time, full.angle, full.travel)
        complex_part[:3] = vector
        complex_part[3] = full.place
        complex_part[4] = full.turn
        real_part[2] = contact
        real_part[3] = full.valid
        place = self.count % CAPACITY
        for at in (place, place + CAPACITY):
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
        """The newest bins, oldest first."""
        return slice(self._end - bins, self._end)

    def span(self, revolutions: float) -> int:
        """How many of the newest bins without a gap lie within the last revolutions; at most 4 for each 1/16."""
        bins = min(self.length, int(4 * BINS * revolutions))
        travel = self.travel[self.newest(bins)]
        return bins - int(np.searchsorted(travel, travel[-1] - revolutions + 0.5 / BINS))
