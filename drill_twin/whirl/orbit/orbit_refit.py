# SPDX-License-Identifier: Apache-2.0
"""Second fit of offset and synchronous part, with the detected orbit in the model.

The running fit of `runout_separation` has no orbit in its model, so that a slow or slowly growing one leaks into the
offset, and one near the rotation into the synchronous part. Once whirl is detected, the last revolutions are fitted
with z = c + S e + A rho(t) exp(i omega t), where radius rho and rate omega come from the residual of the fit before;
three iterations converge. The residual z - c - S e is the undistorted orbit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray

ITERATIONS = 3
LONGEST = 28.0
"""Longest record to fit [rev]."""
SHORTEST = 12
"""Shortest record to fit [bins]."""
SMALLEST_DETERMINANT = 0.1
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
    time: Array, sample: ComplexArray, orbit: ComplexArray, recent: int, rate: float, half_width: int
) -> OrbitRefit | None:
    """Fit offset, synchronous part and orbit of a mark; None where the fit is singular.

    Args:
        time: Times of the bins [s], shape (n,).
        sample: Position [m] and phasor, shape (n, 2).
        orbit: First estimate of the asynchronous part [m], shape (n,).
        recent: Number of newest bins from which the rate is estimated.
        rate: First estimate of the rate [rad/s].
        half_width: Half width of the average for the radius [bins].
    """
    n = time.size
    if n < SHORTEST:
        return None
    position, phasor = sample[:, 0], sample[:, 1]
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
        if abs(np.linalg.det(gram)) < SMALLEST_DETERMINANT:
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
    radius: Array = np.sqrt(np.maximum(np.abs(mean) ** 2 - 2.0 * noise**2 / width, 0.0))
    return radius


def _mean_rate(time: Array, orbit: ComplexArray, rate: float) -> float:
    """Rate of the angle [rad/s] by least squares weighted with the power, near a first estimate."""
    angle = np.unwrap(np.angle(orbit * np.exp(-1j * rate * time)))
    weight = np.abs(orbit) ** 2
    total = float(weight.sum())
    if total <= 0.0:
        return rate
    centred = time - float((weight * time).sum()) / total
    return rate + float((weight * centred * angle).sum() / (weight * centred * centred).sum())
