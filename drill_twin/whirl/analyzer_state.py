# SPDX-License-Identifier: Apache-2.0
"""State of the analysis of a stream: arrays of fixed size, for compiled code."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import History
from drill_twin.whirl.marks import MarkArrays
from drill_twin.whirl.motion.classifier import MotionClassifier
from drill_twin.whirl.motion.stick_slip import BitSpeed
from drill_twin.whirl.onset.asynchronous_onset import AveragedRadius, Onsets
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsets
from drill_twin.whirl.orbit.carrier import Carrier
from drill_twin.whirl.orbit.orbit import Orbit, StringShape
from drill_twin.whirl.orbit.runout_separation import RunoutSeparation
from drill_twin.whirl.run_statistics import RunStatistics
from drill_twin.whirl.sample_bins import Bin, Clock, SampleBins

LARGEST_RADIUS = 3.0
"""Largest plausible radius of a mark over its clearance; beyond is an error of measurement."""
BLOCK = 256
"""Most samples in a block."""

ACCEPTED, INCOMPLETE, MISSING, GAPS = range(4)
"""Indices into `Samples.quality`: samples analysed; skipped samples and marks; gaps between bins."""
COUNT, HAS_SPIN, HAS_FORCE, NEXT = range(4)
"""Indices into `SampleBlock.counts`: samples, whether they contain spin and wall forces, and the next one analysed."""


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
    flow: Integers  # see `analyzer_kernel`
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
