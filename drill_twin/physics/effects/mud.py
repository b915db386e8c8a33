# SPDX-License-Identifier: Apache-2.0
"""Properties of the mud, for buoyancy, added mass and drag."""

from typing import Annotated, Literal

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.units import Density, Viscosity, Within
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.model import DiscreteModel


class Mud(EffectConfig):
    """Drilling fluid at rest around the string; `gravity` becomes buoyant, drag and added mass are separate effects."""

    density: Annotated[
        Density, Within(above="0 kg/m^3", at_most="4000 kg/m^3", reason="the heaviest muds have 2700; air has 1.2")
    ]
    """Density [kg/m^3]."""
    viscosity: Annotated[Viscosity, Within(at_least="0 Pa s", at_most="10 Pa s", reason="honey has 10")] = 0.0
    """Dynamic viscosity, taken as Newtonian [Pa s]; `rotation_drag` needs it."""
    inside: Literal["mud", "air"] = "mud"
    """Content of the pipe: `mud`, which follows its lateral motion, or `air`, without mass."""


def bore_radius(model: DiscreteModel) -> Array:
    """Inner radius of each element [m], shape (n,), from r_i^2 + r_o^2 = 4 EI / EA of a circular tube."""
    rod = model.rod
    square = 4.0 * rod.bending / rod.axial - rod.outer_radius**2
    return np.sqrt(np.where(square > 1e-12 * rod.outer_radius**2, square, 0.0))


def hole_radius(model: DiscreteModel) -> Array:
    """Radius of the hole at the Gauss points [m], shape (2 n,)."""
    return np.asarray(model.wellbore.clearance + model.contact_radius)


def displaced_area(model: DiscreteModel) -> Array:
    """Area of mud displaced by each element [m^2], shape (n,): its ring, or the full circle with air inside.

    The pressure on inner wall, outer wall and shoulders adds up to this buoyancy and makes the axial force the
    effective one, T - p_i A_i + p_o A_o, which governs bending and buckling (Sparks 1984).
    """
    if model.fluid_density == 0.0:
        return np.zeros_like(model.rod.length)
    inside = bore_radius(model) if model.fluid_inside else np.zeros_like(model.rod.length)
    return np.asarray(np.pi * (model.rod.outer_radius**2 - inside**2) + model.joint_area)
