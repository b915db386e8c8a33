# SPDX-License-Identifier: Apache-2.0
"""Time base and angle of rotation of the sample stream, and averages of the samples over bins of 1/16 revolution.

All estimators work on these bins, so that a window is a fixed number of revolutions at any sample rate, and averaging
reduces noise as far as the rate allows. A bin of 1/16 revolution shortens an orbit of precession ratio p by
sinc(p / 16): 0.2 % at p = 0.5, 2.3 % at p = -1.9. Where samples are farther apart than 1/16 revolution, each is a bin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel

STARTED, FIRST, LAST, DUPLICATE, LATE = range(5)
"""Indices into `Clock.stamps`: 1 after the first sample; first and last stamp accepted [ns]; samples skipped since
their stamp is not after the last one."""
TOTAL_ANGLE, TOTAL_REVOLUTIONS, TOP_SPEED = range(3)
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
        before = top_speed if math.isnan(rotation[TOP_SPEED]) else rotation[TOP_SPEED]
        increment = 0.5 * (before + top_speed) * step
        rotation[TOP_SPEED] = top_speed
    elif has_spin:
        increment = _mean_increment(clock, spin)
        rotation[TOP_SPEED] = math.nan
    else:
        return
    rotation[TOTAL_ANGLE] += increment
    rotation[TOTAL_REVOLUTIONS] += abs(increment) / math.tau


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


BINS = 16
"""Bins in a revolution."""
LONGEST = 0.5
"""Longest bin [s], for a string that hardly rotates."""

TIME, ANGLE, REVOLUTIONS, START = range(4)
"""Indices into numbers of a bin: time [s], angle of rotation [rad] and revolutions since the first sample; time at
which the bin starts [s]."""
SAMPLES, FORCES, CELL = range(3)
"""Indices into counts of a bin: samples, those with wall forces, and the number of the bin since the first sample."""


class Bin(NamedTuple):
    """Means over a bin."""

    numbers: Array  # time [s], angle [rad], revolutions [rev]
    counts: Integers  # samples, those with wall forces
    position: ComplexArray  # (m,) position of the marked point x + i y [m]
    phasor: ComplexArray  # (m,) unit vector of the spin, exp(i spin)
    contact: Array  # (m,) share of the samples with a wall force, if forces are given
    valid: Mask  # (m,) marks with at least one valid sample

    @classmethod
    def of(cls, m: int) -> Bin:
        """Empty bin of m marks."""
        position, phasor = np.zeros((2, m), complex)
        return cls(np.zeros(3), np.zeros(2, np.int64), position, phasor, np.zeros(m), np.zeros(m, bool))


class SampleBins(NamedTuple):
    """Sums over the samples of the bin that is being filled."""

    numbers: Array
    counts: Integers
    position: ComplexArray  # (m,) [m]
    phasor: ComplexArray  # (m,)
    missed: Array  # (m,) samples without the mark
    touching: Array  # (m,) samples with a wall force

    @classmethod
    def of(cls, m: int) -> SampleBins:
        """Empty sums of m marks."""
        position, phasor = np.zeros((2, m), complex)
        return cls(np.zeros(4), np.zeros(3, np.int64), position, phasor, np.zeros(m), np.zeros(m))


@strict_kernel
def is_full(bins: SampleBins, time: float, revolutions: float) -> bool:
    """Check whether a sample at `time` [s] and `revolutions` [rev] lies beyond the present bin."""
    beyond = math.floor(revolutions * BINS) != bins.counts[CELL] or time - bins.numbers[START] > LONGEST
    return bool(bins.counts[SAMPLES] > 0 and beyond)


@strict_kernel
def add(
    bins: SampleBins,
    at: tuple[float, float, float],
    position: ComplexArray,
    phasor: ComplexArray,
    seen: Mask,
    force: Array,
    has_force: bool,
) -> None:
    """Add a sample.

    Args:
        bins: The sums.
        at: Time [s], angle of rotation [rad] and revolutions [rev] since the first sample.
        position: Position [m], shape (m,).
        phasor: Unit vector of the spin, shape (m,).
        seen: Marks with a valid position, shape (m,).
        force: Wall force [N], shape (m,).
        has_force: The force is known.
    """
    numbers, counts = bins.numbers, bins.counts
    if counts[SAMPLES] == 0:
        counts[CELL] = math.floor(at[REVOLUTIONS] * BINS)
        numbers[START] = at[TIME]
    counts[SAMPLES] += 1
    numbers[TIME] += at[TIME]
    numbers[ANGLE] += at[ANGLE]
    numbers[REVOLUTIONS] += at[REVOLUTIONS]
    counts[FORCES] += has_force
    for k in range(seen.size):
        if seen[k]:
            bins.position[k] += position[k]
            bins.phasor[k] += phasor[k]
        else:
            bins.missed[k] += 1.0
        if has_force and force[k] > 0.0:
            bins.touching[k] += 1.0


@strict_kernel
def close(bins: SampleBins, full: Bin) -> None:
    """Write the means of the present bin to `full` and start a new one."""
    numbers, counts = bins.numbers, bins.counts
    n = counts[SAMPLES]
    full.counts[SAMPLES], full.counts[FORCES] = n, counts[FORCES]
    for k in range(3):
        full.numbers[k] = numbers[k] / n
        numbers[k] = 0.0
    for k in range(full.valid.size):
        found = n - bins.missed[k]
        full.position[k] = bins.position[k] / max(found, 1.0)
        full.phasor[k] = bins.phasor[k] / max(found, 1.0)
        full.valid[k] = found > 0.0
        full.contact[k] = bins.touching[k] / counts[FORCES] if counts[FORCES] else 0.0
    bins.position[:] = 0.0
    bins.phasor[:] = 0.0
    bins.missed[:] = 0.0
    bins.touching[:] = 0.0
    counts[SAMPLES] = counts[FORCES] = 0
