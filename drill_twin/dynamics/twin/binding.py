# SPDX-License-Identifier: Apache-2.0
"""Arguments of the compiled frame loop that the time loop does not take: marks, bounds, sources, memories.

The bounds of a plausible state are wide, to detect a failed computation, not an inaccurate one. The last states are
kept in a ring, to which compiled code adds without allocation, and are saved on failure.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import BoundaryConditions, axial_weight, axis_at, sections_of
from drill_twin.dynamics.solver import state
from drill_twin.dynamics.twin.frame_kernel import AS_SET, MINUS_SET, Effort, Past, Reactions
from drill_twin.dynamics.twin.observation import MarkPlaces, locate_marks, make_observation
from drill_twin.dynamics.twin.state_judge import EXTREMES, VERDICT, Bounds
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model import DiscreteModel
from drill_twin.physics.model.bit import BIT_WEIGHT, HOOK, TOP_TORQUE
from drill_twin.physics.model.section_stress import SCALARS
from drill_twin.scene import Scene

SPAN = 1.0
"""Length of the history [s]."""
MOST_BYTES = 32 * 1024 * 1024
"""Largest size; it limits the number of states of long strings at high frame rates."""


def make_past(nodes: int, frame_rate: float) -> Past:
    """Room for `SPAN` of frames, within `MOST_BYTES`."""
    count = int(np.clip(np.ceil(SPAN * frame_rate), 1, max(MOST_BYTES // (nodes * 14 * 8), 1)))
    return Past(np.full(count, np.nan), np.zeros((count, 2, nodes, 7)), np.zeros(1, np.int64))


def read_past(past: Past) -> tuple[Array, Array, Array]:
    """Times [s], shape (k,), and node rows u and v, shape (k, n + 1, 7) each, oldest first; copies."""
    count, end = past.time.size, int(past.next[0])
    order = np.arange(max(end - count, 0), end) % count
    order = order[past.time[order] > past.time[order[-1]] - SPAN - 1e-9] if order.size else order
    return past.time[order], past.rows[order, 0], past.rows[order, 1]


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
    scene: Scene, model: DiscreteModel, counters: Array, impulse: Array, stress: Array | None, side: Array
) -> dict[str, Any]:
    """Arrays of `BoundTwin` that are made for it, by field, and what does not change in a run."""
    return {
        "effort": Effort(counters, np.zeros_like(counters), impulse, np.zeros_like(impulse)),
        "now": np.zeros(EXTREMES),
        "before": np.zeros(EXTREMES),
        "verdict": np.zeros(VERDICT),
        "guard": np.array([1.0, 0.0]),
        "course": np.zeros(2, np.int64),
        "marks": marks_of(scene, model),
        "seen": make_observation(model.places, len(scene.string.marks), side),
        "stress": np.zeros((0, len(SCALARS))) if stress is None else stress,
        "past": make_past(model.rod.arc.size, scene.numerics.frame_rate),
    }


LARGEST_TILT, LARGEST_LATERAL_TILT = 1.99, 0.8
"""Largest 1 - t_z: in the spatial formulation at 172 degrees, as twist is undefined in a string folded back; and in the
lateral formulation, which is for small slopes."""
LARGEST_STRAIN = 0.5
"""Largest strain in size [-]; ten times the largest strain for which the elastic law is valid."""
LEAST_SPEED = 1000.0
"""Smallest bound of the speed [m/s]."""


def bounds_of(scene: Scene, model: DiscreteModel, wall: Wall | None, *, lateral: bool) -> Bounds:
    """Compute the bounds of a scene with a wall, in the lateral formulation or the spatial one."""
    rod, bore = model.rod, model.wellbore
    weight = np.abs(axial_weight(scene, model))
    gravity = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    random = 0.0 if scene.effects.random_force is None else scene.effects.random_force.rms
    mud = model.fluid_density * 4.0 * np.pi * model.contact_radius.max() ** 2
    discs = 0.0 if model.bodies is None else float((model.bodies.mass / model.shares[model.bodies.node]).max())
    clearance = bore.clearance.reshape(-1, 2).max(axis=1)
    return Bounds(
        speed=max(LEAST_SPEED, *(float(np.sqrt(tube.youngs_modulus / tube.density)) for tube in sections_of(scene))),
        tilt=LARGEST_LATERAL_TILT if lateral else LARGEST_TILT,
        strain=np.inf if lateral else LARGEST_STRAIN,
        lateral=lateral,
        walled=wall is not None,
        stiffness=1.0 if wall is None else float(wall.stiffness),
        power=1.0 if wall is None or wall.linear else 1.5,
        line_mass=float(rod.line_mass.max() + mud) + discs,
        flexibility=float(np.max(clearance / (4.0 * rod.bending))),
        weight=float(weight.sum()),
        line_load=float(gravity * (rod.line_mass.max() + discs)) + 6.0 * random,
        curvature=0.0 if bore.axis is None else float(bore.axis.curvature.max()),
    )
