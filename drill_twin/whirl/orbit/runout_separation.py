# SPDX-License-Identifier: Apache-2.0
"""Separation of spin, offset and synchronous part (runout, API 670) from the asynchronous motion of the marks.

A mark on the outer wall is at z = c + S e + a + r_o e exp(i alpha), with e = exp(i spin). Where the spin is measured,
r_o e is known and subtracted exactly. Otherwise, e = exp(i angle of the top drive), and the direction alpha is fitted
too: the string starts near the axis, so that the synchronous part of the mark is at first r_o exp(i alpha), and alpha
then follows slowly while the synchronous part keeps about that length.

The offset c and the synchronous part S are a least-squares fit of z = c + S e with exponentially fading memory
(`criteria.SEPARATION_MEMORY` revolutions), in closed form from running sums; its residual a is the asynchronous part.
The fit is exact for irregular bins and for a rotation that has hardly begun. An orbit of ratio p keeps the fraction
|2 pi p N / (1 + 2 pi i p N)| of its radius against the offset, and the same with p - 1 against S: 0.994 at p = 0.5 and
0.97 at p = -0.1 for N = 6. The fit is held while a mark may have begun to whirl, and fades slowly
(`criteria.SEPARATION_MEMORY_IN_WHIRL`) while it whirls.

This running fit has no orbit in its model, so that a slow or slowly growing orbit leaks into the offset, and an orbit
near the rotation into the synchronous part. Once whirl is detected, the last revolutions are fitted again with
z = c + S e + A rho(t) exp(i omega t), where radius rho and rate omega come from the residual of the fit before; three
iterations converge. The residual z - c - S e is the undistorted orbit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.compile.jit import copy, strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns

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
"""Value of `spin_given` before the first sample."""


def new_separation(radius: Array) -> Columns:
    """Offset and synchronous part of m marks, fitted bin by bin, before the first bin.

    `radius` is the distance of wall marks from the centre line, else 0 [m], shape (m,).
    """
    m = radius.size
    return columns(
        "RunoutSeparation",
        m,
        offset=0j,  # c [m]
        synchronous=0j,  # synchronous part of the marked point, the arm of a wall mark included [m]
        arm=0j,  # from the centre line to the marked point, in the rotating frame [m]
        vector=np.zeros((3, m), complex),  # asynchronous, moving and synchronous part of the newest bin [m]
        distance=0.0,  # of the centre line from the hole's axis [m]
        sums=np.zeros((5, m), complex),  # of 1, |e|^2, e, z, z conj(e)
        memory=criteria.SEPARATION_MEMORY,  # [rev]
        held=False,
        determinant=0.0,
        radius=radius,  # of wall marks r_o, else 0 [m]
        spin_given=np.full(1, NOT_KNOWN),  # 1 where the samples contain the spin of the marks, else 0
        known=np.zeros(1, bool),  # the arms are known
        calibrated=np.zeros(1, bool),  # the arms are calibrated
        directed=np.full(1, radius.any()),  # there are wall marks
    )


def correct(separation: Columns, mark: int, refit: OrbitRefit) -> None:
    """Replace the offset and the synchronous part of a mark by the values of a refit."""
    bins = refit.orbit.size
    separation.sums[:, mark] = (bins, bins, 0.0, bins * refit.offset, bins * refit.synchronous)


def fit_anew(separation: Columns, mark: int, position: ComplexArray, phasor: ComplexArray) -> None:
    """Fit a mark from bins of position [m] and phasor alone, shape (n,) each: its offset or bow has changed."""
    back = phasor.conj()
    rows = (phasor != 0.0, phasor * back, phasor, position, position * back)  # phasor 0: no sample
    separation.sums[:, mark] = [complex(row.sum()) for row in rows]


@strict_kernel
def start(separation: Columns, spin_given: bool) -> None:
    """Set, with the first sample, whether the samples contain the spin."""
    separation.spin_given[0] = spin_given
    separation.known[0] = separation.calibrated[0] = spin_given or not separation.directed[0]
    if spin_given:
        copy(separation.radius, separation.arm)


@strict_kernel
def hold(separation: Columns, candidates: Array, whirling: Mask) -> None:
    """Hold the fit of marks that may have begun to whirl, slow the fading of marks that whirl.

    Args:
        separation: The separation.
        candidates: Time at which each mark may have begun [s], nan for none, shape (m,).
        whirling: Marks that whirl, shape (m,).
    """
    for k in range(whirling.size):
        may = not math.isnan(candidates[k])
        separation.held[k] = may and separation.determinant[k] > CALIBRATED_FROM and not whirling[k]
        separation.memory[k] = criteria.SEPARATION_MEMORY_IN_WHIRL if whirling[k] else criteria.SEPARATION_MEMORY


@strict_kernel
def separate(separation: Columns, full: Columns, left: ComplexArray, shift: ComplexArray) -> None:
    """Separate the parts of a bin: `vector` and `distance`; a mark without a valid sample keeps its last vectors.

    What is `left` of fast orbits in the mean position [m], shape (m,), is taken out for the fit of offset and
    synchronous part, and the whole is given back then, by `shift` [m]: seen once a bin, an orbit of 16 or 15 turns in a
    revolution would pass for an offset or a synchronous part.
    """
    elapsed = max(full.elapsed[0], SLOWEST * full.seconds[0])
    for k in range(left.size):
        full.position[k] -= left[k]
        _add_bin(separation, full, k, math.exp(-elapsed / separation.memory[k]))
        _fit(separation, k)
        full.position[k] += shift[k]
    if not separation.spin_given[0] and separation.directed[0]:
        if separation.calibrated[0]:
            _update_direction(separation, elapsed)
        else:
            _find_direction(separation)
    for k in range(left.size):
        phasor, position = full.phasor[k], full.position[k]
        centre = position - separation.arm[k] * phasor
        separation.distance[k] = abs(centre)
        if full.valid[k]:
            moving = centre - separation.offset[k]
            separation.vector[0, k] = position - separation.offset[k] - separation.synchronous[k] * phasor
            separation.vector[1, k] = moving
            separation.vector[2, k] = moving * phasor.conjugate()


@strict_kernel
def _add_bin(separation: Columns, full: Columns, k: int, fade: float) -> None:
    """Let the sums of a mark fade and add the bin, unless the fit is held."""
    sums = separation.sums
    if separation.held[k]:
        return
    seen = 1.0 if full.valid[k] else 0.0
    phasor, position = seen * full.phasor[k], seen * full.position[k]
    sums[0, k] = fade * sums[0, k] + seen
    sums[1, k] = fade * sums[1, k] + phasor * phasor.conjugate()
    sums[2, k] = fade * sums[2, k] + phasor
    sums[3, k] = fade * sums[3, k] + position
    sums[4, k] = fade * sums[4, k] + position * phasor.conjugate()


@strict_kernel
def _fit(separation: Columns, k: int) -> None:
    """Fit offset and synchronous part of a marked point; the arm is the synchronous part until an arc is turned."""
    sums = separation.sums
    count, power = sums[0, k].real + 1e-300, sums[1, k].real
    cross, position, rotated = sums[2, k], sums[3, k], sums[4, k]
    scale = max(count * power, 1e-300)
    determinant = scale - (cross.real * cross.real + cross.imag * cross.imag)
    separation.determinant[k] = determinant / scale
    if separation.determinant[k] > SMALLEST_DETERMINANT:
        separation.offset[k] = (power * position - cross * rotated) / determinant
        separation.synchronous[k] = (count * rotated - cross.conjugate() * position) / determinant
    else:
        separation.offset[k] = (position - separation.arm[k] * cross) / count
        separation.synchronous[k] = separation.arm[k]


@strict_kernel
def _find_direction(separation: Columns) -> None:
    """Take the first direction of the wall marks, for samples without spin.

    Before 2/3 of a revolution, the string is assumed to be near the axis.
    """
    calibrated = True
    for k in range(separation.radius.size):
        calibrated = calibrated and separation.determinant[k] > CALIBRATED_FROM
    separation.calibrated[0] = calibrated
    source = separation.synchronous if calibrated else separation.sums[4]
    for k in range(separation.radius.size):
        length = abs(source[k])
        separation.arm[k] = separation.radius[k] * source[k] / length if length > 0.0 else 0.0
    separation.known[0] = True


@strict_kernel
def _update_direction(separation: Columns, elapsed: float) -> None:
    """Rotate the arms of wall marks towards their synchronous part, for samples without spin."""
    gain = min(1.0, elapsed / DIRECTION_MEMORY)
    for k in range(separation.radius.size):
        arm, radius, synchronous = separation.arm[k], separation.radius[k], separation.synchronous[k]
        length = abs(synchronous)
        if abs(length - radius) < DIRECTION_GATE * radius:
            new = arm + gain * (radius * synchronous / max(length, 1e-300) - arm)
            separation.arm[k] = radius * new / max(abs(new), 1e-300)


ITERATIONS = 3
REFIT_REVOLUTIONS = 28.0
"""Longest record that is fitted [rev]: `criteria.LONGEST_SWEEP_WINDOW`, within which a crossing may be confirmed."""
REFIT_BINS = 12
"""Shortest record that is fitted [bins], 3/4 of a revolution; chosen, not measured."""
LEAST_SWEEP = 0.1
"""Smallest determinant of the normalised fit: the orbit has swept some 70 degrees in the frames of hole and string."""


@dataclass(frozen=True, eq=False)
class OrbitRefit:
    """Parts of the motion of a mark over the last revolutions."""

    offset: complex
    """Offset [m]."""
    synchronous: complex
    """Synchronous part of the marked point, the arm of a wall mark included [m]."""
    orbit: ComplexArray
    """Asynchronous part [m], shape (n,)."""
    rate: float
    """Rate of its angle [rad/s]."""


def refit_orbit(
    time: Array,
    position: ComplexArray,
    phasor: ComplexArray,
    orbit: ComplexArray,
    recent: int,
    rate: float,
    half_width: int,
) -> OrbitRefit | None:
    """Fit offset, synchronous part and orbit of a mark; None where the fit is singular.

    Args:
        time: Times of the bins [s], shape (n,).
        position: Position [m], shape (n,).
        phasor: Unit vector of the spin, shape (n,).
        orbit: First estimate of the asynchronous part [m], shape (n,).
        recent: Number of newest bins from which the rate is estimated.
        rate: First estimate of the rate [rad/s].
        half_width: Half width of the average for the radius [bins].
    """
    n = time.size
    if n < REFIT_BINS:
        return None
    since = time - time[-1]
    offset = synchronous = 0j
    for _ in range(ITERATIONS):
        rate = _mean_rate(since[-recent:], orbit[-recent:], rate)
        carrier = np.exp(1j * rate * since)
        envelope = smoothed_radius(orbit * carrier.conj(), half_width, 0.0) * carrier
        columns = (np.ones(n, complex), phasor, envelope)
        norms = [float(np.sqrt((np.abs(column) ** 2).sum())) for column in columns]
        if min(norms) <= 0.0:
            return None
        unit = [column / norm for column, norm in zip(columns, norms, strict=True)]
        gram = np.array([[(a.conj() * b).sum() for b in unit] for a in unit])
        if abs(np.linalg.det(gram)) < LEAST_SWEEP:
            return None
        parts = np.linalg.solve(gram, np.array([(a.conj() * position).sum() for a in unit]))
        offset, synchronous = complex(parts[0]) / norms[0], complex(parts[1]) / norms[1]
        orbit = position - offset - synchronous * phasor
    return OrbitRefit(offset, synchronous, orbit, _mean_rate(since[-recent:], orbit[-recent:], rate))


def smoothed_radius(vector: ComplexArray, half_width: int, noise: float) -> Array:
    """Radius of a demodulated orbit after a centred moving average, noise removed, shape (n,).

    Args:
        vector: Orbit demodulated with its precession, so that the average does not shorten it, shape (n,).
        half_width: Half width h of the average of 2 h + 1 bins; it is truncated at the ends.
        noise: Noise of a bin per axis, in the unit of `vector`.
    """
    n = vector.size
    sums = np.concatenate(([0.0], np.cumsum(vector)))
    low = np.maximum(np.arange(n) - half_width, 0)
    high = np.minimum(np.arange(n) + half_width + 1, n)
    width = high - low
    mean = (sums[high] - sums[low]) / width
    return np.asarray(np.sqrt(np.maximum(np.abs(mean) ** 2 - 2.0 * noise**2 / width, 0.0)))


def _mean_rate(time: Array, orbit: ComplexArray, rate: float) -> float:
    """Rate of the angle [rad/s] by least squares weighted with the power, near a first estimate."""
    angle = np.unwrap(np.angle(orbit * np.exp(-1j * rate * time)))
    weight = np.abs(orbit) ** 2
    total = float(weight.sum())
    if total <= 0.0:
        return rate
    centred = time - float((weight * time).sum()) / total
    return rate + float((weight * centred * angle).sum() / (weight * centred * centred).sum())
