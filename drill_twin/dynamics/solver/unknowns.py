# SPDX-License-Identifier: Apache-2.0
"""Operations on the unknowns that are the same in every formulation."""

from typing import Any, NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.state import State, extrapolation_weights


class Unknowns(NamedTuple):
    """Compiled functions over the unknowns of all nodes."""

    extrapolate: Any  # (state, half_step): mid-step velocity `trial` from the last ones
    clear_constrained: Any  # (constrained, trial): zero velocity of the constrained unknowns of bit and top
    move_to_middle: Any  # (state, half_step): configuration `place` at mid-step, u_n + half_step v
    take_step: Any  # (state, half_step): u_n+1 = u_n + dt v, v_n+1 = 2 v - v_n


def bind(count: int, column: Any) -> Unknowns:
    """The operations for nodes of `count` unknowns; `column(k)` is the column of the k-th in a node's row."""

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

    return Unknowns(extrapolate, clear_constrained, move_to_middle, take_step)
