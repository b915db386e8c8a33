# SPDX-License-Identifier: Apache-2.0
"""Frames of a twin in compiled code: save the state, advance, observe, check.

What a frame calls is bound once (`drill_twin.core.compile.native_call`): the kernel of the scene, the observation and
the check of a state. The loop itself knows no effects and no types of theirs, so it is compiled once for all scenes. It
judges a frame with `step_guard`'s bounds; where one may be exceeded it leaves the frame to Python, which decides.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.compile.kernel_cache import load_generated
from drill_twin.core.compile.native_call import Call, call
from drill_twin.dynamics.audit import state_check
from drill_twin.dynamics.solver.state import CONVERGED, COUNTERS, NEXT_STEP, PAUSED, TIME, TOO_MANY_HALVINGS, UNFINISHED
from drill_twin.dynamics.twin.observation import DEPTH, PLACE, Observation

GOOD, DIVERGED, HALVED_TOO_OFTEN, SUSPECT = range(4)
"""Outcome of a frame: good, Newton's method failed, the step was halved too often, or a bound may be exceeded.

PAUSED of `drill_twin.dynamics.solver.state` is a frame to be gone on with.
"""
SHARE, GOOD_FRAMES = 0, 1
"""Indices into the guard's memory: share of the nominal step, good frames since it was halved."""
PUSHED = COUNTERS + 10
"""Index into `Shown.numbers` of the impulses."""
CERTAIN = 1.0 - 1e-9
"""Share of the largest penetration below which the compiled check and the guard's cannot differ by round-off."""


class Limits(NamedTuple):
    """Numbers of `StepGuard`, its bounds (`drill_twin.dynamics.twin.state_bounds`) and the wall's law."""

    step: float  # nominal [s]
    halvings_per_frame: float
    halvings_per_step: float
    good_frames_before_growth: float
    speed: float
    tilt: float
    strain: float
    walled: bool
    depth_margin: float
    stiffness: float
    power: float
    line_mass: float
    flexibility: float
    weight: float
    line_load: float
    curvature: float


class Places(NamedTuple):
    """Places of arguments of the kernel among its words."""

    step: int
    max_halvings: int
    start: int
    end: int


class Frames(NamedTuple):
    """Calls and arrays of one twin."""

    advance: Call
    observe: Call
    check: Call
    places: Places
    limits: Limits
    memory: NDArray[np.int64]  # of the state, and its copy at the start of the frame
    saved: NDArray[np.int64]
    clock: Array
    progress: Array  # of the advance
    command: Array  # (2,) set-points last reached
    target: Array  # (2,) set-points at the end of the frame
    guard: Array  # (2,) see SHARE
    extremes: Array
    before: Array  # extremes at the start of the frame
    counters: Array
    counters_before: Array
    impulse: Array
    impulse_before: Array
    seen: Observation
    stress: Array  # (s, scalars) of the sections of `fatigue`


class Rows(NamedTuple):
    """Recorded frames, one a row."""

    time: Array  # (F,) [s]
    command: Array  # (F, 3) set-points reached, as `Command.values`
    position: Array  # (F, m, 3) of the marks [m]
    centre: Array  # (F, m, 3) [m]
    spin: Array  # (F, m) [rad]
    wall_force: Array  # (F, m) [N]
    ends: Array  # (F, 2, 3) of bit and top: spin [rad], its rate [rad/s], height [m]
    counted: Array  # (F, counters) of the frame
    pushed: Array  # (F, impulses) of the frame
    string: Array  # (F, 3) largest wall force of a node [N], largest penetration [m], share of nodes in contact


class States(NamedTuple):
    """The rest of recorded frames, for messages; F = 0 where it is not wanted."""

    u: Array  # (F, n + 1, 7) node rows (r, r', psi)
    v: Array  # (F, n + 1, 7) their velocities
    tangents: Array  # (F, n + 1, 3)
    wall_force: Array  # (F, n + 1) [N]
    velocity: Array  # (F, m, 3) of the marks [m/s]
    spin_rate: Array  # (F, m) [rad/s]
    deepest: Array  # (F, 2) see Observation
    stress: Array  # (F, s, scalars)


class Past(NamedTuple):
    """The last states, a ring of K."""

    time: Array  # (K,) [s]
    rows: Array  # (K, 2, n + 1, 7) node rows u and v
    next: NDArray[np.int64]  # (1,) number of states added


class Shown(NamedTuple):
    """Arrays that a `Frame` needs beside an `Observation`."""

    positions: Array  # (n + 1, 3)
    velocities: Array  # (n + 1, 3)
    spin: Array  # (n + 1,)
    spin_rate: Array  # (n + 1,)
    numbers: (
        Array  # counted, time, `deepest` (2), spin and rate of bit and top (4), height and speed of it, load, pushed
    )
    past: Past


@kernel
def attempt(frames: Frames, seconds: float, save: bool) -> int:
    """Advance by a frame to `frames.target`, or go on with one that was paused; returns its outcome.

    Args:
        frames: Calls and arrays of the twin.
        seconds: Length of the frame [s].
        save: Save the state before; not for a frame that is repeated.
    """
    limits, places, words = frames.limits, frames.places, frames.advance.words
    numbers = words.view(np.float64)
    if save and frames.progress[NEXT_STEP] == 0.0:
        frames.saved[:] = frames.memory
        frames.counters_before[:] = frames.counters
        frames.impulse_before[:] = frames.impulse
        call(frames.check)
        frames.before[:] = frames.extremes
        frames.progress[UNFINISHED] = 1.0
    step = min(limits.step, seconds) * frames.guard[SHARE]
    numbers[places.step] = step
    words[places.max_halvings] = int(
        limits.halvings_per_frame + limits.halvings_per_step * np.ceil(seconds / limits.step)
    )
    numbers[places.start] = frames.clock[TIME]
    numbers[places.end] = frames.clock[TIME] + seconds
    status = call(frames.advance)
    if status == PAUSED:
        return PAUSED
    if status != CONVERGED:
        return HALVED_TOO_OFTEN if status == TOO_MANY_HALVINGS else DIVERGED
    frames.seen.deepest[0], frames.seen.deepest[1] = -np.inf, 0.0
    call(frames.observe)
    call(frames.check)
    return GOOD if is_certain(frames, step) else SUSPECT


@kernel
def is_certain(frames: Frames, step: float) -> bool:
    """Check that a state is within all bounds."""
    limits, found, depth = frames.limits, frames.extremes, frames.seen.deepest[DEPTH]
    if not (
        found[state_check.BROKEN] < 0.0
        and found[state_check.SPEED] <= limits.speed
        and found[state_check.LEAN] <= limits.tilt
        and found[state_check.STRAIN] <= limits.strain
    ):
        return False
    if not limits.walled or depth <= 0.0:
        return True
    speed = max(frames.before[state_check.SPEED], found[state_check.SPEED])
    load = max(abs(frames.command[0]), abs(frames.target[0])) + limits.weight
    power = limits.power
    impact = (0.5 * (power + 1.0) * limits.line_mass * speed**2 / limits.stiffness) ** (1.0 / (power + 1.0))
    pressed = (load**2 * limits.flexibility + load * limits.curvature + limits.line_load) / limits.stiffness
    largest = limits.depth_margin * (impact + pressed ** (1.0 / power)) + speed * step
    return bool(depth <= CERTAIN * largest)


@kernel
def count_good_frame(frames: Frames) -> None:
    """Count a good frame, and double a halved step after some of them."""
    guard = frames.guard
    if guard[SHARE] < 1.0:
        guard[GOOD_FRAMES] += 1.0
        if guard[GOOD_FRAMES] >= frames.limits.good_frames_before_growth:
            guard[SHARE], guard[GOOD_FRAMES] = min(2.0 * guard[SHARE], 1.0), 0.0


@kernel
def show(frames: Frames, u: Array, v: Array, shown: Shown) -> None:
    """Show the frame that was observed last, and add its state to the last ones."""
    nodes, past, numbers = u.shape[0], shown.past, shown.numbers
    k = past.next[0] % past.time.size
    past.next[0] += 1
    past.time[k] = frames.clock[TIME]
    past.rows[k, 0], past.rows[k, 1] = u, v
    for i in range(nodes):
        for c in range(3):
            shown.positions[i, c], shown.velocities[i, c] = u[i, c], v[i, c]
        shown.spin[i], shown.spin_rate[i] = u[i, 6], v[i, 6]
    for k in range(COUNTERS):
        numbers[k] = frames.counters[k] - frames.counters_before[k]
    now = numbers[COUNTERS:PUSHED]
    now[0], now[1], now[2] = frames.clock[TIME], frames.seen.deepest[DEPTH], frames.seen.deepest[PLACE]
    now[3], now[4], now[5], now[6] = u[0, 6], v[0, 6], u[nodes - 1, 6], v[nodes - 1, 6]
    now[7], now[8], now[9] = u[nodes - 1, 2], v[nodes - 1, 2], frames.command[0]
    for k in range(frames.impulse.size):
        numbers[PUSHED + k] = frames.impulse[k] - frames.impulse_before[k]


@kernel
def advance_frame(frames: Frames, u: Array, v: Array, shown: Shown, seconds: float) -> int:
    """Advance by a frame to `frames.target`, and show it if it is good; returns its outcome.

    Args:
        frames: Calls and arrays of the twin.
        u: Node rows (r, r', psi), shape (n + 1, 7).
        v: Their velocities.
        shown: Takes the frame.
        seconds: Length of the frame [s].
    """
    outcome = attempt(frames, seconds, True)
    if outcome == GOOD:
        count_good_frame(frames)
        frames.command[:] = frames.target
        show(frames, u, v, shown)
        frames.progress[UNFINISHED] = 0.0
    return outcome


@kernel
def record(frames: Frames, u: Array, v: Array, rows: Rows, states: States, row: int) -> None:
    """Record the frame that was observed last."""
    seen = frames.seen
    rows.time[row] = frames.clock[TIME]
    rows.command[row] = frames.command
    for m in range(seen.spin.size):
        for c in range(3):
            rows.position[row, m, c] = seen.position[m, c]
            rows.centre[row, m, c] = seen.centre[m, c]
        rows.spin[row, m] = seen.spin[m]
        rows.wall_force[row, m] = seen.mark_force[m]
    for end in range(2):
        node = end * (u.shape[0] - 1)
        rows.ends[row, end, 0], rows.ends[row, end, 1], rows.ends[row, end, 2] = u[node, 6], v[node, 6], u[node, 2]
    for k in range(frames.counters.size):
        rows.counted[row, k] = frames.counters[k] - frames.counters_before[k]
    for k in range(frames.impulse.size):
        rows.pushed[row, k] = frames.impulse[k] - frames.impulse_before[k]
    largest, touching = 0.0, 0
    for force in seen.wall_force:
        largest = max(largest, force)
        touching += force > 0.0
    rows.string[row, 0], rows.string[row, 1] = largest, seen.deepest[DEPTH]
    rows.string[row, 2] = touching / seen.wall_force.size
    if len(states.u):
        states.u[row], states.v[row] = u, v
        states.tangents[row], states.wall_force[row] = seen.tangents, seen.wall_force
        states.velocity[row], states.spin_rate[row] = seen.velocity, seen.spin_rate
        states.deepest[row], states.stress[row] = seen.deepest, frames.stress


@kernel
def advance_frames(
    frames: Frames,
    u: Array,
    v: Array,
    commands: Array,
    seconds: float,
    row: int,
    rows: Rows,
    states: States,
    recorded: NDArray[np.int64],
) -> int:
    """Advance by frames while they are good, and record each.

    Args:
        frames: Calls and arrays of the twin.
        u: Node rows (r, r', psi), shape (n + 1, 7).
        v: Their velocities.
        commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
        seconds: Length of a frame [s].
        row: First frame.
        rows: The record, F rows.
        states: The rest of it.
        recorded: Set to the number of frames recorded, shape (1,).

    Returns:
        Outcome of the last frame.
    """
    recorded[0] = row
    for k in range(row, len(commands)):
        frames.target[:] = commands[k]
        outcome = attempt(frames, seconds, True)
        if outcome != GOOD:
            return outcome
        count_good_frame(frames)
        frames.command[:] = frames.target
        record(frames, u, v, rows, states, k)
        recorded[0] = k + 1
        frames.progress[UNFINISHED] = 0.0
    return GOOD


_MODULE = '''"""Frames of a twin. Generated by drill_twin; do not edit."""
from drill_twin.core.compile.jit import entry_kernel
from drill_twin.dynamics.twin import frame_kernel


@entry_kernel
def attempt(frames, seconds, save):
    return frame_kernel.attempt(frames, seconds, save)


@entry_kernel
def advance_frame(frames, u, v, shown, seconds):
    return frame_kernel.advance_frame(frames, u, v, shown, seconds)


@entry_kernel
def show(frames, u, v, shown):
    frame_kernel.show(frames, u, v, shown)


@entry_kernel
def record(frames, u, v, rows, states, row):
    frame_kernel.record(frames, u, v, rows, states, row)


@entry_kernel
def advance_frames(frames, u, v, commands, seconds, row, rows, states, recorded):
    return frame_kernel.advance_frames(frames, u, v, commands, seconds, row, rows, states, recorded)
'''


@cache
def compiled() -> Any:
    """The module with the functions of this one that Python calls."""
    return load_generated("frames", _MODULE)
