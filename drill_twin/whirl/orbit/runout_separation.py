# SPDX-License-Identifier: Apache-2.0
"""Separation of spin, offset and synchronous part (runout, API 670) from the asynchronous motion of the marks.

A mark on the outer wall is at z = c + S e + a + r_o e exp(i alpha), with e = exp(i spin). Where the spin is measured,
r_o e is known and subtracted exactly. Otherwise, e = exp(i angle of the top drive), and the direction alpha is fitted
too: the string starts near the axis, so that the synchronous part of the mark is at first r_o exp(i alpha), and alpha
then follows slowly while the synchronous part keeps about that length.

The offset c and the synchronous part S are a least-squares fit of z = c + S e with exponentially fading memory
(`Criteria.separation_memory` revolutions), in closed form from running sums; its residual a is the asynchronous part.
The fit is exact for irregular bins and for a rotation that has hardly begun. An orbit of ratio p keeps the fraction
|2 pi p N / (1 + 2 pi i p N)| of its radius against the offset, and the same with p - 1 against S: 0.994 at p = 0.5 and
0.97 at p = -0.1 for N = 6. The fit is held while a mark may have begun to whirl, and fades slowly
(`Criteria.separation_memory_in_whirl`) while it whirls.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.orbit.orbit_refit import OrbitRefit
from drill_twin.whirl.sample_bins import Bin

SLOWEST = 0.2
"""The memory fades at least as fast as at this rotation [rev/s]."""
SMALLEST_DETERMINANT = 1e-3
"""Smallest relative determinant of the fit, 1/30 of a revolution; below, the synchronous part is the arm alone."""
CALIBRATED = 0.3
"""Smallest relative determinant for a fit of the direction of a wall mark: 2/3 of a revolution."""
DIRECTION_MEMORY = 20.0
"""Memory of the direction of a wall mark [rev]."""
DIRECTION_GATE = 0.25
"""The direction is held while the length of the synchronous part differs from r_o by more than this fraction."""


class RunoutSeparation:
    """Offset and synchronous part of each mark, fitted bin by bin."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria) -> None:
        m = len(marks)
        self._memory = np.full(m, criteria.separation_memory)
        self._criteria = criteria
        self._radius = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks])
        self.spin_given: bool | None = None
        """True if the samples contain the spin of the marks; None before the first sample."""
        self.arm: ComplexArray = np.zeros(m, complex)
        """Vector from the centre line to the marked point, in the rotating frame [m], shape (m,)."""
        self.known = self._calibrated = False
        """True once `arm` is known."""
        self._sums = np.zeros((5, m), complex)  # of 1, |e|^2, e, z, z conj(e)
        self._row = np.zeros((5, m), complex)
        self._parts = np.zeros((3, m), complex)
        self._held: Mask = np.zeros(m, bool)
        self._determinant = np.zeros(m)
        self.offset: ComplexArray = np.zeros(m, complex)
        """Offset c [m], shape (m,)."""
        self.synchronous: ComplexArray = np.zeros(m, complex)
        """Synchronous part of the marked point, the arm of a wall mark included [m], shape (m,)."""
        self._revolutions = self._time = 0.0

    def start(self, *, spin_given: bool) -> None:
        """Set, with the first sample, whether the samples contain the spin."""
        self.spin_given = spin_given
        self.known = self._calibrated = spin_given or not self._radius.any()
        if spin_given:
            self.arm = self._radius.astype(complex)

    def hold(self, candidates: Mask, whirling: Mask) -> None:
        """Hold the fit of marks that may have begun to whirl, slow the fading of those that do; shape (m,)."""
        self._held = candidates & (self._determinant > CALIBRATED) & ~whirling
        memory, in_whirl = self._criteria.separation_memory, self._criteria.separation_memory_in_whirl
        self._memory = np.where(whirling, in_whirl, memory)

    def correct(self, mark: int, refit: OrbitRefit) -> None:
        """Replace the offset and the synchronous part of a mark by those of a refit."""
        bins = refit.orbit.size
        self._sums[:, mark] = (bins, bins, 0.0, bins * refit.offset, bins * refit.synchronous)

    def restart(self, mark: int, sample: ComplexArray) -> None:
        """Fit a mark from these bins of position [m] and phasor alone, shape (n, 2): its offset or bow has changed."""
        position, phasor = sample[:, 0], sample[:, 1]
        back = phasor.conj()
        rows = (phasor != 0.0, phasor * back, phasor, position, position * back)  # phasor 0: no sample
        self._sums[:, mark] = [complex(row.sum()) for row in rows]

    def separate(self, full: Bin, out: ComplexArray) -> Array:
        """Write the asynchronous, the moving and the synchronous part [m] of a bin to `out`, shape (3, m).

        A mark without a valid sample keeps its last vectors. Returns the centre line's distance from the hole's axis
        [m], shape (m,).
        """
        elapsed = max(full.revolutions - self._revolutions, SLOWEST * (full.time - self._time))
        self._revolutions, self._time = full.revolutions, full.time
        offset, synchronous = self._fit(full, np.exp(-elapsed / self._memory))
        if not self.spin_given and self._radius.any():
            self._update_direction(synchronous, elapsed)
        self.offset, self.synchronous = offset, synchronous
        moving = full.position - offset - self.arm * full.phasor
        parts = self._parts
        parts[0] = full.position - offset - synchronous * full.phasor
        parts[1] = moving
        parts[2] = moving * full.phasor.conj()
        np.copyto(out, parts, where=full.valid)
        return np.abs(full.position - self.arm * full.phasor)

    def _fit(self, full: Bin, fade: Array) -> tuple[ComplexArray, ComplexArray]:
        """Offset and synchronous part of the marked point [m], shape (m,)."""
        row, back = self._row, full.phasor.conj()
        row[0] = full.valid
        row[1] = full.phasor * back
        row[2] = full.phasor
        row[3] = full.position
        row[4] = full.position * back
        if self._held.any():
            fade = np.where(self._held, 1.0, fade)
            row *= ~self._held
        self._sums *= fade
        self._sums += row
        weight, power, cross, position, rotated = self._sums
        count = weight.real + 1e-300
        scale = np.maximum(count * power.real, 1e-300)
        determinant = scale - (cross.real**2 + cross.imag**2)
        relative = determinant / scale
        regular = relative > SMALLEST_DETERMINANT
        divisor = np.where(regular, determinant, 1.0)
        offset = (power * position - cross * rotated) / divisor
        synchronous = (weight * rotated - cross.conj() * position) / divisor
        if not regular.all():
            offset = np.where(regular, offset, (position - self.arm * cross) / count)
            synchronous = np.where(regular, synchronous, self.arm)
        self._determinant = relative
        return offset, synchronous

    def _update_direction(self, synchronous: ComplexArray, elapsed: float) -> None:
        """Rotate the arms of wall marks towards their synchronous part, for samples without spin."""
        if not self._calibrated:
            # Before 2/3 of a revolution, the string is assumed to be near the axis.
            self._calibrated = bool(self._determinant.min() > CALIBRATED)
            source = synchronous if self._calibrated else self._sums[4]
            length = np.abs(source)
            self.arm = np.where(length > 0.0, self._radius * source / np.where(length > 0.0, length, 1.0), 0.0)
            self.known = True
            return
        length = np.abs(synchronous)
        trusted = np.abs(length - self._radius) < DIRECTION_GATE * self._radius
        gain = min(1.0, elapsed / DIRECTION_MEMORY)
        arm = self.arm + gain * (self._radius * synchronous / np.maximum(length, 1e-300) - self.arm)
        arm *= self._radius / np.maximum(np.abs(arm), 1e-300)
        np.copyto(self.arm, arm, where=trusted)
