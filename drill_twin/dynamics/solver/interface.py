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

    Arguments in common: `parameters` of the effects, `scratch` the formulation's workspace, whose `command` holds the
    set-points, `constrained` shape (2, 7), 1 where an unknown of bit or top is constrained, `time` at mid-step [s],
    `half_step` half the step [s].
    """

    begin: Any  # (scratch): before the first step of a frame
    predict: Any  # (scratch, constrained, state, half_step): first guess of the mid-step velocity
    build: Any
    """(parameters, rod, scratch, constrained, state, time, half_step, first_iteration, number): fill the system for an
    iteration; `first_iteration` is true in the first of a step, `number` counts those of the run."""
    solve: Any  # (scratch) -> whether it could be solved
    correct: Any  # (scratch, state, control, half_step) -> size of the Newton step in tolerances, NaN if not finite
    accept: Any  # (scratch, constrained, state, counters, half_step): advance the state by the step
    finish: Any  # (rod, state): fill in what a frame shows and the loop does not need
    order: int  # of Newton's convergence: 2, or 1 where the tangent may be an older one
