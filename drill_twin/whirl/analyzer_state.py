# SPDX-License-Identifier: Apache-2.0
"""State of the analysis of a stream, arrays of fixed size for compiled code, and the steps on each of its samples."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import History
from drill_twin.whirl.marks import MarkArrays
from drill_twin.whirl.motion.classifier import MotionClassifier
from drill_twin.whirl.motion.stick_slip import BitSpeed, add_bit_speed
from drill_twin.whirl.motion.stick_slip_index import INDEX
from drill_twin.whirl.onset.asynchronous_onset import AveragedRadius, Onsets
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsets
from drill_twin.whirl.orbit.carrier import Carrier, follow
from drill_twin.whirl.orbit.orbit import Orbit, StringShape
from drill_twin.whirl.orbit.runout_separation import KNOWN, NOT_KNOWN, SPIN_GIVEN, RunoutSeparation, start
from drill_twin.whirl.run_statistics import RunStatistics
from drill_twin.whirl.sample_bins import (
    FIRST,
    LAST,
    TOTAL_ANGLE,
    TOTAL_REVOLUTIONS,
    Bin,
    Clock,
    SampleBins,
    accept,
    add,
    is_full,
    is_new,
    rotate,
)

LARGEST_RADIUS = 3.0
"""Largest plausible radius of a mark over its clearance; beyond is an error of measurement."""
BLOCK = 256
"""Most samples in a block."""

ACCEPTED, INCOMPLETE, MISSING, GAPS = range(4)
"""Indices into `Samples.quality`: samples analysed; skipped samples and marks; gaps between bins."""
COUNT, HAS_SPIN, HAS_FORCE, NEXT = range(4)
"""Indices into `SampleBlock.counts`: samples, whether they contain spin and wall forces, and the next one analysed."""

STEP, BIT_OUTCOME, UNDECIDED, NEW, DECIDED = range(5)
"""Indices into `AnalyzerState.flow`: the step to go on with; outcome of `add_bit_speed` to be decided; 1 while a
crossing waits for the onset to be decided; 1 where there are estimates that the findings do not have; 1 where Python
has decided something in the present sample."""
SAMPLE, BIN, ONSET, ORBIT, STATE, STATISTICS, ADD, NOTE = range(8)
"""Steps."""
SKIPPED, TAKEN, BIN_FULL = range(3)
"""Outcome of `take_sample`."""
DONE, CHECK, DECIDE, CROSSED, DESCRIBE, CHANGED = range(6)
"""Outcome: all samples are analysed; or what Python must decide, below 0 the outcome of `add_bit_speed`; or the end of
a sample in which it has."""


class SampleBlock(NamedTuple):
    """Samples to be analysed, `BLOCK` at most."""

    stamp: Integers  # (BLOCK,) [ns]
    position: Array  # (BLOCK, m, 2) of the marked points [m]
    spin: Array  # (BLOCK, m) [rad]
    force: Array  # (BLOCK, m) wall force [N]
    speeds: Array  # (BLOCK, 2) of top drive and bit [rad/s]
    counts: Integers

    @classmethod
    def of(cls, m: int) -> SampleBlock:
        """Empty block for m marks."""
        spin, force = np.zeros((2, BLOCK, m))
        position, speeds = np.zeros((BLOCK, m, 2)), np.zeros((BLOCK, 2))
        return cls(np.zeros(BLOCK, np.int64), position, spin, force, speeds, np.zeros(4, np.int64))


class Found(NamedTuple):
    """Estimates after each sample of the block."""

    stamp: Integers  # (BLOCK,) of the last sample that was analysed [ns]
    values: Array  # (BLOCK, m, 4) radius of the orbit [m], precession [rev/s], ratio, confidence
    bit_index: Array  # (BLOCK,) stick-slip index of the bit

    @classmethod
    def of(cls, m: int) -> Found:
        """Empty, for m marks."""
        return cls(np.zeros(BLOCK, np.int64), np.zeros((BLOCK, m, 4)), np.zeros(BLOCK))


class Samples(NamedTuple):
    """The present sample."""

    quality: Integers
    origin: Array  # (1,) time of the first sample [s]
    radius: Array  # (m,) distance of the centre line from the hole's axis at the last sample [m]
    largest: Array  # (m,) largest so far [m]
    plausible: Array  # (m,) largest plausible distance of a marked point [m]
    seen: Mask  # (m,) marks seen in the sample
    distance: Array  # (m,) of the centre line from the hole's axis [m]
    point: ComplexArray  # (2, m) position [m], unit vector of the spin

    @classmethod
    def of(cls, plausible: Array) -> Samples:
        """Before the first sample of m marks."""
        m = plausible.size
        radius, largest = np.full((2, m), math.nan)
        return cls(
            np.zeros(4, np.int64), np.zeros(1), radius, largest, plausible, np.zeros(m, bool), np.zeros(m),
            np.zeros((2, m), complex),
        )  # fmt: skip


class AnalyzerState(NamedTuple):
    """State of the analysis of m marks."""

    criteria: Criteria
    marks: MarkArrays
    block: SampleBlock
    found: Found
    clock: Clock
    samples: Samples
    bins: SampleBins
    full: Bin
    carrier: Carrier
    separation: RunoutSeparation
    history: History
    orbit: Orbit
    averaged: AveragedRadius
    onsets: Onsets
    synchronous: SynchronousOnsets
    shape: StringShape
    motion: MotionClassifier
    statistics: RunStatistics
    bit: BitSpeed
    flow: Integers
    due: Array  # (2,) revolutions and time of the next estimate

    @classmethod
    def of(cls, marks: MarkArrays, wall_offset: Array, criteria: Criteria, bit: BitSpeed) -> AnalyzerState:
        """State before the first sample of m marks, whose string has radii `wall_offset` [m], shape (m,)."""
        m, clearance = marks.clearance.size, marks.clearance
        return cls(
            criteria, marks, SampleBlock.of(m), Found.of(m), Clock.of(m),
            Samples.of(LARGEST_RADIUS * clearance + wall_offset), SampleBins.of(m), Bin.of(m),
            Carrier.of(clearance), RunoutSeparation.of(marks.wall_radius, criteria), History.of(m), Orbit.of(clearance),
            AveragedRadius.of(clearance, criteria), Onsets.of(marks.inclined), SynchronousOnsets.of(m),
            StringShape.of(m, marks.levels), MotionClassifier.of(m), RunStatistics.of(m), bit,
            np.zeros(5, np.int64), np.full(2, -math.inf),
        )  # fmt: skip


@strict_kernel
def take_sample(
    block: SampleBlock, samples: Samples, clock: Clock, bins: SampleBins, separation: RunoutSeparation, bit: BitSpeed,
    flow: Integers,
) -> int:  # fmt: skip
    """Read the next sample and rotate; a sample that cannot be analysed is skipped and counted."""
    at, seen = block.counts[NEXT], samples.seen
    stamp, has_spin = block.stamp[at], block.counts[HAS_SPIN] != 0
    if not is_new(clock.stamps, stamp):
        return SKIPPED
    flow[BIT_OUTCOME] = add_bit_speed(bit, stamp * 1e-9, block.speeds[at, 1], block.speeds[at, 0])
    if separation.flags[SPIN_GIVEN] == NOT_KNOWN:
        start(separation, has_spin)
    spin, top_speed, any_seen = block.spin[at], block.speeds[at, 0], False
    for k in range(seen.size):
        samples.point[0, k] = complex(block.position[at, k, 0], block.position[at, k, 1])
    if has_spin:
        for k in range(seen.size):
            samples.point[1, k] = complex(math.cos(spin[k]), math.sin(spin[k]))
        _find_distance(samples, separation)
    else:
        for k in range(seen.size):
            samples.distance[k] = abs(samples.point[0, k])
    for k in range(seen.size):
        seen[k] = samples.distance[k] <= samples.plausible[k]
        any_seen = any_seen or seen[k]
    known = has_spin or math.isfinite(top_speed)
    if has_spin != (separation.flags[SPIN_GIVEN] != 0) or not known or not any_seen:
        samples.quality[INCOMPLETE] += 1
        return SKIPPED
    if samples.quality[ACCEPTED] == 0:
        samples.origin[0] = stamp * 1e-9
    rotate(clock, accept(clock.stamps, stamp), top_speed, spin, has_spin)
    return BIN_FULL if is_full(bins, _seconds(clock), clock.rotation[TOTAL_REVOLUTIONS]) else TAKEN


@strict_kernel
def _find_distance(samples: Samples, separation: RunoutSeparation) -> None:
    """Distance of the centre line from the hole's axis in the sample."""
    for k in range(samples.seen.size):
        samples.distance[k] = abs(samples.point[0, k] - separation.arm[k] * samples.point[1, k])


@strict_kernel
def _seconds(clock: Clock) -> float:
    """Time since the first sample [s]."""
    return float((clock.stamps[LAST] - clock.stamps[FIRST]) * 1e-9)


@strict_kernel
def add_sample(
    block: SampleBlock, samples: Samples, clock: Clock, bins: SampleBins, separation: RunoutSeparation, carrier: Carrier
) -> None:
    """Add the sample to the present bin."""
    seen, distance = samples.seen, samples.distance
    at, angle = block.counts[NEXT], clock.rotation[TOTAL_ANGLE]
    if not block.counts[HAS_SPIN]:
        samples.point[1, :] = complex(math.cos(angle), math.sin(angle))
        _find_distance(samples, separation)
    when = (_seconds(clock), angle, clock.rotation[TOTAL_REVOLUTIONS])
    add(bins, when, samples.point[0], samples.point[1], seen, block.force[at], block.counts[HAS_FORCE] != 0)
    follow(carrier, separation, when[0], samples.point[0], samples.point[1], seen)
    samples.quality[ACCEPTED] += 1
    for k in range(seen.size):
        if not seen[k]:
            samples.quality[MISSING] += 1
            distance[k] = math.nan
        if separation.flags[KNOWN]:
            samples.radius[k] = distance[k]
            if not distance[k] <= samples.largest[k] and seen[k]:
                samples.largest[k] = distance[k]


@strict_kernel
def note_findings(
    found: Found, block: SampleBlock, samples: Samples, orbit: Orbit, clock: Clock, bit: BitSpeed
) -> None:
    """Write down the estimates after the sample."""
    at = block.counts[NEXT]
    found.stamp[at] = clock.stamps[LAST]
    found.bit_index[at] = bit.window.numbers[INDEX]
    for k in range(samples.radius.size):
        row = found.values[at, k]
        row[0], row[1], row[2], row[3] = samples.radius[k], orbit.precession[k], orbit.ratio[k], orbit.confidence[k]
