# SPDX-License-Identifier: Apache-2.0
"""Time base and angle of rotation of the sample stream."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array


class StampFilter:
    """Accepts stamps that increase; counts duplicate and late ones."""

    def __init__(self) -> None:
        self.first: int | None = None
        """First stamp [ns]."""
        self.last = 0
        """Last stamp accepted [ns]."""
        self.duplicate = 0
        self.late = 0

    def is_new(self, stamp: int) -> bool:
        """Check that a stamp [ns] is after the last one accepted; count it as duplicate or late if not."""
        if self.first is None or stamp > self.last:
            return True
        if stamp == self.last:
            self.duplicate += 1
        else:
            self.late += 1
        return False

    def accept(self, stamp: int) -> float:
        """Accept a new stamp [ns]; return the time since the one before [s], 0 for the first."""
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
        self.revolutions = 0.0
        """Revolutions since the first sample [rev], in either sense; never decreases."""
        self._speed: float | None = None
        self._spin: Array | None = None

    def update(self, step: float, top_speed: float, spin: Array | None) -> None:
        """Add the rotation over a sample interval; nothing where neither speed nor spin is known.

        Args:
            step: Time since the last sample [s].
            top_speed: Speed of the top drive [rad/s]; nan where unknown.
            spin: Spin at the marks [rad], shape (m,), if measured.
        """
        if math.isfinite(top_speed):
            before = top_speed if self._speed is None else self._speed
            increment = 0.5 * (before + top_speed) * step
            self._speed = top_speed
        elif spin is not None:
            increment = self._mean_increment(spin)
            self._speed = None
        else:
            return
        self.angle += increment
        self.revolutions += abs(increment) / math.tau

    def _mean_increment(self, spin: Array) -> float:
        """Mean change of the spin since the last sample [rad], each wrapped to -pi..pi."""
        before = np.full_like(spin, math.nan) if self._spin is None else self._spin
        wrapped = np.remainder(spin - before + math.pi, math.tau) - math.pi
        known = wrapped[np.isfinite(wrapped)]
        self._spin = spin.copy()
        return float(known.mean()) if known.size else 0.0
