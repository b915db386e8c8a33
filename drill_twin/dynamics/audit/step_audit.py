# SPDX-License-Identifier: Apache-2.0
"""The energy audit of a step: each effect's work on the string in it, for a scene that asks for it.

The midpoint rule makes the work of a force over a step exactly F v dt with the force and the velocity at mid-step, so
the work of all forces adds up to the change of kinetic energy to round-off. Once a step has converged, the system is
built once more with effects that record their work in the ledger. The remaining residual of the equations is the
reaction that drives a constrained unknown, and at a free unknown the part that Newton's method left unsolved.

In the lateral form no node moves along the hole as an unknown; the axial velocity follows from the slopes, so that
gravity and weight on bit do work there too.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.audit.energy_ledger import (
    AXIAL_VELOCITY,
    ENDS,
    HEAT,
    LOST,
    NEWTON,
    NODE_VELOCITY,
    NOW,
    POWER,
    SAMPLE,
    TOP_CLAMP,
    TOP_DRIVE,
    TOP_ROW,
    WEIGHT_ON_BIT,
    WORK,
)
from drill_twin.dynamics.solver.boundary import BIT, RESIDUAL, TOP, turn_row, turn_row_back
from drill_twin.dynamics.solver.joined.formulation import column as column_above
from drill_twin.dynamics.solver.joined.linear_solver import ALONG
from drill_twin.dynamics.solver.lateral.formulation import column
from drill_twin.dynamics.solver.lateral.linear_solver import ADDED, HALF_STEP, NODE, RENEW, RENEW_STEPS, TORQUE
from drill_twin.dynamics.solver.state import State
from drill_twin.physics.model.mesh import SPIN, Rod

OUTSIDE_ITERATION = -5.0  # number of an iteration that no effect remembers as the last iteration of Newton's method


@kernel
def start_step(entries: Array) -> None:
    """Clear the powers of the step."""
    entries[POWER, :] = 0.0
    entries[HEAT, :] = 0.0
    entries[ENDS, :] = 0.0
    entries[NOW, SAMPLE] = 0.0


@kernel
def end_step(entries: Array, state: State, step: float) -> None:
    """Add the step's work to the totals; note the velocity of the top after it by the midpoint rule alone."""
    last = state.u.shape[0] - 1
    for k in range(entries.shape[1]):
        entries[WORK, k] += step * entries[POWER, k]
        entries[LOST, k] += step * entries[HEAT, k]
    for c in range(7):
        entries[TOP_ROW, c] = 2.0 * state.trial[last, c] - state.v[last, c]


@kernel
def close_step(parameters: Any, rod: Rod, state: State) -> None:
    """Record the work of setting the top to its prescribed velocity, which the midpoint rule alone would overshoot."""
    entries, v = parameters.ledger.entries, state.v
    e, last = rod.length.shape[0] - 1, v.shape[0] - 1
    mass = rod.mass[e]
    for c in range(2):
        change = v[last, c] - entries[TOP_ROW, c]
        momentum = mass[2, 0] * v[e, c] + mass[2, 1] * v[e, 3 + c] + mass[2, 3] * v[last, 3 + c]
        momentum += mass[2, 2] * (entries[TOP_ROW, c] + 0.5 * change)
        entries[WORK, TOP_CLAMP] += change * momentum


@kernel
def add_power(entries: Array, c: int, driven: bool, power: float) -> None:
    """Add the power of a residual [W] in the column c of a node: a reaction's, or what Newton's method left."""
    entries[POWER, (TOP_DRIVE if c == SPIN else TOP_CLAMP) if driven else NEWTON] += power


def bind_spatial(build: Any) -> Callable[..., None]:
    """The audit of a step of the spatial form; `build` fills the system with effects that record their work."""

    @kernel
    def audit(
        parameters: Any, rod: Rod, scratch: Any, constrained: Array, state: State, time: float, half_step: float
    ) -> None:
        entries, free, last = parameters.ledger.entries, parameters.ledger.constrained, state.u.shape[0] - 1
        start_step(entries)
        build(parameters, rod, scratch, free, state, time, half_step, False, OUTSIDE_ITERATION)
        turn_row(state.bit_frame, state.trial[0])
        for i in range(last + 1):
            for c in range(7):
                power = scratch.diagonal[i, c, RESIDUAL] * state.trial[i, c]
                driven = (i == 0 and constrained[0, c]) or (i == last and constrained[1, c])
                add_power(entries, c, driven, power)
        turn_row_back(state.bit_frame, state.trial[0])
        end_step(entries, state, 2.0 * half_step)

    return audit


def bind_joined(build: Any) -> Callable[..., None]:
    """The audit of a step of the joined form; `build` as for `bind_spatial`. The forces at the joint do no net work."""

    @kernel
    def audit(
        parameters: Any, rod: Rod, scratch: Any, constrained: Array, state: State, time: float, half_step: float
    ) -> None:
        entries, free, below = parameters.ledger.entries, parameters.ledger.constrained, scratch.below.diagonal
        start_step(entries)
        build(parameters, rod, scratch, free, state, time, half_step, False, OUTSIDE_ITERATION)
        turn_row(state.bit_frame, state.trial[0])
        for i in range(below.shape[0]):
            for c in range(7):
                add_power(entries, c, i == 0 and constrained[0, c], below[i, c, RESIDUAL] * state.trial[i, c])
        turn_row_back(state.bit_frame, state.trial[0])
        for j in range(scratch.right.shape[0]):
            for k in range(ALONG):
                c = column_above(k)
                driven = j == scratch.right.shape[0] - 1 and constrained[1, c]
                add_power(entries, c, driven, scratch.right[j, k] * scratch.rate[j, k])
        end_step(entries, state, 2.0 * half_step)

    return audit


def bind_lateral(build: Any) -> Callable[..., None]:
    """The audit of a step of the lateral form; `build` as for `bind_spatial`."""

    @kernel
    def audit(
        parameters: Any, rod: Rod, scratch: Any, constrained: Array, state: State, time: float, half_step: float
    ) -> None:
        entries, free = parameters.ledger.entries, parameters.ledger.constrained
        reuse, last = scratch.reuse, state.u.shape[0] - 1
        start_step(entries)
        from_top = parameters.drive.from_top > 0.0
        shortening = set_axial_velocity(rod, state, half_step, from_top, parameters.ledger.gauss)
        # the factors are left as they are, and the system is built exactly once
        half, renew, steps, added = reuse[HALF_STEP], reuse[RENEW], reuse[RENEW_STEPS], reuse[ADDED]
        reuse[HALF_STEP], reuse[RENEW], reuse[RENEW_STEPS], reuse[ADDED] = half_step, 0.0, 0.0, np.inf
        build(parameters, rod, scratch, free, state, time, half_step, False, OUTSIDE_ITERATION)
        reuse[HALF_STEP], reuse[RENEW], reuse[RENEW_STEPS], reuse[ADDED] = half, renew, steps, added
        for i in range(last + 1):
            for k in range(NODE):
                c = column(k)
                power = scratch.right[i, k] * state.trial[i, c]
                driven = (i == 0 and constrained[0, c]) or (i == last and constrained[1, c])
                entries[POWER, TOP_CLAMP if driven else NEWTON] += power
        entries[POWER, WEIGHT_ON_BIT] += (scratch.ends[TOP, 2, RESIDUAL] - scratch.ends[BIT, 2, RESIDUAL]) * shortening
        entries[POWER, TOP_DRIVE] += (scratch.axial[TORQUE] + scratch.ends[BIT, SPIN, RESIDUAL]) * state.trial[
            last, SPIN
        ]
        end_step(entries, state, 2.0 * half_step)

    return audit


@kernel
def set_axial_velocity(rod: Rod, state: State, half_step: float, from_top: bool, gauss: Array) -> float:
    """Fill in the velocity of Gauss points and nodes along the hole, v_z(s) = int_s^top r'.r'_dot; return it at s = 0.

    Summed as the axial force is (`drill_twin.dynamics.solver.lateral.assembly`), so that the work of both agrees. Where
    the weight is set at the top the bit is constrained, and the top moves instead.
    """
    above, out, at_nodes = 0.0, gauss[AXIAL_VELOCITY], gauss[NODE_VELOCITY]
    at_nodes[rod.length.shape[0]] = 0.0
    for e in range(rod.length.shape[0] - 1, -1, -1):
        h, total = rod.length[e], 0.0
        for p in range(2):
            d, g = rod.shape[e, p, 1], 0.0
            for c in range(2):
                rate = (
                    d[0] * state.trial[e, c] + d[1] * state.trial[e, 3 + c]
                    + d[2] * state.trial[e + 1, c] + d[3] * state.trial[e + 1, 3 + c]
                )  # fmt: skip
                slope = (
                    d[0] * state.u[e, c] + d[1] * state.u[e, 3 + c]
                    + d[2] * state.u[e + 1, c] + d[3] * state.u[e + 1, 3 + c]
                )  # fmt: skip
                g += (slope + half_step * rate) * rate
            out[2 * e + p] = above + rod.spin_shape[p, 1] * h * g
            total += 0.5 * h * g
        above += total
        at_nodes[e] = above
    if from_top:
        for k in range(out.shape[0]):
            out[k] -= above
        for i in range(rod.arc.shape[0]):
            at_nodes[i] -= above
    return above
