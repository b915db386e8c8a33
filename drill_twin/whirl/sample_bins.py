# SPDX-License-Identifier: Apache-2.0
"""Samples of any rate, averaged over sixteenths of a revolution.

All estimators work on these bins, so that a window is a fixed number of revolutions whatever the rate, and averaging
takes noise down as far as the rate allows. A bin of 1/16 revolution shortens an orbit of ratio p by sinc(p / 16):
0.2 % at p = 0.5, 2.3 % at p = -1.9. Where samples are farther apart than 1/16 revolution, each is a bin of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array, ComplexArray, Mask

BINS = 16
"""Bins in a revolution."""
LONGEST = 0.5
"""Longest bin [s], for a string that hardly turns."""

Forces = NDArray[np.floating[Any]]


@dataclass(eq=False)
class Bin:
    """Means over a bin; arrays of shape (m,), valid until the next bin closes."""

    time: float
    """Time since the first sample [s]."""
    angle: float
    """Angle of rotation [rad]."""
    travel: float
    """Revolutions turned since the first sample [rev]."""
    place: ComplexArray
    """Position of the marked point x + i y [m]."""
    turn: ComplexArray
    """Unit vector of the spin, exp(i spin)."""
    contact: Array | None
    """Share of the samples with a wall force, if forces are given."""
    valid: Mask
    """Marks with at least one valid sample."""
    samples: int
    """Samples."""


class Bins:
    """Collects samples until a sixteenth of a revolution is full."""

    def __init__(self, marks: int) -> None:
        self._sums = np.zeros((2, marks), complex)
        self._missed = np.zeros(marks)
        self._touching = np.zeros(marks)
        self._masked = np.zeros((2, marks), complex)
        self._samples = self._forces = self._cell = 0
        self._time = self._angle = self._travel = self._start = 0.0

    def due(self, time: float, travel: float) -> bool:
        """Whether a sample at `time` [s] and `travel` [rev] lies beyond the bin that is being filled."""
        return self._samples > 0 and (math.floor(travel * BINS) != self._cell or time - self._start > LONGEST)

    def add(
        self, time: float, angle: float, travel: float, sample: ComplexArray, valid: Mask | None, force: Forces | None
    ) -> None:
        """Adds a sample of place and turn, shape (2, m); `valid` None means all; wall `force` [N], shape (m,)."""
        if self._samples == 0:
            self._cell = math.floor(travel * BINS)
            self._start = time
        self._samples += 1
        self._time += time
        self._angle += angle
        self._travel += travel
        if valid is None:
            self._sums += sample
        else:
            self._masked[:] = 0.0
            np.copyto(self._masked, sample, where=valid)
            self._sums += self._masked
            self._missed += ~valid
        if force is not None:
            self._forces += 1
            self._touching += force > 0.0

    def close(self) -> Bin:
        """The full bin; the next sample starts a new one."""
        n = self._samples
        count = n - self._missed
        some = np.maximum(count, 1.0)
        closed = Bin(
            time=self._time / n,
            angle=self._angle / n,
            travel=self._travel / n,
            place=self._sums[0] / some,
            turn=self._sums[1] / some,
            contact=self._touching / self._forces if self._forces else None,
            valid=count > 0.0,
            samples=n,
        )
        self._sums[:] = 0.0
        self._missed[:] = 0.0
        self._touching[:] = 0.0
        self._samples = self._forces = 0
        self._time = self._angle = self._travel = 0.0
        return closed


def unit_turn(angle: float | Array, out: ComplexArray) -> None:
    """Writes exp(i angle) to `out`, shape (m,)."""
    np.cos(angle, out=out.real)
    np.sin(angle, out=out.imag)
