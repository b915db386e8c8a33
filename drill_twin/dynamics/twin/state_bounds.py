# SPDX-License-Identifier: Apache-2.0
"""Bounds of a plausible state; wide, to detect a failed computation, not an inaccurate one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.dynamics.discretisation.discretise import sections_of
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.dynamics.discretisation.resolution import impact_depth
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

LARGEST_TILT, LARGEST_LATERAL_TILT = 1.99, 0.8
"""Largest 1 - t_z: in the spatial formulation at 172 degrees, as twist is undefined in a string folded back; and in the
lateral one, which is for small slopes."""
LEAST_SPEED = 1000.0
"""Smallest bound of the speed [m/s]."""
DEPTH_MARGIN = 10.0
"""Largest penetration over that of the contact law for the current speed and load."""


@dataclass(frozen=True)
class StateBounds:
    """Bounds of a plausible state."""

    speed: float
    """Largest speed: that of sound in the string, at least `LEAST_SPEED` [m/s]."""
    tilt: float
    """Largest 1 - t_z."""
    lateral: bool
    """True in the lateral formulation."""
    line_mass: float
    """Largest mass per length, mud included [kg/m]."""
    flexibility: float
    """Largest clearance over 4 EI [1/(N m)]: times the load squared, the wall force of a helix [N/m]."""
    weight: float
    """Weight of the string [N]."""
    line_load: float
    """Largest weight per length, and six times the rms of a random force [N/m]."""
    curvature: float
    """Largest curvature of the hole [1/m]."""

    def largest_depth(self, wall: Wall, speed: float, load: float, step: float) -> float:
        """Largest plausible penetration into the wall [m].

        `DEPTH_MARGIN` times the sum of that of an impact, K d^(p+1) / (p+1) = m v^2 / 2 per length, and that under the
        load, a helix's F^2 r / (4 EI) (Lubinski, Althouse and Logan 1962) with weight, random force and curvature; plus
        the distance moved in a step, as contact is evaluated at its ends only.

        Args:
            wall: Law of the wall.
            speed: Largest speed of the string [m/s].
            load: Weight on bit [N].
            step: Time step [s].
        """
        impact = impact_depth(wall, self.line_mass, speed)
        return float(DEPTH_MARGIN * (impact + self.static_depth(wall, load)) + speed * step)

    def static_depth(self, wall: Wall, load: float) -> float:
        """Penetration at rest under a load [m], of a helix pressed on the wall over its whole length.

        Args:
            wall: Law of the wall.
            load: Weight on bit [N].
        """
        power = 1.0 if wall.linear else 1.5
        axial = abs(load) + self.weight
        pressed = axial**2 * self.flexibility + axial * self.curvature + self.line_load
        return float((pressed / wall.stiffness) ** (1.0 / power))


def bounds_of(scene: Scene, model: DiscreteModel, *, lateral: bool) -> StateBounds:
    """Compute the bounds of a scene."""
    rod, bore = model.rod, model.wellbore
    weight = np.abs(axial_weight(scene, model))
    gravity = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    random = 0.0 if scene.effects.random_force is None else scene.effects.random_force.rms
    mud = model.fluid_density * 4.0 * np.pi * model.contact_radius.max() ** 2
    clearance = bore.clearance.reshape(-1, 2).max(axis=1)
    return StateBounds(
        speed=max(LEAST_SPEED, *(float(np.sqrt(tube.youngs_modulus / tube.density)) for tube in sections_of(scene))),
        tilt=LARGEST_LATERAL_TILT if lateral else LARGEST_TILT,
        lateral=lateral,
        line_mass=float(rod.line_mass.max() + mud),
        flexibility=float(np.max(clearance / (4.0 * rod.bending))),
        weight=float(weight.sum()),
        line_load=float(gravity * rod.line_mass.max()) + 6.0 * random,
        curvature=0.0 if bore.axis is None else float(bore.axis.curvature.max()),
    )
