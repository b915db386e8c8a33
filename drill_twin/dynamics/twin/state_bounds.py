# SPDX-License-Identifier: Apache-2.0
"""Bounds of a plausible state; wide, to detect a failed computation, not an inaccurate one."""

from __future__ import annotations

import numpy as np

from drill_twin.dynamics.discretisation.discretise import sections_of
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.dynamics.twin.state_judge import Bounds
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

LARGEST_TILT, LARGEST_LATERAL_TILT = 1.99, 0.8
"""Largest 1 - t_z: in the spatial formulation at 172 degrees, as twist is undefined in a string folded back; and in the
lateral one, which is for small slopes."""
LARGEST_STRAIN = 0.5
"""Largest strain in size [-]; ten times that of the elastic law's validity."""
LEAST_SPEED = 1000.0
"""Smallest bound of the speed [m/s]."""


def bounds_of(scene: Scene, model: DiscreteModel, wall: Wall | None, *, lateral: bool) -> Bounds:
    """Compute the bounds of a scene with a wall, in the lateral formulation or the spatial one."""
    rod, bore = model.rod, model.wellbore
    weight = np.abs(axial_weight(scene, model))
    gravity = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    random = 0.0 if scene.effects.random_force is None else scene.effects.random_force.rms
    mud = model.fluid_density * 4.0 * np.pi * model.contact_radius.max() ** 2
    clearance = bore.clearance.reshape(-1, 2).max(axis=1)
    return Bounds(
        speed=max(LEAST_SPEED, *(float(np.sqrt(tube.youngs_modulus / tube.density)) for tube in sections_of(scene))),
        tilt=LARGEST_LATERAL_TILT if lateral else LARGEST_TILT,
        strain=np.inf if lateral else LARGEST_STRAIN,
        lateral=lateral,
        walled=wall is not None,
        stiffness=1.0 if wall is None else float(wall.stiffness),
        power=1.0 if wall is None or wall.linear else 1.5,
        line_mass=float(rod.line_mass.max() + mud),
        flexibility=float(np.max(clearance / (4.0 * rod.bending))),
        weight=float(weight.sum()),
        line_load=float(gravity * rod.line_mass.max()) + 6.0 * random,
        curvature=0.0 if bore.axis is None else float(bore.axis.curvature.max()),
    )
