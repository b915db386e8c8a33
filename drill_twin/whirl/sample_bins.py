# SPDX-License-Identifier: Apache-2.0
"""Averages of the samples over bins of 1/16 revolution.

All estimators work on these bins, so that a window is a fixed number of revolutions at any sample rate, and averaging
reduces noise as far as the rate allows. A bin of 1/16 revolution shortens an orbit of precession ratio p by
sinc(p / 16): 0.2 % at p = 0.5, 2.3 % at p = -1.9. Where samples are farther apart than 1/16 revolution, each is a bin.
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
"""Longest bin [s], for a string that hardly rotates."""

Forces = NDArray[np.floating[Any]]


@dataclass(eq=False)
class Bin:
    """Means over a bin; arrays of shape (m,), valid until the next bin is closed."""

    time: float
    """Time since the first sample [s]."""
    angle: float
    """Angle of rotation [rad]."""
    revolutions: float
    """Revolutions since the first sample [rev]."""
    position: ComplexArray
    """Position of the marked point x + i y [m]."""
    phasor: ComplexArray
    """Unit vector of the spin, exp(i spin)."""
    contact: Array | None
    """Share of the samples with a wall force, if forces are given."""
    valid: Mask
    """Marks with at least one valid sample."""
    samples: int
    """Number of samples."""


class SampleBins:
    """Sums of the samples of the bin that is being filled."""

    def __init__(self, marks: int) -> None:
        self._sums = np.zeros((2, marks), complex)
        self._missed = np.zeros(marks)
        self._touching = np.zeros(marks)
        self._masked = np.zeros((2, marks), complex)
        self._samples = self._forces = self._cell = 0
        self._time = self._angle = self._revolutions = self._start = 0.0

    def is_full(self, time: float, revolutions: float) -> bool:
        """Check whether a sample at `time` [s] and `revolutions` [rev] lies beyond the present bin."""
        return self._samples > 0 and (math.floor(revolutions * BINS) != self._cell or time - self._start > LONGEST)

    def add(
        self,
        time: float,
        angle: float,
        revolutions: float,
        sample: ComplexArray,
        valid: Mask | None,
        force: Forces | None,
    ) -> None:
        """Add a sample.

        Args:
            time: Time since the first sample [s].
            angle: Angle of rotation [rad].
            revolutions: Revolutions since the first sample [rev].
            sample: Position [m] and phasor, shape (2, m).
            valid: Marks with a valid position; None means all.
            force: Wall force [N], shape (m,), if known.
        """
        if self._samples == 0:
            self._cell = math.floor(revolutions * BINS)
            self._start = time
        self._samples += 1
        self._time += time
        self._angle += angle
        self._revolutions += revolutions
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
        """Return the means of the present bin and start a new one."""
        n = self._samples
        count = n - self._missed
        divisor = np.maximum(count, 1.0)
        closed = Bin(
            time=self._time / n,
            angle=self._angle / n,
            revolutions=self._revolutions / n,
            position=self._sums[0] / divisor,
            phasor=self._sums[1] / divisor,
            contact=self._touching / self._forces if self._forces else None,
            valid=count > 0.0,
            samples=n,
        )
        self._sums[:] = 0.0
        self._missed[:] = 0.0
        self._touching[:] = 0.0
        self._samples = self._forces = 0
        self._time = self._angle = self._revolutions = 0.0
        return closed


def unit_phasor(angle: float | Array, out: ComplexArray) -> None:
    """Write exp(i angle) to `out`, shape (m,)."""
    np.cos(angle, out=out.real)
    np.sin(angle, out=out.imag)
