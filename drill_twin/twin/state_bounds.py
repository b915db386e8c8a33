# SPDX-License-Identifier: Apache-2.0
"""What the state of a string can be; wide on purpose, to tell a motion that has broken down, not an inaccurate one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.discretisation.discretise import sections_of
from drill_twin.discretisation.initial_state import axial_weight
from drill_twin.discretisation.resolution import impact_depth
from drill_twin.effects.wall import Parameters as Wall
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

FOLDED, ACROSS = 1.99, 0.8
"""Most that 1 - t_z may be: in space 172 degrees, as a string folded back has no twist; and in the
lateral form, which is for small slopes."""
LEAST_SPEED = 1000.0
"""Speed that no string is refused [m/s]."""
DEEPER = 10.0
"""Times the depth that the contact law gives for the impact and the load at hand."""


@dataclass(frozen=True)
class Bounds:
    """What a state can be."""

    speed: float
    """Sound in the string, or `LEAST_SPEED` where it is softer than what strings are made of [m/s]."""
    lean: float
    """Most that 1 - t_z may be."""
    lateral: bool
    """Whether the string only moves across the hole."""
    line_mass: float
    """Largest mass per length, mud included [kg/m]."""
    flexibility: float
    """Largest clearance over 4 EI [1/(N m)]: with the load squared, how a helix presses on the wall [N/m]."""
    weight: float
    """Weight of the string [N]."""
    line_load: float
    """Largest weight per length, and six times the rms of a random force [N/m]."""
    curvature: float
    """Largest curvature of the hole [1/m]."""

    def depth(self, wall: Wall, speed: float, load: float, step: float) -> float:
        """Deepest that the string can be in the wall [m].

        What the law gives for the hardest impact, K d^(p+1) / (p+1) = m v^2 / 2 per length, and for the load, the
        helix's F^2 r / (4 EI) (Lubinski, Althouse and Logan 1962) with weight, random force and curvature, `DEEPER`
        times both; and as far as the string goes in a step, since a long step meets the wall only at its ends.

        Args:
            wall: Law of the wall.
            speed: Fastest place of the string [m/s].
            load: Weight on bit [N].
            step: Time step [s].
        """
        power = 1.0 if wall.linear else 1.5
        impact = impact_depth(wall, self.line_mass, speed)
        axial = abs(load) + self.weight
        pressed = ((axial**2 * self.flexibility + axial * self.curvature + self.line_load) / wall.stiffness) ** (
            1.0 / power
        )
        return float(DEEPER * (impact + pressed) + speed * step)


def bounds_of(scene: Scene, model: DiscreteModel, *, lateral: bool) -> Bounds:
    """The bounds of a scene."""
    rod, bore = model.rod, model.wellbore
    weight = np.abs(axial_weight(scene, model))
    gravity = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    random = 0.0 if scene.effects.random_force is None else scene.effects.random_force.rms
    mud = model.fluid_density * 4.0 * np.pi * model.contact_radius.max() ** 2
    clearance = bore.clearance.reshape(-1, 2).max(axis=1)
    return Bounds(
        speed=max(LEAST_SPEED, *(float(np.sqrt(tube.youngs_modulus / tube.density)) for tube in sections_of(scene))),
        lean=ACROSS if lateral else FOLDED,
        lateral=lateral,
        line_mass=float(rod.line_mass.max() + mud),
        flexibility=float(np.max(clearance / (4.0 * rod.bending))),
        weight=float(weight.sum()),
        line_load=float(gravity * rod.line_mass.max()) + 6.0 * random,
        curvature=0.0 if bore.axis is None else float(bore.axis.curvature.max()),
    )
