# SPDX-License-Identifier: Apache-2.0
"""Frames of a twin in compiled code: save the state, advance, observe, judge, record.

The loop over frames is written once and bound to the time loop of a scene, in the module generated for its effects
(`drill_twin.dynamics.solver.kernel_codegen`). One frame is a block of one. A frame that is not plausible is left to
Python, which puts the verdict into words, takes the frame back, and has it repeated with half the step.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Integers, Mask
from drill_twin.core.compile.jit import copy, kernel
from drill_twin.core.compile.packed_arguments import field
from drill_twin.dynamics.solver.state import (
    CONVERGED,
    COUNTERS,
    NEXT_STEP,
    PAUSED,
    TIME,
    TOO_MANY_HALVINGS,
    UNFINISHED,
    State,
    StepControl,
)
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.observation import DEPTH, PLACE, MarkPlaces, Observation
from drill_twin.dynamics.twin.state_judge import Bounds, find_extremes, judge
from drill_twin.physics.model import SPIN, Rod, Wellbore
from drill_twin.physics.model.bit import BIT_TORQUE, DRILLED

GOOD, DIVERGED, HALVED_TOO_OFTEN, IMPLAUSIBLE = range(4)
"""Outcome of a frame: good, Newton's method failed, the step was halved too often, or a bound is exceeded.

PAUSED of `drill_twin.dynamics.solver.state` is the outcome of a frame whose slice ended before the frame did.
"""
FRACTION, GOOD_FRAMES = 0, 1
"""Indices into the guard's memory: fraction of the nominal step, good frames since it was halved."""
ROW, REPEATED = 0, 1
"""Indices into the course of a block: the next frame, and 1 if that is repeated from the state that was saved."""
HALVINGS_PER_STEP, HALVINGS_PER_FRAME = 200, 2000
"""Limit of step halvings in a frame: per nominal step, plus per frame. Beyond it the frame is rejected as too slow."""
GOOD_FRAMES_BEFORE_GROWTH = 10
"""Good frames after which a halved step is doubled."""
AS_SET, MINUS_SET = -1, -2
"""In place of an index into `Reactions`: the weight on bit that is set, and minus that."""


class Reactions(NamedTuple):
    """Sources of the forces of the rig: indices into the counters, or beyond them into the impulses of the bit."""

    torque: int  # of the top drive
    weight: int  # on bit
    hook: int


class Past(NamedTuple):
    """The last states, a ring of K."""

    time: Array  # (K,) [s]
    rows: Array  # (K, 2, n + 1, 7) node rows u and v
    next: NDArray[np.int64]  # (1,) number of states added


class Effort(NamedTuple):
    """Counts of the time loop, now and at the start of the frame."""

    counters: Array
    counters_before: Array
    impulse: Array  # of the bit
    impulse_before: Array


class BoundTwin(NamedTuple):
    """Arguments of the time loop, and what saves, observes, judges and records the frames of one twin."""

    parameters: Any
    rod: Rod
    hole: Wellbore
    wall: Any
    scratch: Any
    constrained: Mask
    state: State
    control: StepControl
    command: Array  # (3,) set-points last reached
    progress: Array  # of the advance
    effort: Effort
    memory: NDArray[np.int64]  # of the state, and its copy at the start of the frame
    saved: NDArray[np.int64]
    bounds: Bounds
    now: Array  # extremes of the state, and the extremes at the start of the frame
    before: Array
    verdict: Array
    guard: Array  # (2,) see FRACTION
    course: NDArray[np.int64]  # (2,) see ROW
    marks: MarkPlaces
    seen: Observation
    reactions: Reactions
    stress: Array  # (s, scalars) of the sections of `fatigue`
    past: Past


@kernel
def count_good_frame(guard: Array) -> None:
    """Count a good frame, and double a halved step after `GOOD_FRAMES_BEFORE_GROWTH` of them."""
    if guard[FRACTION] < 1.0:
        guard[GOOD_FRAMES] += 1.0
        if guard[GOOD_FRAMES] >= GOOD_FRAMES_BEFORE_GROWTH:
            guard[FRACTION], guard[GOOD_FRAMES] = min(2.0 * guard[FRACTION], 1.0), 0.0


@kernel
def put(row: Array, at: int, values: Array) -> int:
    """Put the numbers of an array into a row of the record from a column on; returns the column behind it."""
    for i in range(values.size):
        row[at + i] = values.flat[i]
    return at + int(values.size)


@kernel
def max_halvings(seconds: float, step: float) -> int:
    """Limit of step halvings in a frame of a length [s], with a nominal step [s]."""
    return int(HALVINGS_PER_FRAME + HALVINGS_PER_STEP * np.ceil(seconds / step))


@kernel
def mean_reaction(effort: Effort, source: int, load: float, seconds: float) -> float:
    """Mean of a force or torque over the frame, as unresolved waves oscillate from step to step."""
    if source < 0:
        return load if source == AS_SET else -load
    if source < COUNTERS:
        return (effort.counters[source] - effort.counters_before[source]) / seconds  # type: ignore[no-any-return]
    k = source - COUNTERS
    return (effort.impulse[k] - effort.impulse_before[k]) / seconds  # type: ignore[no-any-return]


@kernel
def record_rig(
    effort: Effort, reactions: Reactions, load: float, u: Array, v: Array, seconds: float, row: Array, at: int
) -> int:
    """Record the state of the rig."""
    top = u.shape[0] - 1
    rig = RigState(
        top_drive_angle=u[top, SPIN], top_drive_speed=v[top, SPIN],
        top_drive_torque=mean_reaction(effort, reactions.torque, load, seconds),
        bit_angle=u[0, SPIN], bit_speed=v[0, SPIN],
        bit_torque=mean_reaction(effort, COUNTERS + BIT_TORQUE, load, seconds),
        bit_force=mean_reaction(effort, reactions.weight, load, seconds),
        block_position=u[top, 2], block_velocity=v[top, 2],
        hookload=mean_reaction(effort, reactions.hook, load, seconds),
        drilled=effort.impulse[DRILLED],
        rate_of_penetration=mean_reaction(effort, COUNTERS + DRILLED, load, seconds),
    )  # fmt: skip
    for i in range(len(rig)):
        row[at + i] = rig[i]
    return at + len(rig)


@kernel
def record_marks(seen: Observation, row: Array, at: int) -> int:
    """Record marks and wall forces."""
    at = put(row, at, seen.position)
    at = put(row, at, seen.centre)
    at = put(row, at, seen.spin)
    at = put(row, at, seen.mark_force)
    largest, touching = 0.0, 0
    for i in range(seen.wall_force.size):
        largest = max(largest, seen.wall_force[i])
        touching += seen.wall_force[i] > 0.0
    row[at], row[at + 1], row[at + 2] = largest, seen.deepest[DEPTH], touching / seen.wall_force.size
    return at + 3


@kernel
def record_nodes(seen: Observation, u: Array, v: Array, stress: Array, row: Array, at: int) -> None:
    """Record the state of all nodes, in the order of `drill_twin.dynamics.twin.frame_record.NodeSeries`."""
    at = put(row, at, u)
    at = put(row, at, v)
    at = put(row, at, seen.tangents)
    at = put(row, at, seen.wall_force)
    at = put(row, at, seen.velocity)
    at = put(row, at, seen.spin_rate)
    row[at], row[at + 1] = seen.deepest[DEPTH], seen.gauss_arc[int(seen.deepest[PLACE])]
    put(row, at + 2, stress)


@kernel
def keep_state(past: Past, time: float, u: Array, v: Array) -> None:
    """Add a state to the ring of the last states."""
    k = past.next[0] % past.time.size
    past.next[0] += 1
    past.time[k] = time
    for i in range(u.shape[0]):
        for c in range(7):
            past.rows[k, 0, i, c], past.rows[k, 1, i, c] = u[i, c], v[i, c]


def bind(advance: Any, observe: Any) -> Callable[..., int]:
    """Bind the loop over frames to the time loop of a set of effects and to the observation.

    Args:
        advance: As `drill_twin.dynamics.solver.midpoint.bind` makes it.
        observe: As `drill_twin.dynamics.twin.observation.bind` makes it.
    """

    @kernel
    def run(words: Integers, kind: Any, commands: Array, seconds: float, nominal: float, table: Array) -> int:
        """Advance by frames from the row `course[ROW]` on while they are good, and record each.

        Args:
            words: The packed `BoundTwin` (`drill_twin.core.compile.packed_arguments`).
            kind: Type of the `BoundTwin`.
            commands: Set-points at the end of each frame, as a `Command`, shape (F, 3).
            seconds: Length of a frame [s].
            nominal: Nominal time step [s].
            table: The record, F rows; without rows one advance, neither judged nor recorded.

        Returns:
            Outcome of the last frame.
        """
        rod, state, effort, reactions = (
            field(words, kind, "rod"), field(words, kind, "state"), field(words, kind, "effort"),
            field(words, kind, "reactions"),
        )  # fmt: skip
        command, progress = field(words, kind, "command"), field(words, kind, "progress")
        guard, course, control = (
            field(words, kind, "guard"),
            field(words, kind, "course"),
            field(words, kind, "control"),
        )
        now, before, seen = field(words, kind, "now"), field(words, kind, "before"), field(words, kind, "seen")
        u, v, clock = state.u, state.v, state.clock
        judged = table.shape[0] > 0
        halvings = max_halvings(seconds, nominal)
        while course[ROW] < commands.shape[0]:
            step = nominal
            if judged:
                if progress[NEXT_STEP] == 0.0 and course[REPEATED] == 0:
                    copy(field(words, kind, "memory"), field(words, kind, "saved"))
                    copy(effort.counters, effort.counters_before)
                    copy(effort.impulse, effort.impulse_before)
                    find_extremes(rod.outer_radius, u, v, before)
                    progress[UNFINISHED] = 1.0
                step = min(nominal, seconds) * guard[FRACTION]
            target = commands[course[ROW]]
            status = advance(
                field(words, kind, "parameters"), rod, field(words, kind, "scratch"), field(words, kind, "constrained"),
                state, StepControl(step, control.position, control.angle, halvings), command, target,
                clock[TIME], clock[TIME] + seconds, effort.counters, progress,
            )  # fmt: skip
            if status == PAUSED or not judged:
                return status  # type: ignore[no-any-return]
            if status != CONVERGED:
                return HALVED_TOO_OFTEN if status == TOO_MANY_HALVINGS else DIVERGED
            hole, wall, marks = field(words, kind, "hole"), field(words, kind, "wall"), field(words, kind, "marks")
            observe(rod.length, rod.shape, hole, wall, u, v, marks, seen)
            find_extremes(rod.outer_radius, u, v, now)
            load = max(abs(command[0]), abs(target[0]))
            if judge(
                field(words, kind, "bounds"), now, before, seen.deepest, load, step, field(words, kind, "verdict")
            ):
                return IMPLAUSIBLE
            if course[REPEATED] == 0:
                count_good_frame(guard)
            copy(target, command)
            row = table[course[ROW]]
            row[0] = clock[TIME]
            at = put(row, 1, command)
            at = record_rig(effort, reactions, command[0], u, v, seconds, row, at)
            for k in range(COUNTERS):
                row[at + k] = effort.counters[k] - effort.counters_before[k]
            at = record_marks(seen, row, at + COUNTERS)
            if at < row.size:
                record_nodes(seen, u, v, field(words, kind, "stress"), row, at)
                keep_state(field(words, kind, "past"), clock[TIME], u, v)
            course[ROW] += 1
            course[REPEATED] = 0
            progress[UNFINISHED] = 0.0
        return GOOD

    return run
