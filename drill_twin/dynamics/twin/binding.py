# SPDX-License-Identifier: Apache-2.0
"""Arguments of the compiled frame loop besides those of the time loop: marks, bounds, sources, memories."""

from __future__ import annotations

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.boundary_conditions import BoundaryConditions
from drill_twin.dynamics.discretisation.discretise import axis_at
from drill_twin.dynamics.solver import state
from drill_twin.dynamics.twin.frame_kernel import AS_SET, MINUS_SET, Effort, Reactions
from drill_twin.dynamics.twin.observation import MarkPlaces, locate_marks, make_observation
from drill_twin.dynamics.twin.state_history import make_past
from drill_twin.dynamics.twin.state_judge import EXTREMES, VERDICT
from drill_twin.physics.model.bit import BIT_WEIGHT, HOOK, TOP_TORQUE
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.section_stress import SCALARS
from drill_twin.scene import Scene


def marks_of(scene: Scene, model: DiscreteModel) -> MarkPlaces:
    """Locate the marks of a scene."""
    marks = np.array([mark.distance_from_bit for mark in scene.string.marks])
    offset = np.array([mark.wall_offset for mark in scene.mark_table])
    return locate_marks(model.rod, marks, offset, axis_at(scene, scene.length - marks))


def reactions_of(ends: BoundaryConditions) -> Reactions:
    """Find the sources of the forces of the rig."""
    beyond = state.COUNTERS
    weight = beyond + BIT_WEIGHT if ends.bit_on_rock or ends.hoisted else state.BIT_IMPULSE
    hook = beyond + HOOK if ends.hoisted else state.HOOK_IMPULSE
    return Reactions(
        torque=beyond + TOP_TORQUE if ends.torque_driven else state.TORQUE_IMPULSE,
        weight=weight if ends.weight_at_top or ends.hoisted else AS_SET,
        hook=MINUS_SET if ends.weight_at_top else hook,
    )


def memories(
    scene: Scene, model: DiscreteModel, counters: Array, impulse: Array, stress: Array | None
) -> dict[str, Any]:
    """Arrays of `BoundTwin` that are made for it, by field, and what does not change in a run."""
    return {
        "target": np.zeros(3),
        "effort": Effort(counters, np.zeros_like(counters), impulse, np.zeros_like(impulse)),
        "now": np.zeros(EXTREMES),
        "before": np.zeros(EXTREMES),
        "verdict": np.zeros(VERDICT),
        "guard": np.array([1.0, 0.0]),
        "course": np.zeros(2, np.int64),
        "marks": marks_of(scene, model),
        "seen": make_observation(model.places, len(scene.string.marks)),
        "stress": np.zeros((0, len(SCALARS))) if stress is None else stress,
        "past": make_past(model.rod.arc.size, scene.numerics.frame_rate),
    }
