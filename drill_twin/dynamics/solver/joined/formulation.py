# SPDX-License-Identifier: Apache-2.0
"""The string in space up to a joint, and above it along the hole.

Below the joint a node has seven unknowns, as in `drill_twin.dynamics.solver.spatial`; above it three: its place z along
the hole, the derivative z' by arc length, and its spin psi. Rows of the state hold r, r' and psi for all nodes. Above
the joint, rows of the velocities being sought (`trial`, `middle`, `earlier`) and of `place` hold z in the column of
r_z, and z' in the column of r'_z. At the joint z is the coordinate along the hole of its r, and z' the part of its r'
along the hole: the string below is pulled and turned there, and is free to move and tilt across the hole.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import ROTATION, TOP
from drill_twin.dynamics.solver.interface import Effects, Formulation
from drill_twin.dynamics.solver.joined import elements
from drill_twin.dynamics.solver.joined.elements import along
from drill_twin.dynamics.solver.joined.linear_solver import (
    ALONG,
    KEPT,
    Workspace,
    add_to_joint,
    eliminate_above,
    keep_above,
    solve_above,
)
from drill_twin.dynamics.solver.spatial import assembly
from drill_twin.dynamics.solver.spatial import formulation as lower
from drill_twin.dynamics.solver.spatial.linear_solver import NODE, solve_blocks
from drill_twin.dynamics.solver.state import BIT_IMPULSE, HOOK_IMPULSE, KNOWN, TORQUE_IMPULSE, State, StepControl
from drill_twin.physics.model import SPIN, Axis, Rod, distance_along


@kernel
def column(i: int) -> int:
    """Column of the i-th unknown above the joint in a node's row of seven."""
    return 2 if i == 0 else 5 if i == 1 else SPIN


@kernel
def read_node(axis: Axis | None, j: int, row: Array, rates: Array, place: Array, speed: Array) -> None:
    """Fill in z, z', psi and their rates of a node from its row and velocities."""
    place[0] = distance_along(axis, j, row[0], row[1], row[2])
    at = along(axis, j, place[0])
    place[1] = at.tx * row[3] + at.ty * row[4] + at.tz * row[5]
    speed[0] = at.tx * rates[0] + at.ty * rates[1] + at.tz * rates[2]
    speed[1] = at.tx * rates[3] + at.ty * rates[4] + at.tz * rates[5]
    place[2], speed[2] = row[SPIN], rates[SPIN]


@kernel
def write_node(axis: Axis | None, j: int, place: Array, speed: Array, row: Array, rates: Array) -> None:
    """The inverse of `read_node`, for a node on the axis of the hole."""
    at = along(axis, j, place[0])
    z, slope, dz = place[0], place[1], speed[0]
    bend = at.curvature * slope * dz
    if axis is None:
        row[0], row[1], row[2] = 0.0, 0.0, z
    else:
        c, t, n, k = axis.centre[j], axis.tangent[j], axis.normal[j], at.curvature
        way = z - axis.along[j]
        angle = k * way
        on, across = way, 0.0
        if k > 0.0:
            on, across = np.sin(angle) / k, 2.0 * np.sin(0.5 * angle) ** 2 / k
        for i in range(3):
            row[i] = c[i] + on * t[i] + across * n[i]
    row[3], row[4], row[5] = slope * at.tx, slope * at.ty, slope * at.tz
    rates[0], rates[1], rates[2] = dz * at.tx, dz * at.ty, dz * at.tz
    rates[3] = speed[1] * at.tx + bend * at.nx
    rates[4] = speed[1] * at.ty + bend * at.ny
    rates[5] = speed[1] * at.tz + bend * at.nz
    row[SPIN], rates[SPIN] = place[2], speed[2]


@kernel
def growth_of_along(axis: Axis | None, row: Array) -> float:
    """Growth of z with the motion of the joint along the hole: above 1 nearer to the centre of curvature."""
    if axis is None:
        return 1.0
    c, t, n, k = axis.centre[0], axis.tangent[0], axis.normal[0], axis.curvature[0]
    x, y, z = row[0] - c[0], row[1] - c[1], row[2] - c[2]
    a, b = x * t[0] + y * t[1] + z * t[2], x * n[0] + y * n[1] + z * n[2]
    return float(1.0 / np.sqrt((k * a) ** 2 + (1.0 - k * b) ** 2))


@kernel
def join(scratch: Workspace, row: Array, rates: Array, old: Array) -> None:
    """Set z, z', psi of the joint at mid-step, their rates now and at the start of the step, and their gradients."""
    read_node(scratch.nodes, 0, row, rates, scratch.here[0], scratch.rate[0])
    at, g = along(scratch.nodes, 0, scratch.here[0, 0]), scratch.joint
    share = growth_of_along(scratch.nodes, row)
    g[0, 0], g[0, 1], g[0, 2] = share * at.tx, share * at.ty, share * at.tz
    g[1, 0], g[1, 1], g[1, 2] = at.tx, at.ty, at.tz
    scratch.rate[0, 0] *= share
    scratch.old[0, 0] = g[0, 0] * old[0] + g[0, 1] * old[1] + g[0, 2] * old[2]
    scratch.old[0, 1] = g[1, 0] * old[3] + g[1, 1] * old[4] + g[1, 2] * old[5]
    scratch.old[0, 2] = old[SPIN]


@kernel
def predict(scratch: Workspace, constrained: Array, state: State, half_step: float) -> None:
    """Extrapolate the mid-step velocity; constrained unknowns move as prescribed."""
    first, top = scratch.rod.length.shape[0], state.u.shape[0] - 1
    lower.predict(scratch.below, constrained, state, half_step)
    for j in range(1, scratch.start.shape[0]):
        i = first + j
        read_node(scratch.nodes, j, state.u[i], state.v[i], scratch.start[j], scratch.old[j])
        for k in range(ALONG):
            c = column(k)
            if state.clock[KNOWN] < 1.0 and not (i == top and constrained[1, c]):  # of `v`, which is in space
                state.trial[i, c] = scratch.old[j, k]


@kernel
def move_to_middle(scratch: Workspace, state: State, half_step: float) -> None:
    """Set the configuration at mid-step."""
    first = scratch.rod.length.shape[0]
    lower.move_to_middle(state, half_step)
    for j in range(1, scratch.start.shape[0]):
        i = first + j
        for k in range(ALONG):
            c = column(k)
            scratch.rate[j, k] = state.trial[i, c]
            scratch.here[j, k] = scratch.start[j, k] + half_step * state.trial[i, c]
            state.place[i, c] = scratch.here[j, k]
    join(scratch, state.place[first], state.trial[first], state.v[first])


@kernel
def set_rows(scratch: Workspace, state: State) -> None:
    """Set rows and velocities of the nodes, above the joint on the axis of the hole, and clear their loads."""
    rows, first = scratch.rows, scratch.rod.length.shape[0]
    scratch.loads[:] = 0.0
    for i in range(first + 1):
        for c in range(NODE):
            rows[0, i, c], rows[1, i, c], rows[2, i, c] = state.place[i, c], state.trial[i, c], state.v[i, c]
    for j in range(1, scratch.start.shape[0]):
        at, i = along(scratch.nodes, j, scratch.here[j, 0]), first + j
        for n in range(3):
            slope = scratch.here[j, 1] if n == 0 else scratch.rate[j, 1] if n == 1 else scratch.old[j, 1]
            way = 0.0 if n == 0 else scratch.rate[j, 0] if n == 1 else scratch.old[j, 0]
            spin = scratch.here[j, 2] if n == 0 else scratch.rate[j, 2] if n == 1 else scratch.old[j, 2]
            rows[n, i, 0], rows[n, i, 1], rows[n, i, 2] = way * at.tx, way * at.ty, way * at.tz
            rows[n, i, 3], rows[n, i, 4], rows[n, i, 5] = slope * at.tx, slope * at.ty, slope * at.tz
            rows[n, i, SPIN] = spin


@kernel
def add_nodes(scratch: Workspace) -> None:
    """Add the loads on the nodes to the system; above the joint by their part along the hole, unless it is kept."""
    first, below = scratch.rod.length.shape[0], scratch.below.diagonal
    for i in range(first + 1):
        for r in range(NODE):
            for c in range(NODE + 1):
                below[i, r, c] += scratch.loads[i, r, c]
    if scratch.size[KEPT] > 0.0:
        return
    for j in range(1, scratch.start.shape[0]):
        at, out = along(scratch.nodes, j, scratch.here[j, 0]), scratch.loads[first + j]
        t = (at.tx, at.ty, at.tz)
        for k in range(3):
            scratch.right[j, 0] += t[k] * out[k, NODE]
            scratch.right[j, 1] += t[k] * out[3 + k, NODE]
            for c in range(3):
                scratch.diagonal[j, 0, 0] += t[k] * t[c] * out[k, c]
                scratch.diagonal[j, 1, 1] += t[k] * t[c] * out[3 + k, 3 + c]
        scratch.right[j, 2] += out[SPIN, NODE]
        scratch.diagonal[j, 2, 2] += out[SPIN, SPIN]


@kernel
def close_top(scratch: Workspace, constrained: Array) -> None:
    """Add the loads on the top, and remove its constrained unknowns; save its rows for the reactions."""
    m = scratch.solved.shape[0]
    own, other, ends, top = scratch.diagonal[m], scratch.lower[m - 1], scratch.below.ends[TOP], scratch.top
    for i in range(ALONG):
        scratch.right[m, i] += ends[column(i), NODE]
        for k in range(ALONG):
            own[i, k] += ends[column(i), column(k)]
        top[i, 6] = scratch.right[m, i]
        for k in range(ALONG):
            top[i, k], top[i, ALONG + k] = own[i, k], other[i, k]
        if constrained[1, column(i)]:
            for k in range(ALONG):
                own[i, k] = 0.0
                other[i, k] = 0.0
            own[i, i] = 1.0
            scratch.right[m, i] = 0.0


@kernel
def solve(scratch: Workspace) -> bool:
    """Solve the system: above the joint, below it, and above it again.

    Where a system above the joint has been kept, the last Newton step has removed its residual.
    """
    below = scratch.below
    if scratch.size[KEPT] > 0.0:
        keep_above(scratch)
    elif not eliminate_above(scratch):
        return False
    add_to_joint(scratch)
    if not solve_blocks(below.lower, below.diagonal, below.upper, below.spare):
        return False
    solve_above(scratch)
    return True


@kernel
def correct(scratch: Workspace, state: State, control: StepControl, half_step: float) -> float:
    """Apply the Newton step; returns its size in tolerances, NaN if it is not finite."""
    top, change = scratch.top, scratch.change
    first, m = scratch.rod.length.shape[0], scratch.solved.shape[0]
    size = lower.correct(scratch.below, state, control, half_step)
    for i in range(ALONG):
        for k in range(ALONG):
            top[i, 6] -= top[i, k] * change[m, k] + top[i, ALONG + k] * change[m - 1, k]
    position, angle, total = 0.0, 0.0, 0.0
    for j in range(1, m + 1):
        for k in range(ALONG):
            state.trial[first + j, column(k)] -= change[j, k]
            total += change[j, k]
        position = max(position, abs(change[j, 0]))
        angle = max(angle, abs(change[j, 1]), abs(change[j, 2]))
    scratch.size[0] = max(position / control.position, angle / control.angle) * half_step
    return float(max(size, scratch.size[0]) + 0.0 * (size + total))


@kernel
def accept(scratch: Workspace, constrained: Array, state: State, counters: Array, half_step: float) -> None:
    """Take the step; a constrained top ends it at the speed that the drive prescribes."""
    step, first, last = 2.0 * half_step, scratch.rod.length.shape[0], state.u.shape[0] - 1
    lower.take_step(state, half_step)
    for j in range(1, scratch.start.shape[0]):
        i = first + j
        for k in range(ALONG):
            v = state.trial[i, column(k)]
            scratch.start[j, k] += step * v
            scratch.old[j, k] = 2.0 * v - scratch.old[j, k]
        if i == last and constrained[1, SPIN]:
            scratch.old[j, 2] = scratch.command[ROTATION]
        write_node(scratch.nodes, j, scratch.start[j], scratch.old[j], state.u[i], state.v[i])
    counters[TORQUE_IMPULSE] += scratch.top[2, 6] * step
    counters[HOOK_IMPULSE] += scratch.top[0, 6] * step
    counters[BIT_IMPULSE] += scratch.below.reaction[0, 2] * step


def bind(effects: Effects, section_stress: Any, distributed_load: Any, friction: Any) -> Formulation:
    """The formulation for a set of effects, and for their functions that the string above the joint needs."""
    assemble, load_ends, node_load = assembly.bind(effects), lower.bind_ends(effects.end_load), effects.node_load
    assemble_above = elements.bind(effects, section_stress, distributed_load, friction)

    @kernel
    def build(
        parameters: Any, rod: Rod, scratch: Workspace, constrained: Array, state: State, time: float, half_step: float,
        first_iteration: bool, number: float,
    ) -> None:  # fmt: skip
        """Fill the system: elements, loads at the ends, constraints."""
        below, size = scratch.below, scratch.size
        move_to_middle(scratch, state, half_step)
        for c in range(NODE):
            scratch.held[0, c] = constrained[0, c]
        # above the joint, where Newton's method has converged in this step, the system is kept
        size[KEPT] = 1.0 if size[0] < 1.0 and number > 0.0 and not first_iteration else 0.0
        assemble(
            parameters, scratch.rod, below, time, half_step, first_iteration, number, state.place, state.trial, state.v
        )
        if size[KEPT] == 0.0:
            assemble_above(parameters, rod, scratch, time, half_step, first_iteration, number)
        if scratch.loads.shape[0] > 0:
            set_rows(scratch, state)
            rows = scratch.rows
            node_load(parameters, rod, time, half_step, rows[0], rows[1], rows[2], scratch.loads)
            add_nodes(scratch)
        load_ends(parameters, rod, below, state, time, half_step)
        if size[KEPT] == 0.0:
            close_top(scratch, constrained)
        for c in range(NODE):
            for k in range(NODE + 1):
                below.ends[TOP, c, k] = 0.0
        lower.add_ends(below)
        lower.constrain(scratch.held, below)

    return Formulation(lower.begin, predict, build, solve, correct, accept, lower.finish, order=2)
