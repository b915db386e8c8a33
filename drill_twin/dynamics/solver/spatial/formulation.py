# SPDX-License-Identifier: Apache-2.0
"""The string in space: seven unknowns per node (r, r', psi), stretch and torsion included."""

from collections.abc import Callable
from typing import Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import (
    ROTATION,
    from_bit,
    to_bit,
    turn_blocks,
    turn_row,
    turn_row_back,
)
from drill_twin.dynamics.solver.interface import Effects, Formulation, bind_unknowns
from drill_twin.dynamics.solver.spatial import assembly
from drill_twin.dynamics.solver.spatial.linear_solver import NODE, Workspace, solve_blocks
from drill_twin.dynamics.solver.state import BIT_IMPULSE, HOOK_IMPULSE, TORQUE_IMPULSE, State, StepControl
from drill_twin.physics.model import SPIN, Rod


@kernel
def column(k: int) -> int:
    """Column of the k-th unknown in a node's row."""
    return k


extrapolate, clear_constrained, move_to_middle, take_step = bind_unknowns(NODE, column)


@kernel
def add_ends(scratch: Workspace) -> None:
    """Add the loads on bit and top to the system."""
    last = scratch.diagonal.shape[0] - 1
    for i in range(NODE):
        for j in range(NODE + 1):
            scratch.diagonal[0, i, j] += scratch.ends[0, i, j]
            scratch.diagonal[last, i, j] += scratch.ends[1, i, j]


@kernel
def constrain(constrained: Array, scratch: Workspace) -> None:
    """Remove the constrained unknowns, whose velocity is prescribed; save the rows of the ends for the reactions."""
    last = scratch.diagonal.shape[0] - 1
    for end in range(2):
        node = 0 if end == 0 else last
        own = scratch.diagonal[node]
        other = scratch.upper[0] if end == 0 else scratch.lower[last - 1]
        for i in range(NODE):
            scratch.reaction[end, i] = own[i, NODE]
            for j in range(NODE):
                scratch.end_rows[end, i, j] = own[i, j]
                scratch.end_rows[end, i, NODE + j] = other[i, j]
            if constrained[end, i]:
                for j in range(NODE):
                    own[i, j] = 0.0
                    other[i, j] = 0.0
                own[i, i] = 1.0
                own[i, NODE] = 0.0


@kernel
def update_reactions(scratch: Workspace) -> None:
    """Update the reactions at the ends by the Newton step just solved for."""
    last = scratch.diagonal.shape[0] - 1
    for end in range(2):
        own = scratch.diagonal[0 if end == 0 else last]
        other = scratch.diagonal[1 if end == 0 else last - 1]
        for i in range(NODE):
            for j in range(NODE):
                scratch.reaction[end, i] -= scratch.end_rows[end, i, j] * own[j, NODE]
                scratch.reaction[end, i] -= scratch.end_rows[end, i, NODE + j] * other[j, NODE]


@kernel
def predict(scratch: Workspace, constrained: Array, state: State, half_step: float) -> None:
    """Extrapolate the mid-step velocity; constrained unknowns move as prescribed."""
    extrapolate(state, half_step)
    turn_row(state.bit_frame, state.trial[0])
    clear_constrained(constrained, state.trial)
    turn_row_back(state.bit_frame, state.trial[0])
    if constrained[1, SPIN]:
        state.trial[state.u.shape[0] - 1, SPIN] = scratch.command[ROTATION]


@kernel
def correct(scratch: Workspace, state: State, control: StepControl, half_step: float) -> float:
    """Apply the Newton step; returns its size in tolerances, NaN if it is not finite."""
    update_reactions(scratch)
    turn_row_back(state.bit_frame, scratch.diagonal[0, :, NODE])
    position, angle, total = 0.0, 0.0, 0.0
    for i in range(scratch.diagonal.shape[0]):
        for c in range(NODE):
            change = scratch.diagonal[i, c, NODE]
            state.trial[i, c] -= change
            total += change
            if c < 3:
                position = max(position, abs(change))
            else:
                angle = max(angle, abs(change))
    return max(position / control.position, angle / control.angle) * half_step + 0.0 * total


@kernel
def accept(scratch: Workspace, constrained: Array, state: State, counters: Array, half_step: float) -> None:
    """Take the step; a constrained top ends it at the speed that the drive prescribes."""
    seconds = 2.0 * half_step
    take_step(state, half_step)
    counters[TORQUE_IMPULSE] += scratch.reaction[1, SPIN] * seconds
    counters[HOOK_IMPULSE] += scratch.reaction[1, 2] * seconds
    counters[BIT_IMPULSE] += scratch.reaction[0, 2] * seconds
    if constrained[1, SPIN]:
        state.v[state.u.shape[0] - 1, SPIN] = scratch.command[ROTATION]


@kernel
def solve(scratch: Workspace) -> bool:
    """Solve the block system in place."""
    return solve_blocks(scratch.lower, scratch.diagonal, scratch.upper, scratch.spare)


@kernel
def begin(scratch: Workspace) -> None:
    """No-op: no factors are kept from step to step."""


@kernel
def finish(rod: Rod, state: State) -> None:
    """No-op: every column of the state is an unknown."""


def bind_ends(end_load: Any) -> Callable[..., None]:
    """The loads of the effects on bit and top, for their function `end_load`."""

    @kernel
    def load_ends(parameters: Any, rod: Rod, scratch: Workspace, state: State, time: float, half_step: float) -> None:
        """Fill `scratch.ends`; the bit is constrained, loaded and braked along and across the hole."""
        frame = state.bit_frame
        scratch.ends[:] = 0.0
        turn_blocks(frame, scratch.diagonal[0], scratch.upper[0], scratch.lower[0])
        to_bit(frame, state.place[0], state.trial[0])
        turn_row(frame, state.v[0])
        end_load(parameters, rod, scratch.command, time, half_step, state.place, state.trial, state.v, scratch.ends)
        from_bit(frame, state.place[0], state.trial[0])
        turn_row_back(frame, state.v[0])

    return load_ends


def bind(effects: Effects) -> Formulation:
    """The formulation for a set of effects."""
    assemble, load_ends, node_load = assembly.bind(effects), bind_ends(effects.end_load), effects.node_load

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
        """Fill the block system: elements, loads at nodes and ends, constraints."""
        move_to_middle(state, half_step)
        assemble(parameters, rod, scratch, time, half_step, first_iteration, number, state.place, state.trial, state.v)
        node_load(parameters, rod, time, half_step, state.place, state.trial, state.v, scratch.diagonal)
        load_ends(parameters, rod, scratch, state, time, half_step)
        add_ends(scratch)
        constrain(constrained, scratch)

    return Formulation(begin, predict, build, solve, correct, accept, finish, order=2)
