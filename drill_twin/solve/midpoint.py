# SPDX-License-Identifier: Apache-2.0
"""The implicit midpoint rule with Newton's method: the whole time loop in one compiled function.

``M (v - v_n) / (dt/2) + forces(u_n + dt/2 v, v) = 0`` for the mid-step velocity v, then ``u += dt v`` and
``v_n+1 = 2 v - v_n``. Second order, no step limit for linear problems, keeps linear and angular momentum to round-off
and an undamped rod's energy without drift (Hairer, Lubich and Wanner 2006, ch. IV and VI). Its state is place and
velocity alone, so a step may be cut or lengthened at will: where Newton fails the step is halved and counted, and it
grows back by itself.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.types import Array
from drill_twin.solve import assembly
from drill_twin.solve.blocks import NODE, solve_blocks
from drill_twin.solve.drive import ROTATION, set_points
from drill_twin.solve.work import Work

MOST_ITERATIONS = 12
SURE = 0.1  # a next change foreseen below this share of the tolerance need not be computed
FORGET = 1e6  # largest remembered factor (a change of 1 would become a million)
SMALLEST_SHARE = 1.0 / 4096.0  # of the nominal step, before the loop gives up
CONVERGED, FAILED = 0, 1
SPIN = 6  # place of psi in a node's row

# Places in State.clock: time [s], last step [s], 1 if `middle` holds one, next Newton change per square of a change.
TIME, LAST_STEP, HAS_MIDDLE, FACTOR = 0, 1, 2, 3

# Places in the array of counters; impulses of the reactions at the ends [N m s], [N s].
STEPS, ITERATIONS, CUTS, TORQUE_IMPULSE, HOOK_IMPULSE, BIT_IMPULSE = 0, 1, 2, 3, 4, 5
COUNTERS = 6


class State(NamedTuple):
    """The string's state and the loop's memory of the last step; rows are (r, r', psi) per node from the bit."""

    u: np.ndarray  # (n + 1, 7) [m, -, rad]
    v: np.ndarray  # (n + 1, 7) [m/s, 1/s, rad/s]
    middle: np.ndarray  # (n + 1, 7) last mid-step velocity
    trial: np.ndarray  # (n + 1, 7) mid-step velocity being sought
    place: np.ndarray  # (n + 1, 7) configuration at mid-step
    clock: np.ndarray  # (4,) see TIME and its neighbours


class Limits(NamedTuple):
    """What counts as converged, per kind of unknown, and the nominal step."""

    step: float  # [s]
    place: float  # change of a node's place within a Newton step [m]
    angle: float  # change of slope and spin [rad]


def make_state(elements: int) -> State:
    """A straight string at rest, to be filled in."""
    shape = (elements + 1, 7)
    return State(
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.array([0.0, 0.0, 0.0, np.inf]),
    )


@kernel
def hold(fixed: Array, work: Work) -> None:
    """Take the held unknowns out of the system (their velocity is set before the iteration); keep their rows."""
    last = work.diagonal.shape[0] - 1
    for end in range(2):
        node = 0 if end == 0 else last
        own = work.diagonal[node]
        other = work.upper[0] if end == 0 else work.lower[last - 1]
        for i in range(NODE):
            work.reaction[end, i] = own[i, NODE]
            for j in range(NODE):
                work.held[end, i, j] = own[i, j]
                work.held[end, i, NODE + j] = other[i, j]
            if fixed[end, i]:
                for j in range(NODE):
                    own[i, j] = 0.0
                    other[i, j] = 0.0
                own[i, i] = 1.0
                own[i, NODE] = 0.0


@kernel
def react(work: Work) -> None:
    """Bring the reactions at the ends up to the Newton step just taken."""
    last = work.diagonal.shape[0] - 1
    for end in range(2):
        own = work.diagonal[0 if end == 0 else last]
        other = work.diagonal[1 if end == 0 else last - 1]
        for i in range(NODE):
            for j in range(NODE):
                work.reaction[end, i] -= work.held[end, i, j] * own[j, NODE]
                work.reaction[end, i] -= work.held[end, i, NODE + j] * other[j, NODE]


@kernel
def predict(fixed: Array, state: State, command: Array, step: float) -> None:
    """First guess of the mid-step velocity: straight on through the last one; held unknowns as they will be."""
    growth = step / state.clock[LAST_STEP] if state.clock[HAS_MIDDLE] > 0.0 else 0.0
    last = state.u.shape[0] - 1
    for i in range(last + 1):
        for c in range(NODE):
            state.trial[i, c] = state.v[i, c] + growth * (state.v[i, c] - state.middle[i, c])
    for c in range(NODE):
        if fixed[0, c]:
            state.trial[0, c] = 0.0
        if fixed[1, c]:
            state.trial[last, c] = 0.0
    state.trial[last, SPIN] = command[ROTATION]


@kernel
def correct(state: State, limits: Limits, work: Work, h2: float) -> float:
    """Apply the Newton step; returns its size in tolerances, NaN if it is not finite."""
    place = 0.0
    angle = 0.0
    total = 0.0
    for i in range(state.u.shape[0]):
        for c in range(NODE):
            change = work.diagonal[i, c, NODE]
            state.trial[i, c] -= change
            total += change
            if c < 3:
                place = max(place, abs(change))
            else:
                angle = max(angle, abs(change))
    return max(place / limits.place, angle / limits.angle) * h2 + 0.0 * total


@kernel
def accept(state: State, work: Work, counters: Array, step: float) -> None:
    """Take the step: u_n+1 = u_n + dt v, v_n+1 = 2 v - v_n."""
    for i in range(state.u.shape[0]):
        for c in range(NODE):
            v = state.trial[i, c]
            state.u[i, c] += step * v
            state.v[i, c] = 2.0 * v - state.v[i, c]
            state.middle[i, c] = v
    counters[STEPS] += 1
    counters[TORQUE_IMPULSE] += work.reaction[1, SPIN] * step
    counters[HOOK_IMPULSE] += work.reaction[1, 2] * step
    counters[BIT_IMPULSE] += work.reaction[0, 2] * step
    state.clock[LAST_STEP] = step
    state.clock[HAS_MIDDLE] = 1.0


def bind(stretch_effects: Any, section_effects: Any, point_effects: Any, end_effects: Any) -> Callable[..., int]:
    """The time loop for a set of effects, each given as one compiled function (`drill_twin.solve.compose`)."""
    assemble = assembly.bind(stretch_effects, section_effects, point_effects)

    @kernel
    def newton(
        parameters: Any,
        rod: Rod,
        work: Work,
        fixed: Array,
        state: State,
        limits: Limits,
        command: Array,
        time: float,
        h2: float,
        count: float,
    ) -> int:
        """Find the mid-step velocity in ``state.trial``; returns the iterations used, negative if it failed."""
        before = 1.0
        for iteration in range(MOST_ITERATIONS):
            for i in range(state.u.shape[0]):
                for c in range(NODE):
                    state.place[i, c] = state.u[i, c] + h2 * state.trial[i, c]
            fresh, number = iteration == 0, count + iteration
            assemble(parameters, rod, work, time, h2, fresh, number, state.place, state.trial, state.v)
            end_effects(parameters, rod, command, time, h2, state.place, state.trial, work.diagonal)
            hold(fixed, work)
            if not solve_blocks(work.lower, work.diagonal, work.upper, work.spare):
                return -1 - iteration
            react(work)
            size = correct(state, limits, work, h2)
            if not np.isfinite(size):
                return -1 - iteration
            if iteration > 0:
                # Newton's method squares its error: remember by which factor, forgetting slowly
                state.clock[FACTOR] = max(size / (before * before), 0.5 * min(state.clock[FACTOR], FORGET))
            if size < 1.0 or size * size * state.clock[FACTOR] < SURE:
                return iteration + 1
            before = size
        return -MOST_ITERATIONS

    @kernel
    def advance(
        parameters: Any,
        rod: Rod,
        work: Work,
        fixed: Array,
        state: State,
        limits: Limits,
        command0: Array,
        command1: Array,
        start: float,
        end: float,
        counters: Array,
    ) -> int:
        """Move the string from time `start` to `end`; the set-points go linearly from `command0` to `command1`.

        Returns:
            0, or 1 if the step had to be cut below 1/4096 of the nominal one.
        """
        last = state.u.shape[0] - 1
        pieces = max(1, int(np.ceil((end - start) / limits.step - 1e-9)))
        nominal = (end - start) / pieces
        step = nominal
        time = start
        while time < end - 1e-9 * nominal:
            step = min(step, end - time)
            h2 = 0.5 * step
            set_points(command0, command1, (time + h2 - start) / (end - start), work.command)
            predict(fixed, state, work.command, step)
            used = newton(
                parameters, rod, work, fixed, state, limits, work.command, time + h2, h2, counters[ITERATIONS]
            )
            counters[ITERATIONS] += abs(used)
            if used < 0:
                counters[CUTS] += 1
                state.clock[HAS_MIDDLE] = 0.0
                step *= 0.5
                if step < SMALLEST_SHARE * nominal:
                    return FAILED
                continue
            accept(state, work, counters, step)
            time += step
            set_points(command0, command1, (time - start) / (end - start), work.command)
            state.v[last, SPIN] = work.command[ROTATION]
            step = min(nominal, 2.0 * step)
        state.clock[TIME] = end
        return CONVERGED

    return advance
