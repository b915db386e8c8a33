# SPDX-License-Identifier: Apache-2.0
"""Types through which time loop, formulation and effects call each other, and what is the same in every formulation."""

from typing import Any, NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.state import State, extrapolation_weights


class Effects(NamedTuple):
    """The effects of a scene, each hook as one function (`drill_twin.dynamics.solver.kernel_codegen`)."""

    axial_damping: Any
    section_stress: Any
    distributed_load: Any
    end_load: Any
    node_load: Any
    prescribed_motion: Any
    after_step: Any
    missed: Any


class Formulation(NamedTuple):
    """Motion of the string in one choice of unknowns.

    Arguments in common: `parameters` of the effects, `scratch` the formulation's workspace, whose `command` holds the
    set-points, `constrained` shape (2, 7), 1 where an unknown of bit or top is constrained, `time` at mid-step [s],
    `half_step` half the step [s].
    """

    begin: Any  # (scratch): before the first step of a frame
    predict: Any  # (scratch, constrained, state, half_step): first guess of the mid-step velocity
    build: Any
    """(parameters, rod, scratch, constrained, state, time, half_step, first_iteration, number): fill the system for an
    iteration; `first_iteration` is true in the first of a step, `number` counts iterations of the run."""
    solve: Any  # (scratch) -> whether it could be solved
    correct: Any  # (scratch, state, control, half_step) -> size of the Newton step in tolerances, NaN if not finite
    accept: Any  # (scratch, constrained, state, counters, half_step): advance the state by the step
    finish: Any  # (rod, state): fill in what a frame shows and the loop does not need
    order: int  # of Newton's convergence: 2, or 1 where the tangent may be an older one


def bind_unknowns(count: int, column: Any) -> tuple[Any, Any, Any, Any]:
    """Four compiled functions over the unknowns of all nodes, of which each node has `count`.

    In order: (state, half_step), mid-step velocity `trial` from the last ones; (constrained, trial), zero velocity of
    the constrained unknowns of bit and top; (state, half_step), configuration `place` at mid-step, u_n + half_step v;
    (state, half_step), a step, u_n+1 = u_n + dt v, v_n+1 = 2 v - v_n. `column(k)`: column of the k-th unknown in the
    row of a node.
    """

    @kernel
    def extrapolate(state: State, half_step: float) -> None:
        now, last, before = extrapolation_weights(state.clock, 2.0 * half_step)
        for i in range(state.u.shape[0]):
            for k in range(count):
                c = column(k)
                state.trial[i, c] = now * state.v[i, c] + last * state.middle[i, c] + before * state.earlier[i, c]

    @kernel
    def clear_constrained(constrained: Array, trial: Array) -> None:
        last = trial.shape[0] - 1
        for k in range(count):
            c = column(k)
            if constrained[0, c]:
                trial[0, c] = 0.0
            if constrained[1, c]:
                trial[last, c] = 0.0

    @kernel
    def move_to_middle(state: State, half_step: float) -> None:
        for i in range(state.u.shape[0]):
            for k in range(count):
                c = column(k)
                state.place[i, c] = state.u[i, c] + half_step * state.trial[i, c]

    @kernel
    def take_step(state: State, half_step: float) -> None:
        step = 2.0 * half_step
        for i in range(state.u.shape[0]):
            for k in range(count):
                c = column(k)
                v = state.trial[i, c]
                state.u[i, c] += step * v
                state.v[i, c] = 2.0 * v - state.v[i, c]
                state.earlier[i, c] = state.middle[i, c]
                state.middle[i, c] = v

    return extrapolate, clear_constrained, move_to_middle, take_step
