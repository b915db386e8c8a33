# SPDX-License-Identifier: Apache-2.0
"""Steps of the analysis of a sample in compiled code (`drill_twin.whirl.analysis_loop`)."""

from __future__ import annotations

import math

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.analyzer_state import (
    ACCEPTED,
    GAPS,
    HAS_FORCE,
    HAS_SPIN,
    INCOMPLETE,
    MISSING,
    NEXT,
    Found,
    SampleBlock,
    Samples,
)
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import APPENDED, LENGTH, History, append
from drill_twin.whirl.motion.classifier import MotionClassifier, classify
from drill_twin.whirl.motion.stick_slip import BitSpeed, add_bit_speed
from drill_twin.whirl.motion.stick_slip_index import INDEX
from drill_twin.whirl.onset.asynchronous_onset import (
    AveragedRadius,
    Onsets,
    average_radius,
    drop_candidates,
    ends,
    watch,
)
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsets, watch_synchronous
from drill_twin.whirl.orbit.carrier import Carrier, follow, judge, restore
from drill_twin.whirl.orbit.orbit import ROTATION, Orbit, StringShape, find_precession, find_shape, fit_orbit
from drill_twin.whirl.orbit.runout_separation import (
    KNOWN,
    NOT_KNOWN,
    SPIN_GIVEN,
    RunoutSeparation,
    hold,
    separate,
    start,
)
from drill_twin.whirl.run_statistics import ESTIMATED
from drill_twin.whirl.sample_bins import (
    BINS,
    FIRST,
    FORCES,
    LAST,
    REVOLUTIONS,
    TIME,
    TOTAL_ANGLE,
    TOTAL_REVOLUTIONS,
    Bin,
    Clock,
    SampleBins,
    accept,
    add,
    close,
    is_full,
    is_new,
    rotate,
)

INTERVAL_REV = 4.0 / BINS
"""Interval of the estimates of orbit and motion state [rev]; the onset is checked with every bin."""
INTERVAL_S = 0.5
"""Longest interval of these estimates [s]."""
FEWEST = 4
"""Fewest bins for the onset."""

STEP, BIT_OUTCOME, UNDECIDED, NEW, DECIDED = range(5)
"""Indices into `AnalyzerState.flow`: the step to go on with; outcome of `add_bit_speed` to be decided; 1 while a
crossing waits for the onset to be decided; 1 where there are estimates that the findings do not have; 1 where Python
has decided something in the present sample."""
SAMPLE, BIN, ONSET, ORBIT, STATE, STATISTICS, ADD, NOTE = range(8)
"""Steps."""
SKIPPED, TAKEN, BIN_FULL = range(3)
"""Outcome of `take_sample`."""
NOT_DUE, ESTIMATE, DECIDE_FIRST = range(3)
"""Outcome of `estimate_orbit`."""
DONE, CHECK, DECIDE, CROSSED, DESCRIBE, CHANGED = range(6)
"""Outcome: all samples are analysed; or what Python must decide, below 0 the outcome of `add_bit_speed`; or the end of
a sample in which it has."""


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
    crossed = watch_synchronous(synchronous, history, orbit, criteria)
    ended = ends(onsets, averaged, orbit, history, criteria)
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
