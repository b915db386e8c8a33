# SPDX-License-Identifier: Apache-2.0
"""Time base and angle of rotation of the sample stream."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.exact_jit import Integers, exact_kernel
from drill_twin.base.numpy_loops import remainder, total

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
    turn: Array  # (m,) work
    known: Array  # (m,) work
    full_turn: Array  # (m,) of 2 pi
    sum: Array  # (1,) work

    @classmethod
    def of(cls, m: int) -> Clock:
        """Clock before the first sample."""
        rotation, spin = np.array([0.0, 0.0, math.nan]), np.full(m, math.nan)
        return cls(np.zeros(5, np.int64), rotation, spin, np.zeros(m), np.zeros(m), np.full(m, math.tau), np.zeros(1))

    @property
    def seconds(self) -> float:
        """Time from the first to the last stamp [s]."""
        return int(self.stamps[LAST] - self.stamps[FIRST]) * 1e-9


@exact_kernel
def is_new(stamps: Integers, stamp: int) -> bool:
    """Check that a stamp [ns] is after the last one accepted; count it as duplicate or late if not."""
    if not stamps[STARTED] or stamp > stamps[LAST]:
        return True
    stamps[DUPLICATE if stamp == stamps[LAST] else LATE] += 1
    return False


@exact_kernel
def accept(stamps: Integers, stamp: int) -> float:
    """Accept a new stamp [ns]; return the time since the one before [s], 0 for the first."""
    if not stamps[STARTED]:
        stamps[STARTED], stamps[FIRST], stamps[LAST] = 1, stamp, stamp
        return 0.0
    step = (stamp - stamps[LAST]) * 1e-9
    stamps[LAST] = stamp
    return float(step)


@exact_kernel
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


@exact_kernel
def _mean_increment(clock: Clock, spin: Array) -> float:
    """Mean change of the spin since the last sample [rad], each wrapped to -pi..pi."""
    turn, count = clock.turn, 0
    for k in range(spin.size):
        turn[k] = spin[k] - clock.spin[k] + math.pi
        clock.spin[k] = spin[k]
    remainder(turn, clock.full_turn, turn)
    for k in range(spin.size):
        wrapped = turn[k] - math.pi
        if math.isfinite(wrapped):
            clock.known[count] = wrapped
            count += 1
    return total(clock.known[:count], clock.sum) / count if count else 0.0
