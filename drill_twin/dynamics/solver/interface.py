# SPDX-License-Identifier: Apache-2.0
"""Types through which time loop, formulation and effects call each other; all functions in them are compiled."""

from typing import Any, NamedTuple


class Effects(NamedTuple):
    """The effects of a scene, each hook as one function (`drill_twin.dynamics.solver.kernel_codegen`)."""

    axial_damping: Any
    section_stress: Any
    distributed_load: Any
    end_load: Any
    prescribed_motion: Any
    after_step: Any


class Formulation(NamedTuple):
    """Motion of the string in one choice of unknowns.

    Arguments in common: `parameters` of the effects, `work` the formulation's workspace, whose `command` holds the
    set-points, `constrained` shape (2, 7), 1 where an unknown of bit or top is constrained, `time` at mid-step [s],
    `h2` half the step [s].
    """

    begin: Any  # (work): before the first step of a frame
    predict: Any  # (work, constrained, state, h2): first guess of the mid-step velocity
    build: (
        Any  # (parameters, rod, work, constrained, state, time, h2, fresh, number): fill the system for an iteration,
    )
    # `fresh` for the first of a step, `number` in the run
    solve: Any  # (work) -> whether it could be solved
    correct: Any  # (work, state, control, h2) -> size of the Newton step in tolerances, NaN if not finite
    accept: Any  # (work, constrained, state, counters, h2): advance the state by the step
    finish: Any  # (rod, state): fill in what a frame shows and the loop does not need
    order: int  # of Newton's convergence: 2, or 1 where the tangent may be an older one
