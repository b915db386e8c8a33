# SPDX-License-Identifier: Apache-2.0
"""Time and rotation of the stream: which stamps count, and how far the string has turned."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array

"""One revolution [rad]."""


class Stamps:
    """Lets each stamp through once and in order; counts what it turns away."""

    def __init__(self) -> None:
        self.first: int | None = None
        """First stamp [ns]."""
        self.last = 0
        """Last stamp let through [ns]."""
        self.duplicate = 0
        self.late = 0

    def fresh(self, stamp: int) -> bool:
        """Whether a stamp [ns] lies after all before it; counts it if not."""
        if self.first is None or stamp > self.last:
            return True
        if stamp == self.last:
            self.duplicate += 1
        else:
            self.late += 1
        return False

    def take(self, stamp: int) -> float:
        """Makes a fresh stamp [ns] the last one; the time since the one before it [s], 0 for the first."""
        if self.first is None:
            self.first = self.last = stamp
            return 0.0
        step = (stamp - self.last) * 1e-9
        self.last = stamp
        return step

    @property
    def seconds(self) -> float:
        """Time from the first to the last stamp [s]."""
        return 0.0 if self.first is None else (self.last - self.first) * 1e-9


class Rotation:
    """Angle of rotation: the integral of the top speed, or the mean spin of the marks where that is unknown."""

    def __init__(self) -> None:
        self.angle = 0.0
        """Angle since the first sample [rad], signed."""
        self.travel = 0.0
        """Revolutions turned since the first sample, never falling [rev]."""
        self._speed: float | None = None
        self._spin: Array | None = None

    def advance(self, step: float, top_speed: float, spin: Array | None) -> bool:
        """Turns on by a sample after `step` [s] at `top_speed` [rad/s] (nan: unknown) with `spin` [rad], shape (m,).

        Returns whether the rotation is known.
        """
        if math.isfinite(top_speed):
            before = top_speed if self._speed is None else self._speed
            turned = 0.5 * (before + top_speed) * step
            self._speed = top_speed
        elif spin is not None:
            turned = self._turned_by_spin(spin)
            self._speed = None
        else:
            return False
        self.angle += turned
        self.travel += abs(turned) / math.tau
        return True

    def _turned_by_spin(self, spin: Array) -> float:
        before = np.full_like(spin, math.nan) if self._spin is None else self._spin
        wrapped = np.remainder(spin - before + math.pi, math.tau) - math.pi
        known = wrapped[np.isfinite(wrapped)]
        self._spin = spin.copy()
        return float(known.mean()) if known.size else 0.0
