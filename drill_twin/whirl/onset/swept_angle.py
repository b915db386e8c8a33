# SPDX-License-Identifier: Apache-2.0
"""Angle swept by a vector, by which a whirl is told from a string that is displaced or swings.

Two measures must agree. The change of the mean angle, averaged over half a revolution at either end, is insensitive to
noise; the swept area, sum Im(conj(v_i) v_i+1) over the mean of |v|^2, is zero for a string that swings in a plane,
whose angle jumps by pi with each passage of the centre.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray

SLOWEST = math.radians(1.5)
"""Smallest angle that a steady precession sweeps in each half of the window [rad]; chosen, not measured."""


class SweptAngle:
    """Angle swept by a vector in the frame of the hole and in the rotating frame, by halves of the window."""

    def __init__(
        self, vector: ComplexArray, rotation: Array, half: int, angle: Array | None = None, carrier: Array | None = None
    ) -> None:
        """Measure the angles of `vector`.

        Args:
            vector: The vector, shape (n,).
            rotation: Angle of rotation [rad], shape (n,).
            half: Number of bins of half a revolution.
            angle: Unwrapped angle of the vector [rad], shape (n,), where it is known.
            carrier: Angle of its carrier [rad], shape (n,), where it turns too fast for its bins (`orbit.carrier`).
        """
        if carrier is not None:
            vector, angle = vector * np.exp(-1j * carrier), None
        angle = np.unwrap(np.angle(vector)) if angle is None else angle
        half = max(1, min(vector.size // 2, half))
        self._hole = _by_halves(vector, angle, half)
        if carrier is None:
            self._string = _by_halves(vector * np.exp(-1j * rotation), angle - rotation, half)
        else:
            slow, in_hole, in_string = self._hole, _turns(carrier, half), _turns(carrier - rotation, half)
            self._hole = slow[0] + in_hole[0], slow[1] + in_hole[1]
            self._string = slow[0] + in_string[0], slow[1] + in_string[1]

    @property
    def in_hole(self) -> float:
        """Angle swept in the frame of the hole [rad]."""
        return abs(self._hole[0] + self._hole[1])

    @property
    def in_string(self) -> float:
        """Angle swept in the frame of the string [rad]."""
        return abs(self._string[0] + self._string[1])

    @property
    def smallest(self) -> float:
        """Smaller angle of the two angles swept in the two frames [rad]."""
        return min(self.in_hole, self.in_string)

    @property
    def steady(self) -> bool:
        """True if the vector turns in one sense in both halves and both frames, however slowly."""
        return all(
            first * second > 0.0 and min(abs(first), abs(second)) > SLOWEST
            for first, second in (self._hole, self._string)
        )


def _by_halves(vector: ComplexArray, angle: Array, half: int) -> tuple[float, float]:
    """Angle swept in the first and in the second half of the bins [rad], by both measures."""
    first, second = _turns(angle, half)
    cut = angle.size // 2
    return _smaller(first, _from_area(vector[: cut + 1])), _smaller(second, _from_area(vector[cut:]))


def _turns(angle: Array, half: int) -> tuple[float, float]:
    """Change of the mean angle in the first and in the second half of the bins [rad]."""
    middle = (angle.size - half) // 2
    first = float(angle[:half].sum()) / half
    between = float(angle[middle : middle + half].sum()) / half
    last = float(angle[-half:].sum()) / half
    return between - first, last - between


def _from_area(vector: ComplexArray) -> float:
    """Twice the swept area over the mean square of the radius [rad]."""
    area = float((vector[:-1].conj() * vector[1:]).imag.sum())
    return area * vector.size / (float((vector.real**2 + vector.imag**2).sum()) + 1e-300)


def _smaller(one: float, other: float) -> float:
    """The smaller of two angles of one sign; 0 if their signs differ."""
    return min(one, other, key=abs) if one * other > 0.0 else 0.0
