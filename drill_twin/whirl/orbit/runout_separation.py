# SPDX-License-Identifier: Apache-2.0
"""Separation of the spin from the centre line, and of the centre line into what stands still and what whirls.

A mark on the outer wall sits at z = c + S e + a + r_o e exp(i alpha), with e = exp(i spin). Where the spin is given,
r_o e is known and taken off exactly. Where it is not, e = exp(i angle of the top drive), and the direction alpha comes
from the same fit: the string starts near the axis, so that the synchronous part of the mark is at first r_o
exp(i alpha), and alpha then follows slowly while the synchronous part keeps about that length.

The offset c and the synchronous part S are a least-squares fit of z = c + S e with exponentially fading memory
(`Criteria.baseline_window` revolutions), in closed form from four running sums; its residual a is the asynchronous
part. The fit is exact for irregular bins and for a rotation that has hardly begun; an orbit of ratio p keeps the
fraction |2 pi p N / (1 + 2 pi i p N)| of its radius against the offset and the like with p - 1 against S, which is
0.994 at p = 0.5 and 0.97 at p = -0.1 for N = 6. The fit is held while a mark may have begun to whirl, and fades slowly
(`Criteria.whirl_memory`) while it does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.orbit.orbit_refit import Refit
from drill_twin.whirl.sample_bins import Bin

SLOWEST = 0.2
"""The memory fades at least as fast as at this rotation [rev/s]."""
DETERMINED = 1e-3
"""Least determinant of the fit, relative: 1/30 of a turn seen; before, all but the arm of a wall mark is offset."""
CALIBRATED = 0.3
"""Least determinant from which on the direction of a wall mark is fitted: 2/3 of a turn seen."""
DIRECTION_MEMORY = 20.0
"""Memory of the direction of a wall mark [rev]."""
DIRECTION_GATE = 0.25
"""The direction is held when the synchronous part is longer or shorter than r_o by this fraction of r_o."""


class Baseline:
    """Offset and synchronous part of each mark, fitted bin by bin."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria) -> None:
        m = len(marks)
        self._memory = np.full(m, criteria.baseline_window)
        self._criteria = criteria
        self._radius = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks])
        self.spin_given: bool | None = None
        """Whether the spin of the marks comes with the samples; None before the first."""
        self.arm: ComplexArray = np.zeros(m, complex)
        """From the centre line to the marked point, seen from the turning string [m], shape (m,)."""
        self.known = self._calibrated = False
        """Whether `arm` is known."""
        self._sums = np.zeros((5, m), complex)  # of 1, |e|^2, e, z, z conj(e)
        self._row = np.zeros((5, m), complex)
        self._fresh = np.zeros((3, m), complex)
        self._held: Mask = np.zeros(m, bool)
        self._determinant = np.zeros(m)
        self.offset: ComplexArray = np.zeros(m, complex)
        """Offset c [m], shape (m,)."""
        self.synchronous: ComplexArray = np.zeros(m, complex)
        """Synchronous part of the marked point, the arm of a wall mark included [m], shape (m,)."""
        self._travel = self._time = 0.0

    def begin(self, *, spin_given: bool) -> None:
        """Settles, with the first sample, whether the spin is given."""
        self.spin_given = spin_given
        self.known = self._calibrated = spin_given or not self._radius.any()
        if spin_given:
            self.arm = self._radius.astype(complex)

    def keep(self, candidates: Mask, whirling: Mask) -> None:
        """Holds the fit of marks that may have begun to whirl, lets it fade slowly for those that do; shape (m,)."""
        self._held = candidates & (self._determinant > CALIBRATED) & ~whirling
        self._memory = np.where(whirling, self._criteria.whirl_memory, self._criteria.baseline_window)

    def settle(self, mark: int, found: Refit) -> None:
        """Sets the offset and the synchronous part of a mark to what a closer look found."""
        bins = found.orbit.size
        self._sums[:, mark] = (bins, bins, 0.0, bins * found.offset, bins * found.synchronous)

    def relearn(self, mark: int, sample: ComplexArray) -> None:
        """Forgets a mark but for these bins of place and turn, shape (n, 2): it has found a new place or bow."""
        place, turn = sample[:, 0], sample[:, 1]
        back = turn.conj()
        rows = (turn != 0.0, turn * back, turn, place, place * back)  # no turn, no sample
        self._sums[:, mark] = [complex(row.sum()) for row in rows]

    def split(self, full: Bin, out: ComplexArray) -> Array:
        """Writes the asynchronous, the moving and the synchronous part [m] of a bin to `out`, shape (3, m).

        A mark without a valid sample keeps its last vectors. Returns the centre line's distance from the hole's axis
        [m], shape (m,).
        """
        faded = max(full.travel - self._travel, SLOWEST * (full.time - self._time))
        self._travel, self._time = full.travel, full.time
        offset, synchronous = self._fit(full, np.exp(-faded / self._memory))
        if not self.spin_given and self._radius.any():
            self._point(synchronous, faded)
        self.offset, self.synchronous = offset, synchronous
        moving = full.place - offset - self.arm * full.turn
        fresh = self._fresh
        fresh[0] = full.place - offset - synchronous * full.turn
        fresh[1] = moving
        fresh[2] = moving * full.turn.conj()
        np.copyto(out, fresh, where=full.valid)
        return np.abs(full.place - self.arm * full.turn)

    def _fit(self, full: Bin, fade: Array) -> tuple[ComplexArray, ComplexArray]:
        """Offset and synchronous part of the marked point [m], shape (m,)."""
        row, back = self._row, full.turn.conj()
        row[0] = full.valid
        row[1] = full.turn * back
        row[2] = full.turn
        row[3] = full.place
        row[4] = full.place * back
        if self._held.any():
            fade = np.where(self._held, 1.0, fade)
            row *= ~self._held
        self._sums *= fade
        self._sums += row
        weight, power, cross, place, turned = self._sums
        some = weight.real + 1e-300
        scale = np.maximum(some * power.real, 1e-300)
        determinant = scale - (cross.real**2 + cross.imag**2)
        relative = determinant / scale
        enough = relative > DETERMINED
        safe = np.where(enough, determinant, 1.0)
        offset = (power * place - cross * turned) / safe
        synchronous = (weight * turned - cross.conj() * place) / safe
        if not enough.all():
            # Too little of a turn seen: what turns is taken to be the known arm of a wall mark alone.
            offset = np.where(enough, offset, (place - self.arm * cross) / some)
            synchronous = np.where(enough, synchronous, self.arm)
        self._determinant = relative
        return offset, synchronous

    def _point(self, synchronous: ComplexArray, faded: float) -> None:
        """Turns the arms of wall marks towards their synchronous part (camera mode)."""
        if not self._calibrated:
            # Too little of a turn to tell: the string is taken to be near the axis.
            self._calibrated = bool(self._determinant.min() > CALIBRATED)
            source = synchronous if self._calibrated else self._sums[4]
            length = np.abs(source)
            self.arm = np.where(length > 0.0, self._radius * source / np.where(length > 0.0, length, 1.0), 0.0)
            self.known = True
            return
        length = np.abs(synchronous)
        trusted = np.abs(length - self._radius) < DIRECTION_GATE * self._radius
        gain = min(1.0, faded / DIRECTION_MEMORY)
        aim = self.arm + gain * (self._radius * synchronous / np.maximum(length, 1e-300) - self.arm)
        aim *= self._radius / np.maximum(np.abs(aim), 1e-300)
        np.copyto(self.arm, aim, where=trusted)
