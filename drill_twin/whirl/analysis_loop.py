# SPDX-License-Identifier: Apache-2.0
"""Analysis of a block of samples in compiled code.

A sample goes into the present bin; a full bin goes through separation, history, onset, orbit and motion state. What is
rare and needs texts or fits (a crossing, the onset, a changed state) is decided in Python: `analyse` then returns, and
goes on where it stopped when it is called again.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.core.compile.kernel_cache import load_generated
from drill_twin.core.compile.packed_arguments import field
from drill_twin.whirl.analyzer_state import (
    ADD,
    BIN,
    BIN_FULL,
    BIT_OUTCOME,
    CHANGED,
    CHECK,
    COUNT,
    CROSSED,
    DECIDE,
    DECIDED,
    DESCRIBE,
    DONE,
    GAPS,
    NEW,
    NEXT,
    NOTE,
    ONSET,
    ORBIT,
    SAMPLE,
    SKIPPED,
    STATE,
    STATISTICS,
    STEP,
    UNDECIDED,
    add_sample,
    note_findings,
    take_sample,
)
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import APPENDED, LENGTH, History, append
from drill_twin.whirl.motion.classifier import MotionClassifier, classify
from drill_twin.whirl.onset.asynchronous_onset import (
    AveragedRadius,
    Onsets,
    average_radius,
    drop_candidates,
    ends,
    watch,
)
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsets, watch_synchronous
from drill_twin.whirl.orbit.carrier import Carrier, judge, restore
from drill_twin.whirl.orbit.orbit import ROTATION, Orbit, StringShape, find_precession, find_shape, fit_orbit
from drill_twin.whirl.orbit.runout_separation import RunoutSeparation, hold, separate
from drill_twin.whirl.run_statistics import ESTIMATED, add_bin
from drill_twin.whirl.sample_bins import BINS, FORCES, REVOLUTIONS, TIME, Bin, SampleBins, close

INTERVAL_REV = 4.0 / BINS
"""Interval of the estimates of orbit and motion state [rev]; the onset is checked with every bin."""
INTERVAL_S = 0.5
"""Longest interval of these estimates [s]."""
FEWEST = 4
"""Fewest bins for the onset."""
NOT_DUE, ESTIMATE, DECIDE_FIRST = range(3)
"""Outcome of `estimate_orbit`."""


@strict_kernel
def close_bin(
    full: Bin, bins: SampleBins, carrier: Carrier, separation: RunoutSeparation, history: History,
    averaged: AveragedRadius, onsets: Onsets, criteria: Criteria, clearance: Array, rate: Array, quality: Integers,
) -> int:  # fmt: skip
    """Separate the parts of the motion in the full bin; return whether a mark may begin to whirl."""
    contact = full.contact
    close(bins, full)
    restore(carrier, full, criteria)
    separate(separation, full, carrier.left, carrier.shift)
    if not full.counts[FORCES]:
        for k in range(contact.size):
            near = separation.distance[k] > criteria.contact_radius * clearance[k]
            contact[k] = 1.0 if near else 0.0
    quality[GAPS] += append(history, full, separation.vector, contact, carrier.carried)
    if history.counts[LENGTH] < FEWEST:
        drop_candidates(onsets)
        return 0
    average_radius(averaged, history, criteria, rate[0], carrier.carried, onsets.active)
    return 1 if watch(onsets, averaged, history, criteria) else 0


@strict_kernel
def estimate_orbit(
    orbit: Orbit, history: History, separation: RunoutSeparation, averaged: AveragedRadius, onsets: Onsets,
    synchronous: SynchronousOnsets, criteria: Criteria, numbers: Array, due: Array, flags: Integers,
    carrier: Carrier, rolling_ratio: Array,
) -> int:  # fmt: skip
    """Estimate the orbit where that is due; return whether it was, and whether there is something to decide."""
    hold(separation, criteria, onsets.time, onsets.active)
    revolutions, time = numbers[REVOLUTIONS], numbers[TIME]
    flags[ESTIMATED] = 0
    if history.counts[APPENDED] < 2 or (revolutions < due[0] and time < due[1]):
        return NOT_DUE
    flags[ESTIMATED] = 1
    due[0], due[1] = revolutions + INTERVAL_REV - 0.25 / BINS, time + INTERVAL_S
    fit_orbit(orbit, history, criteria, averaged.noise.level)
    judge(carrier, orbit.seen, orbit.numbers[ROTATION], rolling_ratio, criteria)
    crossed = watch_synchronous(synchronous, history, orbit, criteria, onsets.swing)
    ended = ends(onsets, averaged, orbit, history, criteria, separation.arm)
    return DECIDE_FIRST if crossed or ended else ESTIMATE


@strict_kernel
def estimate_state(
    orbit: Orbit, shape: StringShape, history: History, motion: MotionClassifier, onsets: Onsets,
    synchronous: SynchronousOnsets, criteria: Criteria, noise: Array, rolling_ratio: Array, numbers: Array,
    definite: Array,
) -> int:  # fmt: skip
    """Estimate precession, shape and motion states; return whether a state must be described."""
    find_precession(orbit, criteria, onsets.active, noise)
    for k in range(definite.size):
        orbit.confidence[k] *= definite[k]
    find_shape(shape, history, criteria)
    return 1 if classify(motion, orbit, shape, onsets, synchronous, criteria, rolling_ratio, numbers) else 0


@strict_kernel
def analyse(words: Integers, kind: Any) -> int:
    """Analyse the samples of the block, until they are done or there is something to decide.

    Args:
        words: The packed `AnalyzerState`, and its type (`drill_twin.core.compile.packed_arguments`).
        kind: The latter.
    """
    block, samples, clock = field(words, kind, "block"), field(words, kind, "samples"), field(words, kind, "clock")
    bins, full, bit = field(words, kind, "bins"), field(words, kind, "full"), field(words, kind, "bit")
    separation, carrier = field(words, kind, "separation"), field(words, kind, "carrier")
    history, averaged = field(words, kind, "history"), field(words, kind, "averaged")
    orbit, shape, motion = field(words, kind, "orbit"), field(words, kind, "shape"), field(words, kind, "motion")
    onsets, synchronous = field(words, kind, "onsets"), field(words, kind, "synchronous")
    criteria, marks, found = field(words, kind, "criteria"), field(words, kind, "marks"), field(words, kind, "found")
    statistics = field(words, kind, "statistics")
    flow, due = field(words, kind, "flow"), field(words, kind, "due")
    counts, rolling_ratio = block.counts, marks.rolling_ratio
    while True:
        step = flow[STEP]
        if step == SAMPLE:
            if flow[BIT_OUTCOME]:
                outcome = -flow[BIT_OUTCOME]
                flow[BIT_OUTCOME] = 0
                return outcome  # type: ignore[no-any-return]
            if flow[DECIDED]:
                flow[DECIDED] = 0
                return CHANGED
            if counts[NEXT] >= counts[COUNT]:
                return DONE
            taken = take_sample(block, samples, clock, bins, separation, bit, flow)
            flow[STEP] = NOTE if taken == SKIPPED else BIN if taken == BIN_FULL else ADD
        elif step == BIN:
            flow[STEP] = ONSET
            if close_bin(
                full, bins, carrier, separation, history, averaged, onsets, criteria, marks.clearance, orbit.rate,
                samples.quality,
            ):  # fmt: skip
                return CHECK
        elif step == ONSET:
            flow[STEP] = ORBIT
            if flow[UNDECIDED]:
                return DECIDE
        elif step == ORBIT:
            estimate = estimate_orbit(
                orbit, history, separation, averaged, onsets, synchronous, criteria, full.numbers, due,
                statistics.flags, carrier, rolling_ratio,
            )  # fmt: skip
            flow[STEP] = STATISTICS if estimate == NOT_DUE else STATE
            if estimate == DECIDE_FIRST:
                return CROSSED
        elif step == STATE:
            flow[STEP] = STATISTICS
            flow[NEW] = 1
            if estimate_state(
                orbit, shape, history, motion, onsets, synchronous, criteria, averaged.noise.level, rolling_ratio,
                full.numbers, carrier.definite,
            ):  # fmt: skip
                return DESCRIBE
        elif step == STATISTICS:
            add_bin(statistics, orbit, onsets.active, full, history.counts[LENGTH], criteria.rest_rotation)
            flow[STEP] = ADD
        elif step == ADD:
            add_sample(block, samples, clock, bins, separation, carrier)
            flow[STEP] = NOTE
        else:
            note_findings(found, block, samples, orbit, clock, bit)
            counts[NEXT] += 1
            flow[STEP] = SAMPLE


_MODULE = '''"""Analysis of samples. Generated by drill_twin; do not edit."""
from drill_twin.core.compile.jit import strict_entry_kernel
from drill_twin.whirl import analysis_loop


@strict_entry_kernel
def analyse(words, kind):
    return analysis_loop.analyse(words, kind)
'''


@cache
def compiled() -> Any:
    """The module with `analyse`."""
    return load_generated("analysis", _MODULE)
