# SPDX-License-Identifier: Apache-2.0
"""State of the analysis of a stream, arrays of fixed size for compiled code, and the steps on each of its samples."""

import math

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import any_of, strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import new_history
from drill_twin.whirl.motion.classifier import new_motion
from drill_twin.whirl.motion.stick_slip import add_bit_speed
from drill_twin.whirl.onset.asynchronous_onset import new_onsets, new_radius
from drill_twin.whirl.onset.synchronous_onset import new_synchronous
from drill_twin.whirl.orbit.carrier import follow, new_carrier
from drill_twin.whirl.orbit.orbit import new_orbit, new_shape
from drill_twin.whirl.orbit.runout_separation import NOT_KNOWN, new_separation, start
from drill_twin.whirl.run_statistics import new_statistics
from drill_twin.whirl.sample_bins import (
    accept,
    add,
    is_full,
    is_new,
    new_bin,
    new_clock,
    new_sums,
    rotate,
    seconds_of,
)

LARGEST_RADIUS = 3.0
"""Largest plausible radius of a mark over its clearance; beyond is an error of measurement. Chosen, not measured."""
BLIND = 0.125
"""Rotation without any mark seen after which a sample tells so [rev], and is no longer skipped: twice a bin. Chosen."""
BLOCK = 256
"""Most samples in a block, which bound its memory; chosen, not measured."""

SKIPPED, TAKEN, BIN_FULL = range(3)
"""Outcome of `take_sample`."""


def new_block(m: int) -> Columns:
    """Samples of m marks to be analysed, `BLOCK` at most, and the estimates after each: an empty block."""
    return columns(
        "SampleBlock",
        BLOCK,
        stamp=0,  # [ns]
        position=np.zeros((BLOCK, m, 2)),  # of the marked points [m]
        spin=np.zeros((BLOCK, m)),  # [rad]
        force=np.zeros((BLOCK, m)),  # wall force [N]
        top_speed=0.0,  # of the top drive [rad/s]
        bit_speed=0.0,  # [rad/s]
        count=np.zeros(1, np.int64),  # samples in the block
        next=np.zeros(1, np.int64),  # number of the next sample to be analysed
        has_spin=np.zeros(1, bool),
        has_force=np.zeros(1, bool),
        found_stamp=0,  # of the last sample that was analysed [ns]
        found=np.zeros((BLOCK, m, 4)),  # radius of the orbit [m], precession [rev/s], ratio, confidence
        bit_index=0.0,  # stick-slip index of the bit
    )


def new_samples(plausible: Array) -> Columns:
    """The present sample of m marks, before the first; `plausible` is their largest plausible distance [m]."""
    m = plausible.size
    return columns(
        "Samples",
        m,
        accepted=np.zeros(1, np.int64),  # samples analysed
        incomplete=np.zeros(1, np.int64),  # samples skipped
        missing=np.zeros(1, np.int64),  # marks skipped in samples
        gaps=np.zeros(1, np.int64),  # between bins
        origin=np.zeros(1),  # time of the first sample [s]
        radius=math.nan,  # distance of the centre line from the hole's axis at the last sample [m]
        largest=math.nan,  # largest radius so far [m]
        plausible=plausible,  # largest plausible distance of a marked point [m]
        seen=False,  # marks seen in the sample
        touches=False,  # marks in contact with the wall in the sample
        distance=0.0,  # of the centre line from the hole's axis [m]
        position=0j,  # of the marked point [m]
        phasor=0j,  # unit vector of the spin
    )


def new_flow() -> Columns:
    """Step with which `analyse` goes on, and what waits for Python."""
    return columns(
        "Flow",
        1,
        step=0,  # SAMPLE
        bit_outcome=0,  # of `add_bit_speed`, to be decided
        undecided=False,  # a crossing waits for the onset to be decided
        new=False,  # there are estimates that the findings do not have
        decided=False,  # Python has decided something in the present sample
        due_revolutions=-math.inf,  # of the next estimate [rev]
        due_time=-math.inf,  # of the next estimate [s]
    )


def new_state(marks: Columns, bit: Columns) -> Columns:
    """State of the analysis of m marks, before the first sample."""
    m, clearance = marks.clearance.size, marks.clearance
    return columns(
        "AnalyzerState",
        m,
        marks=marks,
        block=new_block(m),
        clock=new_clock(m),
        samples=new_samples(LARGEST_RADIUS * clearance + marks.wall_offset),
        bins=new_sums(m),
        full=new_bin(m),
        carrier=new_carrier(clearance),
        separation=new_separation(marks.wall_radius),
        history=new_history(m),
        orbit=new_orbit(clearance),
        averaged=new_radius(clearance),
        onsets=new_onsets(marks.inclined),
        synchronous=new_synchronous(m),
        shape=new_shape(m, marks.levels),
        motion=new_motion(m),
        statistics=new_statistics(m),
        bit=bit,
        flow=new_flow(),
    )


@strict_kernel
def take_sample(
    block: Columns, samples: Columns, clock: Columns, bins: Columns, separation: Columns, bit: Columns, flow: Columns
) -> int:
    """Read the next sample and rotate; a sample that cannot be analysed is skipped and counted."""
    at, seen, has_spin = block.next[0], samples.seen, block.has_spin[0]
    stamp, spin, top_speed, any_seen = block.stamp[at], block.spin[at], block.top_speed[at], False
    if not is_new(clock, stamp):
        return SKIPPED
    flow.bit_outcome[0] = add_bit_speed(bit, stamp * 1e-9, block.bit_speed[at], top_speed)
    if separation.spin_given[0] == NOT_KNOWN:
        start(separation, has_spin)
    for k in range(seen.size):
        samples.position[k] = complex(block.position[at, k, 0], block.position[at, k, 1])
        if has_spin:
            samples.phasor[k] = complex(math.cos(spin[k]), math.sin(spin[k]))
        else:
            samples.distance[k] = abs(samples.position[k])
    if has_spin:
        _find_distance(samples, separation)
    for k in range(seen.size):
        seen[k] = samples.distance[k] <= samples.plausible[k]
        any_seen = any_seen or seen[k]
    known = has_spin or math.isfinite(top_speed)
    if not any_seen and samples.accepted[0] > 0 and math.isfinite(top_speed):
        any_seen = (stamp - clock.last[0]) * 1e-9 * abs(top_speed) > BLIND * math.tau  # no mark for long: to be told
    if has_spin != (separation.spin_given[0] != 0) or not known or not any_seen:
        samples.incomplete[0] += 1
        return SKIPPED
    if samples.accepted[0] == 0:
        samples.origin[0] = stamp * 1e-9
    rotate(clock, accept(clock, stamp), top_speed, spin, has_spin)
    return BIN_FULL if is_full(bins, seconds_of(clock), clock.revolutions[0]) else TAKEN


@strict_kernel
def _find_distance(samples: Columns, separation: Columns) -> None:
    """Distance of the centre line from the hole's axis in the sample."""
    for k in range(samples.seen.size):
        samples.distance[k] = abs(samples.position[k] - separation.arm[k] * samples.phasor[k])


@strict_kernel
def add_sample(
    block: Columns, samples: Columns, clock: Columns, bins: Columns, separation: Columns, carrier: Columns,
    marks: Columns,
) -> None:  # fmt: skip
    """Add the sample to the present bin."""
    seen, distance, at, angle = samples.seen, samples.distance, block.next[0], clock.angle[0]
    if not block.has_spin[0]:
        samples.phasor[:] = complex(math.cos(angle), math.sin(angle))
        _find_distance(samples, separation)
    for k in range(seen.size):
        near = distance[k] > criteria.CONTACT_RADIUS * marks.clearance[k]
        samples.touches[k] = seen[k] and (block.force[at, k] > 0.0 if block.has_force[0] else near)
    add(bins, clock, samples.position, samples.phasor, seen, samples.touches)
    follow(carrier, separation, seconds_of(clock), samples.position, samples.phasor, seen)
    any_seen = any_of(seen)
    counted = samples.accepted if any_seen else samples.incomplete
    counted[0] += 1
    for k in range(seen.size):
        if not seen[k]:
            samples.missing[0] += any_seen
            distance[k] = math.nan
        if separation.known[0]:
            samples.radius[k] = distance[k]
            if not distance[k] <= samples.largest[k] and seen[k]:
                samples.largest[k] = distance[k]


@strict_kernel
def note_findings(block: Columns, samples: Columns, orbit: Columns, clock: Columns, bit: Columns) -> None:
    """Write down the estimates after the sample."""
    at = block.next[0]
    block.found_stamp[at] = clock.last[0]
    block.bit_index[at] = bit.window.index[0]
    for k in range(samples.radius.size):
        row = block.found[at, k]
        row[0], row[1], row[2], row[3] = samples.radius[k], orbit.precession[k], orbit.ratio[k], orbit.confidence[k]
