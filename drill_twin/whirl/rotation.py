# SPDX-License-Identifier: Apache-2.0
"""Time base and angle of rotation of the sample stream."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import strict_kernel

STARTED, FIRST, LAST, DUPLICATE, LATE = range(5)
"""Indices into `Clock.stamps`: 1 after the first sample; first and last stamp accepted [ns]; samples skipped since
their stamp is not after the last one."""
ANGLE, REVOLUTIONS, SPEED = range(3)
"""Indices into `Clock.rotation`: angle since the first sample [rad], signed; revolutions since the first sample in
either sense, never decreasing [rev]; last speed of the top drive [rad/s], nan where unknown."""


class Clock(NamedTuple):
    """Stamps accepted, and the angle of rotation: the integral of the top speed, or the mean spin of the marks."""

    stamps: Integers
    rotation: Array
    spin: Array  # (m,) spin of the marks at the last sample without a speed [rad]

    @classmethod
    def of(cls, m: int) -> Clock:
        """Clock before the first sample."""
        rotation, spin = np.array([0.0, 0.0, math.nan]), np.full(m, math.nan)
        return cls(np.zeros(5, np.int64), rotation, spin)

    @property
    def seconds(self) -> float:
        """Time from the first to the last stamp [s]."""
        return int(self.stamps[LAST] - self.stamps[FIRST]) * 1e-9


@strict_kernel
def is_new(stamps: Integers, stamp: int) -> bool:
    """Check that a stamp [ns] is after the last one accepted; count it as duplicate or late if not."""
    if not stamps[STARTED] or stamp > stamps[LAST]:
        return True
    stamps[DUPLICATE if stamp == stamps[LAST] else LATE] += 1
    return False


@strict_kernel
def accept(stamps: Integers, stamp: int) -> float:
    """Accept a new stamp [ns]; return the time since the one before [s], 0 for the first."""
    if not stamps[STARTED]:
        stamps[STARTED], stamps[FIRST], stamps[LAST] = 1, stamp, stamp
        return 0.0
    step = (stamp - stamps[LAST]) * 1e-9
    stamps[LAST] = stamp
    return float(step)


@strict_kernel
def rotate(clock: Clock, step: float, top_speed: float, spin: Array, has_spin: bool) -> None:
    """Add the rotation over a sample interval; nothing where neither speed nor spin is known.

    Args:
        clock: The clock.
        step: Time since the last sample [s].
        top_speed: Speed of the top drive [rad/s]; nan where unknown.
        spin: Spin at the marks [rad], shape (m,).
        has_spin: The spin is measured.
    """
    rotation = clock.rotation
    if math.isfinite(top_speed):
        before = top_speed if math.isnan(rotation[SPEED]) else rotation[SPEED]
        increment = 0.5 * (before + top_speed) * step
        rotation[SPEED] = top_speed
    elif has_spin:
        increment = _mean_increment(clock, spin)
        rotation[SPEED] = math.nan
    else:
        return
    rotation[ANGLE] += increment
    rotation[REVOLUTIONS] += abs(increment) / math.tau


@strict_kernel
def _mean_increment(clock: Clock, spin: Array) -> float:
    """Mean change of the spin since the last sample [rad], each wrapped to -pi..pi."""
    total, count = 0.0, 0
    for k in range(spin.size):
        wrapped = (spin[k] - clock.spin[k] + math.pi) % math.tau - math.pi
        clock.spin[k] = spin[k]
        if math.isfinite(wrapped):
            total += wrapped
            count += 1
    return total / count if count else 0.0
