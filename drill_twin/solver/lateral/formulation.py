# SPDX-License-Identifier: Apache-2.0
"""The string without stretch and torsion: two lateral unknowns per node and their slopes.

The axial force follows from balance at every instant and the spin from the top drive, so neither axial nor torsional
waves exist. The state keeps its seven columns; those that are not unknowns are filled in at the end of a frame.
"""

from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.model.mesh import SPIN, Rod
from drill_twin.solver.boundary.rig import BIT, RESIDUAL, ROTATION, TOP
from drill_twin.solver.lateral import assembly
from drill_twin.solver.lateral.assembly import AT_BIT, AT_TOP, TORQUE, WEIGHT, Workspace, make_workspace
from drill_twin.solver.lateral.linear_solver import NODE, factor_blocks, solve_blocks
from drill_twin.solver.midpoint import Effects, Formulation
from drill_twin.solver.state import (
    BIT_IMPULSE,
    FACTOR,
    HOOK_IMPULSE,
    TORQUE_IMPULSE,
    Limits,
    State,
    extrapolation_weights,
)

# Indices into Workspace.lazy: half step of the factors (0: none), 1 if they must be renewed, steps for which they are
# renewed at once, size of the last Newton step, stiffness and damping that the effects had added [N s/m].
HALF_STEP, RENEW, EAGER, LAST_SIZE, FIRM = 0, 1, 2, 3, 4
GOOD = 0.1  # the factors are kept while each Newton step is smaller than this share of the last
CHANGED = 0.1  # and while the stiffness that the effects add, mostly the wall, has changed by less than this share
SAME_STEP = 1e-9  # steps of one length differ by rounding
PATIENCE = 8.0  # steps of renewing at once, after factors that had to be replaced

X, Y, SLOPE_X, SLOPE_Y = 0, 1, 3, 4  # columns of the unknowns in a node's row


@kernel
def column(i: int) -> int:
    """Column of the i-th of the four unknowns in a node's row of seven."""
    return i if i < 2 else i + 1


@kernel
def begin(work: Workspace) -> None:
    """Discard the factors, so that a run resumed between two frames equals one that was not interrupted."""
    work.lazy[:] = 0.0


@kernel
def predict(constrained: Array, state: State, command: Array, step: float) -> None:
    """Extrapolate the mid-step velocity; constrained unknowns move as prescribed."""
    now, last_, before = extrapolation_weights(state.clock, step)
    last = state.u.shape[0] - 1
    for i in range(last + 1):
        for k in range(NODE):
            c = column(k)
            state.trial[i, c] = now * state.v[i, c] + last_ * state.middle[i, c] + before * state.earlier[i, c]
    for k in range(NODE):
        c = column(k)
        if constrained[0, c]:
            state.trial[0, c] = 0.0
        if constrained[1, c]:
            state.trial[last, c] = 0.0
    state.trial[0, SPIN] = command[ROTATION]
    state.trial[last, SPIN] = command[ROTATION]


@kernel
def add_ends(constrained: Array, work: Workspace, full: bool) -> None:
    """Add the loads on bit and top to the system, then remove the constrained unknowns from it."""
    last = work.diagonal.shape[0] - 1
    for end in range(2):
        node = 0 if end == 0 else last
        own, right = work.diagonal[node], work.right[node]
        other = work.upper[0] if end == 0 else work.lower[last - 1]
        for i in range(NODE):
            right[i] += work.ends[end, column(i), RESIDUAL]
            if constrained[end, column(i)]:
                right[i] = 0.0
        if full:
            for i in range(NODE):
                for j in range(NODE):
                    own[i, j] += work.ends[end, column(i), column(j)]
                if constrained[end, column(i)]:
                    for j in range(NODE):
                        own[i, j] = 0.0
                        other[i, j] = 0.0
                    own[i, i] = 1.0


@kernel
def outdated(work: Workspace, h2: float, fresh: bool) -> bool:
    """Whether the tangent must be assembled and factored again.

    Without contact it changes slowly: its factors are used for many steps, as in codes for stiff equations (Hairer and
    Wanner 1996, IV.8). They are renewed where the step changed or Newton's method slows down.
    """
    lazy = work.lazy
    if fresh:
        lazy[LAST_SIZE] = 0.0
        lazy[EAGER] = max(lazy[EAGER] - 1.0, 0.0)
    if lazy[EAGER] > 0.0:
        lazy[RENEW] = 1.0
    other_step: bool = abs(lazy[HALF_STEP] - h2) > SAME_STEP * h2
    return other_step or lazy[RENEW] > 0.0


@kernel
def solve(work: Workspace) -> bool:
    """Solve the block system in place, with new factors where `build` has made a new tangent."""
    if work.lazy[HALF_STEP] < 0.0:
        if not factor_blocks(work.lower, work.diagonal, work.upper, work.inverse):
            work.lazy[HALF_STEP] = 0.0
            return False
        work.lazy[HALF_STEP] = -work.lazy[HALF_STEP]
        work.lazy[RENEW] = 0.0
    solve_blocks(work.lower, work.upper, work.inverse, work.right)
    return True


@kernel
def judge(work: Workspace, size: float) -> None:
    """Request new factors if Newton's method slows down."""
    lazy = work.lazy
    if lazy[LAST_SIZE] > 0.0 and not size < GOOD * lazy[LAST_SIZE]:
        lazy[RENEW] = 1.0
        lazy[EAGER] = PATIENCE
    lazy[LAST_SIZE] = size


@kernel
def correct(state: State, limits: Limits, work: Workspace, h2: float) -> float:
    """Apply the Newton step; returns its size in tolerances, NaN if it is not finite."""
    place, angle, total, torque = 0.0, 0.0, 0.0, 0.0
    for i in range(state.u.shape[0]):
        right, row = work.right[i], state.trial[i]
        row[X] -= right[0]
        row[Y] -= right[1]
        row[SLOPE_X] -= right[2]
        row[SLOPE_Y] -= right[3]
        place = max(place, abs(right[0]), abs(right[1]))
        angle = max(angle, abs(right[2]), abs(right[3]))
        lever = work.lever[i]
        torque -= lever[0] * right[0] + lever[1] * right[1] + lever[2] * right[2] + lever[3] * right[3]
        total += right[0] + right[1] + right[2] + right[3]
    size = max(place / limits.place, angle / limits.angle) * h2 + 0.0 * total
    work.axial[TORQUE] += torque
    judge(work, size)
    return size


@kernel
def accept(_fixed: Array, state: State, work: Workspace, counters: Array, command: Array, step: float) -> None:
    """Take the step: u_n+1 = u_n + dt v, v_n+1 = 2 v - v_n; the drive prescribes the spin at the end."""
    last = state.u.shape[0] - 1
    for i in range(last + 1):
        for k in range(NODE):
            c = column(k)
            v = state.trial[i, c]
            state.u[i, c] += step * v
            state.v[i, c] = 2.0 * v - state.v[i, c]
            state.earlier[i, c] = state.middle[i, c]
            state.middle[i, c] = v
    angle = state.u[last, SPIN] + step * state.trial[last, SPIN]
    for end in (0, last):
        state.u[end, SPIN] = angle
        state.v[end, SPIN] = command[ROTATION]
    counters[TORQUE_IMPULSE] += (work.axial[TORQUE] + work.ends[BIT, SPIN, RESIDUAL]) * step
    counters[HOOK_IMPULSE] += work.axial[AT_TOP] * step
    counters[BIT_IMPULSE] -= work.axial[AT_BIT] * step


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
        ax = w[0] * u[e, X] + w[1] * u[e, SLOPE_X] + w[2] * u[e + 1, X] + w[3] * u[e + 1, SLOPE_X]
        ay = w[0] * u[e, Y] + w[1] * u[e, SLOPE_Y] + w[2] * u[e + 1, Y] + w[3] * u[e + 1, SLOPE_Y]
        dx = w[0] * v[e, X] + w[1] * v[e, SLOPE_X] + w[2] * v[e + 1, X] + w[3] * v[e + 1, SLOPE_X]
        dy = w[0] * v[e, Y] + w[1] * v[e, SLOPE_Y] + w[2] * v[e + 1, Y] + w[3] * v[e + 1, SLOPE_Y]
        middle = np.sqrt(1.0 - min(ax * ax + ay * ay, 0.99))
        u[e, 2] = u[e + 1, 2] - h / 6.0 * (u[e, 5] + 4.0 * middle + u[e + 1, 5])
        v[e, 2] = v[e + 1, 2] - h / 6.0 * (v[e, 5] - 4.0 * (ax * dx + ay * dy) / middle + v[e + 1, 5])


def bind(effects: Effects) -> Formulation:
    """The formulation for a set of effects."""
    assemble = assembly.bind(effects)
    end_load = effects.end_load

    @kernel
    def build(
        parameters: Any,
        rod: Rod,
        work: Workspace,
        constrained: Array,
        state: State,
        command: Array,
        time: float,
        h2: float,
        fresh: bool,
        number: float,
    ) -> None:
        """Fill the block system: elements, loads at the ends, constraints."""
        last = state.u.shape[0] - 1
        for i in range(last + 1):
            for k in range(NODE):
                c = column(k)
                state.place[i, c] = state.u[i, c] + h2 * state.trial[i, c]
        for end in (0, last):
            state.place[end, SPIN] = state.u[last, SPIN] + h2 * state.trial[last, SPIN]
        work.ends[:] = 0.0
        end_load(parameters, rod, command, time, h2, state.place, state.trial, state.v, work.ends)
        # pushed up at the bit, or down at the top with the string's weight added on the way
        tension = work.ends[BIT, 2, RESIDUAL]
        if work.ends[TOP, 2, RESIDUAL] != 0.0 or constrained[0, 2]:
            tension = work.axial[WEIGHT] - work.ends[TOP, 2, RESIDUAL]
        full = outdated(work, h2, fresh)
        for _ in range(2):
            firm = assemble(
                parameters, rod, work, time, h2, fresh, number, state.place, state.trial, state.v, tension, full
            )
            same = abs(firm - work.lazy[FIRM]) <= CHANGED * abs(work.lazy[FIRM])
            if not same:
                state.clock[FACTOR] = np.inf  # the rate of convergence without contact does not apply to contact
            if full or same:
                break
            full = True  # contact has begun or ended
            work.lazy[EAGER] = PATIENCE
        if full:
            work.lazy[HALF_STEP], work.lazy[FIRM] = -h2, firm
        work.axial[AT_BIT], work.axial[AT_TOP] = tension, tension - work.axial[WEIGHT]
        add_ends(constrained, work, full)

    return Formulation(begin, predict, build, solve, correct, accept, finish, order=1)


__all__ = ["bind", "make_workspace"]
