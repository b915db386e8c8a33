# SPDX-License-Identifier: Apache-2.0
"""The string without stretch and torsion: two lateral unknowns per node and their slopes.

The axial force follows from balance at every instant and the spin from the top drive, so neither axial nor torsional
waves exist. The state keeps its seven columns; columns that are not unknowns are filled in at the end of a frame.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import BIT, RESIDUAL, ROTATION, TOP
from drill_twin.dynamics.solver.interface import Effects, Formulation, bind_unknowns
from drill_twin.dynamics.solver.lateral import assembly
from drill_twin.dynamics.solver.lateral.linear_solver import (
    ADDED,
    AT_BIT,
    AT_TOP,
    CHANGE,
    HALF_STEP,
    NODE,
    RENEW,
    RENEW_STEPS,
    STEPS_AFTER_CHANGE,
    TORQUE,
    WEIGHT,
    Workspace,
    check_contraction,
    factor_blocks,
    outdated,
    solve_blocks,
)
from drill_twin.dynamics.solver.state import BIT_IMPULSE, FACTOR, HOOK_IMPULSE, TORQUE_IMPULSE, State, StepControl
from drill_twin.physics.model import SPIN, Rod, along_element

X, Y, SLOPE_X, SLOPE_Y = 0, 1, 3, 4  # columns of the unknowns in a node's row


@kernel
def column(k: int) -> int:
    """Column of the k-th of the four unknowns in a node's row of seven."""
    return k if k < 2 else k + 1


extrapolate, clear_constrained, move_to_middle, take_step = bind_unknowns(NODE, column)


@kernel
def begin(scratch: Workspace) -> None:
    """Discard the factors, so that a run resumed between two frames equals a run that was not interrupted."""
    scratch.reuse[:] = 0.0


@kernel
def predict(scratch: Workspace, constrained: Array, state: State, half_step: float) -> None:
    """Extrapolate the mid-step velocity; constrained unknowns move as prescribed."""
    rotation = scratch.command[ROTATION]
    extrapolate(state, half_step)
    clear_constrained(constrained, state.trial)
    state.trial[0, SPIN] = rotation
    state.trial[state.u.shape[0] - 1, SPIN] = rotation


@kernel
def add_ends(constrained: Array, scratch: Workspace, full: bool) -> None:
    """Add the loads on bit and top to the system, then remove the constrained unknowns from it."""
    last = scratch.diagonal.shape[0] - 1
    for end in range(2):
        node = 0 if end == 0 else last
        own, right = scratch.diagonal[node], scratch.right[node]
        other = scratch.upper[0] if end == 0 else scratch.lower[last - 1]
        for i in range(NODE):
            right[i] += scratch.ends[end, column(i), RESIDUAL]
            if constrained[end, column(i)]:
                right[i] = 0.0
        if full:
            for i in range(NODE):
                for j in range(NODE):
                    own[i, j] += scratch.ends[end, column(i), column(j)]
                if constrained[end, column(i)]:
                    for j in range(NODE):
                        own[i, j] = 0.0
                        other[i, j] = 0.0
                    own[i, i] = 1.0


@kernel
def set_rows(scratch: Workspace, state: State) -> None:
    """Set rows and velocities as in space, with r'_z = 1 and the spin of the top, and clear the loads on the nodes."""
    rows, last = scratch.rows, state.u.shape[0] - 1
    scratch.nodes[:] = 0.0
    for i in range(last + 1):
        for k in range(NODE):
            c = column(k)
            rows[0, i, c], rows[1, i, c], rows[2, i, c] = state.place[i, c], state.trial[i, c], state.v[i, c]
        rows[0, i, 5], rows[0, i, SPIN] = 1.0, state.place[last, SPIN]
        rows[1, i, SPIN], rows[2, i, SPIN] = state.trial[last, SPIN], state.v[last, SPIN]


@kernel
def solve(scratch: Workspace) -> bool:
    """Solve the block system in place, with new factors where `build` has made a new tangent."""
    if scratch.reuse[HALF_STEP] < 0.0:
        if not factor_blocks(scratch.lower, scratch.diagonal, scratch.upper, scratch.inverse):
            scratch.reuse[HALF_STEP] = 0.0
            return False
        scratch.reuse[HALF_STEP] = -scratch.reuse[HALF_STEP]
        scratch.reuse[RENEW] = 0.0
    solve_blocks(scratch.lower, scratch.upper, scratch.inverse, scratch.right)
    return True


@kernel
def correct(scratch: Workspace, state: State, control: StepControl, half_step: float) -> float:
    """Apply the Newton step; returns its size in tolerances, NaN if it is not finite."""
    position, angle, total, torque = 0.0, 0.0, 0.0, 0.0
    for i in range(state.u.shape[0]):
        right, row = scratch.right[i], state.trial[i]
        for c in range(4):
            row[column(c)] -= right[c]
        position = max(position, abs(right[0]), abs(right[1]))
        angle = max(angle, abs(right[2]), abs(right[3]))
        lever = scratch.lever[i]
        torque -= lever[0] * right[0] + lever[1] * right[1] + lever[2] * right[2] + lever[3] * right[3]
        total += right[0] + right[1] + right[2] + right[3]
    size = max(position / control.position, angle / control.angle) * half_step + 0.0 * total
    scratch.axial[TORQUE] += torque
    check_contraction(scratch.reuse, size)
    return size


@kernel
def accept(scratch: Workspace, _constrained: Array, state: State, counters: Array, half_step: float) -> None:
    """Take the step; the string ends it at the speed that the drive prescribes."""
    last, seconds = state.u.shape[0] - 1, 2.0 * half_step
    take_step(state, half_step)
    angle = state.u[last, SPIN] + seconds * state.trial[last, SPIN]
    for end in (0, last):
        state.u[end, SPIN] = angle
        state.v[end, SPIN] = scratch.command[ROTATION]
    counters[TORQUE_IMPULSE] += (scratch.axial[TORQUE] + scratch.ends[BIT, SPIN, RESIDUAL]) * seconds
    counters[HOOK_IMPULSE] += scratch.axial[AT_TOP] * seconds
    counters[BIT_IMPULSE] -= scratch.axial[AT_BIT] * seconds


@kernel
def finish(rod: Rod, state: State) -> None:
    """Fill in the columns that are no unknowns: spin, and slope and position along the axis at constant length.

    dz/ds = sqrt(1 - x'^2 - y'^2), integrated from the top by Simpson's rule.
    """
    u, v, last = state.u, state.v, state.u.shape[0] - 1
    for i in range(last + 1):
        square = min(u[i, SLOPE_X] ** 2 + u[i, SLOPE_Y] ** 2, 0.99)
        u[i, 5] = np.sqrt(1.0 - square)
        v[i, 5] = -(u[i, SLOPE_X] * v[i, SLOPE_X] + u[i, SLOPE_Y] * v[i, SLOPE_Y]) / u[i, 5]
        u[i, SPIN], v[i, SPIN] = u[last, SPIN], v[last, SPIN]
    for e in range(last - 1, -1, -1):
        w, h = rod.middle[e], rod.length[e]
        (ax, ay, _), (dx, dy, _) = along_element(w, u, e), along_element(w, v, e)
        middle = np.sqrt(1.0 - min(ax * ax + ay * ay, 0.99))
        u[e, 2] = u[e + 1, 2] - h / 6.0 * (u[e, 5] + 4.0 * middle + u[e + 1, 5])
        v[e, 2] = v[e + 1, 2] - h / 6.0 * (v[e, 5] - 4.0 * (ax * dx + ay * dy) / middle + v[e + 1, 5])


def bind(effects: Effects) -> Formulation:
    """The formulation for a set of effects."""
    assemble, end_load, node_load = assembly.bind(effects), effects.end_load, effects.node_load

    @kernel
    def build(
        parameters: Any,
        rod: Rod,
        scratch: Workspace,
        constrained: Array,
        state: State,
        time: float,
        half_step: float,
        first_iteration: bool,
        number: float,
    ) -> None:
        """Fill the block system: elements, loads at the ends, constraints."""
        last = state.u.shape[0] - 1
        move_to_middle(state, half_step)
        for end in (0, last):
            state.place[end, SPIN] = state.u[last, SPIN] + half_step * state.trial[last, SPIN]
        scratch.ends[:] = 0.0
        end_load(parameters, rod, scratch.command, time, half_step, state.place, state.trial, state.v, scratch.ends)
        bit = scratch.ends[BIT]
        at_bit = abs(bit[X, X] - bit[Y, Y]) + abs(bit[X, Y] + bit[Y, X])  # contact resists in one direction
        # pushed up at the bit, or down at the top with the string's weight added on the way
        tension = scratch.ends[BIT, 2, RESIDUAL]
        if scratch.ends[TOP, 2, RESIDUAL] != 0.0 or constrained[0, 2]:
            tension = scratch.axial[WEIGHT] - scratch.ends[TOP, 2, RESIDUAL]
        if scratch.nodes.shape[0] > 0:
            set_rows(scratch, state)
            rows = scratch.rows
            node_load(parameters, rod, time, half_step, rows[0], rows[1], rows[2], scratch.nodes)
        full = outdated(scratch.reuse, half_step, first_iteration)
        for _ in range(2):
            added = at_bit + assemble(
                parameters, rod, scratch, time, half_step, first_iteration, number, state.place, state.trial, state.v,
                tension, full,
            )  # fmt: skip
            same = abs(added - scratch.reuse[ADDED]) <= CHANGE * abs(scratch.reuse[ADDED])
            if not same:
                state.clock[FACTOR] = np.inf  # the rate of convergence without contact does not apply to contact
            if full or same:
                break
            full = True  # contact has begun or ended
            scratch.reuse[RENEW_STEPS] = STEPS_AFTER_CHANGE
        if full:
            scratch.reuse[HALF_STEP], scratch.reuse[ADDED] = -half_step, added
        scratch.axial[AT_BIT], scratch.axial[AT_TOP] = tension, tension - scratch.axial[WEIGHT]
        for i in range(scratch.nodes.shape[0]):
            for k in range(NODE):
                scratch.right[i, k] += scratch.nodes[i, column(k), RESIDUAL]
                scratch.lever[i, k] += scratch.nodes[i, SPIN, column(k)]
                for c in range(NODE if full else 0):
                    scratch.diagonal[i, k, c] += scratch.nodes[i, column(k), column(c)]
        add_ends(constrained, scratch, full)

    return Formulation(begin, predict, build, solve, correct, accept, finish, order=1)
