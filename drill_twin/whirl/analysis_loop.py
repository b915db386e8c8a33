# SPDX-License-Identifier: Apache-2.0
"""Analysis of a block of samples in compiled code.

A sample goes into the present bin; a full bin goes through separation, history, onset, orbit and motion state. What is
rare and needs texts or fits (a crossing, the onset, a changed state) is decided in Python: `analyse` then returns, and
goes on where it stopped when it is called again.
"""

from functools import cache
from typing import Any

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.core.compile.kernel_cache import load_generated
from drill_twin.core.compile.packed_arguments import field
from drill_twin.whirl.analyzer_state import BIN_FULL, SKIPPED, add_sample, note_findings, take_sample
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import append
from drill_twin.whirl.motion.classifier import classify, find_two_lines
from drill_twin.whirl.onset.asynchronous_onset import average_radius, drop_candidates, ends, watch
from drill_twin.whirl.onset.synchronous_onset import watch_synchronous
from drill_twin.whirl.orbit.carrier import judge, restore
from drill_twin.whirl.orbit.orbit import find_precession, find_shape, fit_orbit
from drill_twin.whirl.orbit.runout_separation import hold, separate
from drill_twin.whirl.run_statistics import add_bin
from drill_twin.whirl.sample_bins import BINS, close

INTERVAL_REV = 4.0 / BINS
"""Interval of the estimates of orbit and motion state [rev]; the onset is checked with every bin. Chosen, to save
time."""
INTERVAL_S = 0.5
"""Longest interval of the estimates of orbit and motion state [s]; chosen, to save time."""
FEWEST = 4
"""Fewest bins for the onset: the noise is found from a third difference, which needs four."""
SAMPLE, BIN, ONSET, ORBIT, STATE, STATISTICS, ADD, NOTE = range(8)
"""Steps of a sample."""
DONE, CHECK, DECIDE, CROSSED, DESCRIBE, CHANGED = range(6)
"""Outcome: all samples are analysed; or what Python must decide, below 0 the outcome of `add_bit_speed`; or the end of
a sample in which Python has decided."""
NOT_DUE, ESTIMATE, DECIDE_FIRST = range(3)
"""Outcome of `estimate_orbit`."""


@strict_kernel
def close_bin(
    full: Columns, bins: Columns, carrier: Columns, separation: Columns, history: Columns, averaged: Columns,
    onsets: Columns, rate: Array, samples: Columns,
) -> bool:  # fmt: skip
    """Separate the parts of the motion in the full bin; return whether a mark may begin to whirl."""
    close(bins, full)
    restore(carrier, full)
    separate(separation, full, carrier.left, carrier.shift)
    samples.gaps[0] += append(history, full, separation.vector, full.contact, carrier.carried)
    if history.length[0] < FEWEST:
        drop_candidates(onsets)
        return False
    average_radius(averaged, history, rate[0], carrier.carried, onsets.active)
    return watch(onsets, averaged, history)


@strict_kernel
def estimate_orbit(
    orbit: Columns, history: Columns, separation: Columns, averaged: Columns, onsets: Columns, synchronous: Columns,
    full: Columns, flow: Columns, statistics: Columns, carrier: Columns, rolling_ratio: Array,
) -> int:  # fmt: skip
    """Estimate the orbit where that is due; return whether it was, and whether there is something to decide."""
    hold(separation, onsets.time, onsets.active)
    revolutions, time = full.revolutions[0], full.time[0]
    waits = revolutions < flow.due_revolutions[0] and time < flow.due_time[0]
    statistics.estimated[0] = not (history.appended[0] < 2 or waits)
    if not statistics.estimated[0]:
        return NOT_DUE
    flow.due_revolutions[0], flow.due_time[0] = revolutions + INTERVAL_REV - 0.25 / BINS, time + INTERVAL_S
    fit_orbit(orbit, history, averaged.level, separation.arm)
    judge(carrier, orbit.seen, orbit.rotation[0], rolling_ratio)
    crossed = watch_synchronous(synchronous, history, orbit)
    ended = ends(onsets, averaged, orbit, history, separation.arm, carrier.carried)
    return DECIDE_FIRST if crossed or ended else ESTIMATE


@strict_kernel
def estimate_state(
    orbit: Columns, shape: Columns, history: Columns, motion: Columns, onsets: Columns, synchronous: Columns,
    noise: Array, rolling_ratio: Array, full: Columns, carrier: Columns,
) -> bool:  # fmt: skip
    """Estimate precession, shape and motion states; return whether a state must be described."""
    find_precession(orbit, onsets.active, noise)
    for k in range(noise.size):
        orbit.confidence[k] *= carrier.definite[k]
    find_two_lines(motion, orbit, history, onsets, carrier.carried)
    find_shape(shape, history)
    return classify(motion, orbit, shape, onsets, synchronous, rolling_ratio, full)


@strict_kernel
def analyse(words: Integers, kind: Any) -> int:
    """Analyse the samples of the block, until they are done or there is something to decide.

    Args:
        words: The packed `new_state`, and its type (`drill_twin.core.compile.packed_arguments`).
        kind: Type of `words`.
    """
    block, samples, clock = field(words, kind, "block"), field(words, kind, "samples"), field(words, kind, "clock")
    bins, full, bit = field(words, kind, "bins"), field(words, kind, "full"), field(words, kind, "bit")
    separation, carrier = field(words, kind, "separation"), field(words, kind, "carrier")
    history, averaged = field(words, kind, "history"), field(words, kind, "averaged")
    orbit, shape, motion = field(words, kind, "orbit"), field(words, kind, "shape"), field(words, kind, "motion")
    onsets, synchronous = field(words, kind, "onsets"), field(words, kind, "synchronous")
    marks, statistics, flow = field(words, kind, "marks"), field(words, kind, "statistics"), field(words, kind, "flow")
    rolling_ratio = marks.rolling_ratio
    while True:
        step = flow.step[0]
        if step == SAMPLE:
            if flow.bit_outcome[0]:
                outcome, flow.bit_outcome[0] = -flow.bit_outcome[0], 0
                return int(outcome)
            if flow.decided[0]:
                flow.decided[0] = False
                return CHANGED
            if block.next[0] >= block.count[0]:
                return DONE
            taken = take_sample(block, samples, clock, bins, separation, bit, flow)
            flow.step[0] = NOTE if taken == SKIPPED else BIN if taken == BIN_FULL else ADD
        elif step == BIN:
            flow.step[0] = ONSET
            if close_bin(full, bins, carrier, separation, history, averaged, onsets, orbit.rate, samples):
                return CHECK
        elif step == ONSET:
            flow.step[0] = ORBIT
            if flow.undecided[0]:
                return DECIDE
        elif step == ORBIT:
            estimate = estimate_orbit(
                orbit, history, separation, averaged, onsets, synchronous, full, flow, statistics, carrier,
                rolling_ratio,
            )  # fmt: skip
            flow.step[0] = STATISTICS if estimate == NOT_DUE else STATE
            if estimate == DECIDE_FIRST:
                return CROSSED
        elif step == STATE:
            flow.step[0] = STATISTICS
            flow.new[0] = True
            if estimate_state(
                orbit, shape, history, motion, onsets, synchronous, averaged.level, rolling_ratio, full,
                carrier,
            ):  # fmt: skip
                return DESCRIBE
        elif step == STATISTICS:
            add_bin(statistics, orbit, onsets.active, full, history, motion)
            flow.step[0] = ADD
        elif step == ADD:
            add_sample(block, samples, clock, bins, separation, carrier, marks)
            flow.step[0] = NOTE
        else:
            note_findings(block, samples, orbit, clock, bit)
            block.next[0] += 1
            flow.step[0] = SAMPLE


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
