# SPDX-License-Identifier: Apache-2.0
"""Time base and angle of rotation of the sample stream, and averages of the samples over bins of 1/16 revolution.

All estimators work on these bins, so that a window is a fixed number of revolutions at any sample rate, and averaging
reduces noise as far as the rate allows. A bin of 1/16 revolution shortens an orbit of precession ratio p by
sinc(p / 16): 0.2 % at p = 0.5, 2.3 % at p = -1.9. Where samples are farther apart than 1/16 revolution, each is a bin.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.columns import Columns, columns


def new_clock(m: int) -> Columns:
    """Clock before the first sample of m marks: stamps accepted, and angle of rotation.

    The angle is the integral of the top speed, or the mean spin of the marks.
    """
    return columns(
        "Clock",
        1,
        started=0,  # 1 after the first sample
        first=0,  # stamp accepted [ns]
        last=0,  # stamp accepted [ns]
        duplicate=0,  # samples skipped because their stamp is the last one
        late=0,  # samples skipped because their stamp is before the last one
        angle=0.0,  # since the first sample [rad], signed
        revolutions=0.0,  # since the first sample in either sense, never decreasing [rev]
        top_speed=math.nan,  # last speed of the top drive [rad/s]; nan where unknown
        spin=np.full(m, math.nan),  # (m,) of the marks at the last sample without a speed [rad]
    )


@strict_kernel
def seconds_of(clock: Columns) -> float:
    """Time from the first to the last stamp [s]."""
    return float((clock.last[0] - clock.first[0]) * 1e-9)


@strict_kernel
def is_new(clock: Columns, stamp: int) -> bool:
    """Check that a stamp [ns] is after the last one accepted; count it as duplicate or late if not."""
    if not clock.started[0] or stamp > clock.last[0]:
        return True
    skipped = clock.duplicate if stamp == clock.last[0] else clock.late
    skipped[0] += 1
    return False


@strict_kernel
def accept(clock: Columns, stamp: int) -> float:
    """Accept a new stamp [ns]; return the time since the stamp before [s], 0 for the first stamp."""
    if not clock.started[0]:
        clock.started[0], clock.first[0], clock.last[0] = 1, stamp, stamp
        return 0.0
    step = (stamp - clock.last[0]) * 1e-9
    clock.last[0] = stamp
    return float(step)


@strict_kernel
def rotate(clock: Columns, step: float, top_speed: float, spin: Array, has_spin: bool) -> None:
    """Add the rotation over a sample interval; nothing where neither speed nor spin is known.

    Args:
        clock: The clock.
        step: Time since the last sample [s].
        top_speed: Speed of the top drive [rad/s]; nan where unknown.
        spin: Spin at the marks [rad], shape (m,).
        has_spin: The spin is measured.
    """
    if math.isfinite(top_speed):
        before = top_speed if math.isnan(clock.top_speed[0]) else clock.top_speed[0]
        increment = 0.5 * (before + top_speed) * step
        clock.top_speed[0] = top_speed
    elif has_spin:
        increment = _mean_increment(clock, spin)
        clock.top_speed[0] = math.nan
    else:
        return
    clock.angle[0] += increment
    clock.revolutions[0] += abs(increment) / math.tau


@strict_kernel
def _mean_increment(clock: Columns, spin: Array) -> float:
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
"""Bins in a revolution: the module's docstring has what they shorten; other numbers were not compared."""
LONGEST_BIN = 0.5
"""Longest bin [s], for a string that hardly rotates; chosen, not measured."""


def new_bin(m: int) -> Columns:
    """Means over a bin of m marks."""
    return columns(
        "Bin",
        m,
        time=np.zeros(1),  # since the first sample [s]
        angle=np.zeros(1),  # of rotation [rad]
        revolutions=np.zeros(1),  # since the first sample [rev]
        seconds=np.zeros(1),  # since the bin before [s]
        turned=np.zeros(1),  # rotation since the bin before [rad], signed
        elapsed=np.zeros(1),  # since the bin before [rev]
        samples=np.zeros(1, np.int64),
        position=0j,  # of the marked point x + i y [m]
        phasor=0j,  # unit vector of the spin, exp(i spin)
        contact=0.0,  # share of the samples in contact with the wall
        valid=False,  # True for a mark with at least one valid sample
    )


def new_sums(m: int) -> Columns:
    """Sums over the samples of the bin that is being filled, of m marks."""
    return columns(
        "SampleBins",
        m,
        time=np.zeros(1),
        angle=np.zeros(1),
        revolutions=np.zeros(1),
        start=np.zeros(1),  # time at which the bin starts [s]
        samples=np.zeros(1, np.int64),
        number=np.zeros(1, np.int64),  # of the bin since the first sample
        position=0j,
        phasor=0j,
        missed=0.0,  # samples without the mark
        touching=0.0,  # samples in contact with the wall
    )


@strict_kernel
def is_full(bins: Columns, time: float, revolutions: float) -> bool:
    """Check whether a sample at `time` [s] and `revolutions` [rev] lies beyond the present bin."""
    beyond = math.floor(revolutions * BINS) != bins.number[0] or time - bins.start[0] > LONGEST_BIN
    return bool(bins.samples[0] > 0 and beyond)


@strict_kernel
def add(
    bins: Columns,
    clock: Columns,
    position: ComplexArray,
    phasor: ComplexArray,
    seen: Mask,
    touches: Mask,
) -> None:
    """Add a sample.

    Args:
        bins: The sums.
        clock: Time and rotation.
        position: Position [m], shape (m,).
        phasor: Unit vector of the spin, shape (m,).
        seen: Marks with a valid position, shape (m,).
        touches: Marks in contact with the wall, shape (m,).
    """
    time = seconds_of(clock)
    if bins.samples[0] == 0:
        bins.number[0] = math.floor(clock.revolutions[0] * BINS)
        bins.start[0] = time
    bins.samples[0] += 1
    bins.time[0] += time
    bins.angle[0] += clock.angle[0]
    bins.revolutions[0] += clock.revolutions[0]
    for k in range(seen.size):
        if seen[k]:
            bins.position[k] += position[k]
            bins.phasor[k] += phasor[k]
        else:
            bins.missed[k] += 1.0
        if touches[k]:
            bins.touching[k] += 1.0


@strict_kernel
def close(bins: Columns, full: Columns) -> None:
    """Write the means of the present bin to `full` and start a new one."""
    n = full.samples[0] = bins.samples[0]
    time, angle, revolutions = bins.time[0] / n, bins.angle[0] / n, bins.revolutions[0] / n
    full.seconds[0], full.turned[0] = time - full.time[0], angle - full.angle[0]
    full.elapsed[0] = revolutions - full.revolutions[0]
    full.time[0], full.angle[0], full.revolutions[0] = time, angle, revolutions
    bins.time[0] = bins.angle[0] = bins.revolutions[0] = 0.0
    for k in range(full.valid.size):
        found = n - bins.missed[k]
        full.valid[k] = found > 0.0
        if found > 0.0:  # else the last is kept
            full.position[k], full.phasor[k] = bins.position[k] / found, bins.phasor[k] / found
            full.contact[k] = bins.touching[k] / found
        bins.position[k] = bins.phasor[k] = bins.missed[k] = bins.touching[k] = 0.0
    bins.samples[0] = 0
