# SPDX-License-Identifier: Apache-2.0
"""How far a radius has turned since it crossed its threshold: what tells a whirl from a string that leans or swings.

Two measures of the turn must agree. The mean angle over half a revolution at the end less that at the start is not
moved by noise; the area swept, sum Im(conj(v_i) v_i+1) over the mean of |v|^2, is nought for a string that swings in a
plane, whose angle jumps by half a turn each time it passes the middle.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray

CREEP = math.radians(1.5)
"""A steady turn takes it at least this much farther in each half of the time [rad]."""


class Turned:
    """Turn of a vector over time, as seen from the hole and from the string."""

    def __init__(self, vector: ComplexArray, rotation: Array, half: int, angle: Array | None = None) -> None:
        """Of a vector at the angles of `rotation` [rad], shape (n,); `half` the bins of half a revolution.

        `angle` is its unwrapped angle [rad] where that is known.
        """
        angle = np.unwrap(np.angle(vector)) if angle is None else angle
        half = max(1, min(vector.size // 2, half))
        self._hole = _stages(vector, angle, half)
        self._string = _stages(vector * np.exp(-1j * rotation), angle - rotation, half)

    @property
    def least(self) -> float:
        """How far it turned as seen from the hole or from the string, whichever saw it turn less [rad]."""
        return min(abs(self._hole[0] + self._hole[1]), abs(self._string[0] + self._string[1]))

    @property
    def creeps(self) -> bool:
        """Whether it turns steadily in one sense, however slowly, as seen from both."""
        return all(
            first * second > 0.0 and min(abs(first), abs(second)) > CREEP
            for first, second in (self._hole, self._string)
        )


def _stages(vector: ComplexArray, angle: Array, half: int) -> tuple[float, float]:
    """Turn in the first and in the second half of the bins [rad]."""
    middle = (angle.size - half) // 2
    first = float(angle[:half].sum()) / half
    between = float(angle[middle : middle + half].sum()) / half
    last = float(angle[-half:].sum()) / half
    cut = angle.size // 2
    return (
        _lesser(between - first, _swept(vector[: cut + 1])),
        _lesser(last - between, _swept(vector[cut:])),
    )


def _swept(vector: ComplexArray) -> float:
    """Twice the area swept over the mean square of the radius [rad]."""
    area = float((vector[:-1].conj() * vector[1:]).imag.sum())
    return area * vector.size / (float((vector.real**2 + vector.imag**2).sum()) + 1e-300)


def _lesser(one: float, other: float) -> float:
    """The lesser of two turns of one sense; nought where they disagree in sense."""
    if one * other <= 0.0:
        return 0.0
    return one if abs(one) < abs(other) else other
