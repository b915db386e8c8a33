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

import math
from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray, Mask
from drill_twin.base.exact_jit import Integers, copy, exact_kernel
from drill_twin.base.numpy_loops import absolute, exp, product, quotient
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.orbit.orbit_refit import OrbitRefit
from drill_twin.whirl.sample_bins import REVOLUTIONS, TIME, Bin

SLOWEST = 0.2
"""The memory fades at least as fast as at this rotation [rev/s]."""
SMALLEST_DETERMINANT = 1e-3
"""Smallest relative determinant of the fit, 1/30 of a revolution; below, the synchronous part is the arm alone."""
CALIBRATED_FROM = 0.3
"""Smallest relative determinant for a fit of the direction of a wall mark: 2/3 of a revolution."""
DIRECTION_MEMORY = 20.0
"""Memory of the direction of a wall mark [rev]."""
DIRECTION_GATE = 0.25
"""The direction is held while the length of the synchronous part differs from r_o by more than this fraction."""

NOT_KNOWN = -1
SPIN_GIVEN, KNOWN, CALIBRATED, DIRECTED = range(4)
"""Indices into flags: the samples contain the spin of the marks, `NOT_KNOWN` before the first one; the arms are
known; they are calibrated; there are wall marks."""


class RunoutSeparation(NamedTuple):
    """Offset and synchronous part of m marks, fitted bin by bin."""

    offset: ComplexArray  # (m,) offset c [m]
    synchronous: ComplexArray  # (m,) synchronous part of the marked point, the arm of a wall mark included [m]
    arm: ComplexArray  # (m,) from the centre line to the marked point, in the rotating frame [m]
    vector: ComplexArray  # (3, m) asynchronous, moving and synchronous part of the newest bin [m]
    distance: Array  # (m,) of the centre line from the hole's axis [m]
    sums: ComplexArray  # (5, m) of 1, |e|^2, e, z, z conj(e)
    memory: Array  # (m,) [rev]
    held: Mask  # (m,)
    determinant: Array  # (m,)
    radius: Array  # (m,) of wall marks r_o, else 0 [m]
    last: Array  # (2,) time [s] and revolutions of the last bin
    flags: Integers
    work: ComplexArray  # (9, m)
    numbers: Array  # (m,) work

    @classmethod
    def of(cls, radius: Array, criteria: Criteria) -> RunoutSeparation:
        """Separation before the first bin."""
        m = radius.size
        flags = np.array([NOT_KNOWN, 0, 0, radius.any()], np.int64)
        offset, synchronous, arm = np.zeros((3, m), complex)
        return cls(
            offset, synchronous, arm, np.zeros((3, m), complex), np.zeros(m), np.zeros((5, m), complex),
            np.full(m, criteria.separation_memory), np.zeros(m, bool), np.zeros(m), radius, np.zeros(2), flags,
            np.zeros((9, m), complex), np.zeros(m),
        )  # fmt: skip

    def correct(self, mark: int, refit: OrbitRefit) -> None:
        """Replace the offset and the synchronous part of a mark by those of a refit."""
        bins = refit.orbit.size
        self.sums[:, mark] = (bins, bins, 0.0, bins * refit.offset, bins * refit.synchronous)

    def restart(self, mark: int, sample: ComplexArray) -> None:
        """Fit a mark from these bins of position [m] and phasor alone, shape (n, 2): its offset or bow has changed."""
        position, phasor = sample[:, 0], sample[:, 1]
        back = phasor.conj()
        rows = (phasor != 0.0, phasor * back, phasor, position, position * back)  # phasor 0: no sample
        self.sums[:, mark] = [complex(row.sum()) for row in rows]


@exact_kernel
def start(separation: RunoutSeparation, spin_given: bool) -> None:
    """Set, with the first sample, whether the samples contain the spin."""
    flags = separation.flags
    flags[SPIN_GIVEN] = spin_given
    flags[KNOWN] = flags[CALIBRATED] = spin_given or not flags[DIRECTED]
    if spin_given:
        copy(separation.radius, separation.arm)


@exact_kernel
def hold(separation: RunoutSeparation, criteria: Criteria, candidates: Array, whirling: Mask) -> None:
    """Hold the fit of marks that may have begun to whirl, slow the fading of those that do.

    Args:
        separation: The separation.
        criteria: Thresholds.
        candidates: Time at which each mark may have begun [s], nan for none, shape (m,).
        whirling: Marks that whirl, shape (m,).
    """
    for k in range(whirling.size):
        may = not math.isnan(candidates[k])
        separation.held[k] = may and separation.determinant[k] > CALIBRATED_FROM and not whirling[k]
        separation.memory[k] = criteria.separation_memory_in_whirl if whirling[k] else criteria.separation_memory


@exact_kernel
def separate(separation: RunoutSeparation, full: Bin, left: ComplexArray, shift: ComplexArray) -> None:
    """Separate the parts of a bin: `vector` and `distance`; a mark without a valid sample keeps its last vectors.

    What is `left` of fast orbits in the mean position [m], shape (m,), is taken out for the fit of offset and
    synchronous part, and the whole is given back then, by `shift` [m]: seen once a bin, an orbit of 16 or 15 turns in a
    revolution would pass for one of them.
    """
    last, work = separation.last, separation.work
    time, revolutions = full.numbers[TIME], full.numbers[REVOLUTIONS]
    elapsed = max(revolutions - last[1], SLOWEST * (time - last[0]))
    last[0], last[1] = time, revolutions
    fade = separation.numbers
    for k in range(fade.size):
        fade[k] = -elapsed / separation.memory[k]
    exp(fade, fade)
    for k in range(fade.size):
        full.position[k] -= left[k]
    _fit(separation, full, fade)
    for k in range(fade.size):
        full.position[k] += shift[k]
    if not separation.flags[SPIN_GIVEN] and separation.flags[DIRECTED]:
        _update_direction(separation, elapsed)
    arm, bow, back, turned = work[0], work[1], work[2], work[3]
    product(separation.arm, full.phasor, arm)
    product(separation.synchronous, full.phasor, bow)
    for k in range(fade.size):
        back[k] = full.phasor[k].conjugate()
        bow[k] = full.position[k] - separation.offset[k] - bow[k]
        turned[k] = full.position[k] - separation.offset[k] - arm[k]
        arm[k] = full.position[k] - arm[k]
    absolute(arm, separation.distance)
    product(turned, back, back)
    for k in range(fade.size):
        if full.valid[k]:
            separation.vector[0, k], separation.vector[1, k], separation.vector[2, k] = bow[k], turned[k], back[k]


@exact_kernel
def _fit(separation: RunoutSeparation, full: Bin, fade: Array) -> None:
    """Fit offset and synchronous part of the marked point, shape (m,)."""
    sums, held, work = separation.sums, separation.held, separation.work
    row, back, factor = work[:5], work[5], work[6]
    copy(full.phasor, row[2])
    copy(full.position, row[3])
    for k in range(fade.size):
        row[0, k] = 1.0 if full.valid[k] else 0.0
        back[k] = full.phasor[k].conjugate()
    product(full.phasor, back, row[1])
    product(full.position, back, row[4])
    if held.any():
        for k in range(fade.size):
            if held[k]:
                fade[k] = 1.0
            factor[k] = 0.0 if held[k] else 1.0
        for i in range(5):
            product(row[i], factor, row[i])
    copy(fade, factor)
    for i in range(5):
        product(sums[i], factor, sums[i])
        for k in range(fade.size):
            sums[i, k] += row[i, k]
    weight, power, cross, position, rotated = sums[0], sums[1], sums[2], sums[3], sums[4]
    divisor, one, two, other = work[0], work[1], work[2], work[3]
    regular = True
    for k in range(fade.size):
        count = weight[k].real + 1e-300
        scale = np.maximum(count * power[k].real, 1e-300)
        determinant = scale - (cross[k].real * cross[k].real + cross[k].imag * cross[k].imag)
        separation.determinant[k] = determinant / scale
        fits = separation.determinant[k] > SMALLEST_DETERMINANT
        regular = regular and fits
        divisor[k] = determinant if fits else 1.0
        back[k] = cross[k].conjugate()
    product(power, position, one)
    product(cross, rotated, two)
    product(weight, rotated, other)
    product(back, position, back)
    for k in range(fade.size):
        one[k] -= two[k]
        other[k] -= back[k]
    offset, synchronous = separation.offset, separation.synchronous
    quotient(one, divisor, offset)
    quotient(other, divisor, synchronous)
    if regular:
        return
    product(separation.arm, cross, two)
    for k in range(fade.size):
        one[k] = position[k] - two[k]
        divisor[k] = weight[k].real + 1e-300
    quotient(one, divisor, one)
    for k in range(fade.size):
        if not separation.determinant[k] > SMALLEST_DETERMINANT:
            offset[k], synchronous[k] = one[k], separation.arm[k]


@exact_kernel
def _update_direction(separation: RunoutSeparation, elapsed: float) -> None:
    """Rotate the arms of wall marks towards their synchronous part, for samples without spin."""
    arm, radius, flags, work = separation.arm, separation.radius, separation.flags, separation.work
    length, long, whole, new = separation.numbers, work[0], work[1], work[2]
    copy(radius, whole)
    if not flags[CALIBRATED]:
        # Before 2/3 of a revolution, the string is assumed to be near the axis.
        flags[CALIBRATED] = True
        for k in range(length.size):
            flags[CALIBRATED] &= separation.determinant[k] > CALIBRATED_FROM
        source = separation.synchronous if flags[CALIBRATED] else separation.sums[4]
        absolute(source, length)
        for k in range(length.size):
            long[k] = length[k] if length[k] > 0.0 else 1.0
        product(whole, source, new)
        quotient(new, long, new)
        for k in range(length.size):
            arm[k] = new[k] if length[k] > 0.0 else 0.0
        flags[KNOWN] = True
        return
    absolute(separation.synchronous, length)
    gain = min(1.0, elapsed / DIRECTION_MEMORY)
    for k in range(length.size):
        long[k] = np.maximum(length[k], 1e-300)
    product(whole, separation.synchronous, new)
    quotient(new, long, new)
    long[:] = gain
    for k in range(length.size):
        new[k] -= arm[k]
    product(long, new, new)
    for k in range(length.size):
        new[k] += arm[k]
    trusted = work[3]
    for k in range(length.size):
        trusted[k] = 1.0 if abs(length[k] - radius[k]) < DIRECTION_GATE * radius[k] else 0.0
    absolute(new, length)
    for k in range(length.size):
        long[k] = radius[k] / np.maximum(length[k], 1e-300)
    product(new, long, new)
    for k in range(length.size):
        if trusted[k].real > 0.0:
            arm[k] = new[k]
