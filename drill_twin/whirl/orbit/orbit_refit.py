# SPDX-License-Identifier: Apache-2.0
"""Offset and synchronous part once more, now that there is an orbit to tell them from.

The running fit of `separation` knows no orbit, so a slow or slowly growing one leaks into the offset, and one near the
rotation into the synchronous part. Once whirl is certain, the last revolutions are fitted again with the orbit in the
model, z = c + S e + A rho(t) exp(i omega t), with its own radius rho and pace omega from the residual of the fit
before; three rounds settle. What is left, z - c - S e, is the orbit undistorted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.onset.crossing_time import smoothed_radius

ROUNDS = 3
LONGEST = 28.0
"""Revolutions fitted at most."""
SHORTEST = 12
"""Bins needed to fit at all."""
DETERMINED = 0.1
"""Least determinant of the normalised fit: the orbit has turned by some 70 degrees in the hole and in the string."""


@dataclass(frozen=True, eq=False)
class Refit:
    """The last revolutions of a mark, told apart with the orbit in mind."""

    offset: complex
    """Offset [m]."""
    synchronous: complex
    """Synchronous part of the marked point, the arm of a wall mark included [m]."""
    orbit: ComplexArray
    """Asynchronous part [m], shape (n,)."""
    pace: float
    """Its rate of turning [rad/s]."""


def refit(
    time: Array, sample: ComplexArray, orbit: ComplexArray, recent: int, pace: float, half_width: int
) -> Refit | None:
    """Fits the bins at `time` [s], shape (n,), of `sample` (place and turn), shape (n, 2), anew.

    `orbit` is the asynchronous part so far [m], shape (n,); its pace is taken from the `recent` newest bins. None
    where the fit is not determined.
    """
    n = time.size
    if n < SHORTEST:
        return None
    place, turn = sample[:, 0], sample[:, 1]
    since = time - time[-1]
    offset = synchronous = 0j
    for _ in range(ROUNDS):
        pace = _pace(since[-recent:], orbit[-recent:], pace)
        steady = np.exp(1j * pace * since)
        envelope = smoothed_radius(orbit * steady.conj(), half_width, 0.0) * steady
        columns = (np.ones(n, complex), turn, envelope)
        norms = [float(np.sqrt((np.abs(column) ** 2).sum())) for column in columns]
        if min(norms) <= 0.0:
            return None
        unit = [column / norm for column, norm in zip(columns, norms, strict=True)]
        gram = np.array([[(a.conj() * b).sum() for b in unit] for a in unit])
        if abs(np.linalg.det(gram)) < DETERMINED:
            return None
        parts = np.linalg.solve(gram, np.array([(a.conj() * place).sum() for a in unit]))
        offset, synchronous = complex(parts[0]) / norms[0], complex(parts[1]) / norms[1]
        orbit = place - offset - synchronous * turn
    return Refit(offset, synchronous, orbit, _pace(since[-recent:], orbit[-recent:], pace))


def _pace(time: Array, orbit: ComplexArray, pace: float) -> float:
    """Rate of the angle [rad/s], by least squares weighted with the power, near a first guess."""
    angle = np.unwrap(np.angle(orbit * np.exp(-1j * pace * time)))
    weight = np.abs(orbit) ** 2
    total = float(weight.sum())
    if total <= 0.0:
        return pace
    centred = time - float((weight * time).sum()) / total
    return pace + float((weight * centred * angle).sum() / (weight * centred * centred).sum())
