# SPDX-License-Identifier: Apache-2.0
"""Added mass of the mud around and inside the string for lateral motion."""

from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, Within
from drill_twin.physics.effects.config import EffectConfig, Flag
from drill_twin.physics.effects.mud import add_across, bore_radius, lateral_force, resist_across
from drill_twin.physics.model import DiscreteModel, Point, Rod


class AddedMass(EffectConfig):
    """Added mass rho pi (C_a r_o^2 + r_i^2) per length for acceleration across the string; none along it.

    The second term is the mud inside the pipe, where `mud.inside` is `mud`. C_a = 1 is potential flow around a cylinder
    in unbounded fluid (Lamb 1932, art. 68).
    """

    across = True
    requires: ClassVar[tuple[str, ...]] = ("mud",)

    coefficient: Annotated[
        Dimensionless, Within(at_least="0", at_most="100", reason="a cylinder in unbounded fluid has 1")
    ] = 1.0
    """Added-mass coefficient C_a [-]."""
    confined: Flag = False
    """Confinement by the hole: multiplies C_a by Re(H) of viscous flow around a concentric string (Chen, Wambsganss and
    Jendrzejczyk 1976), without viscosity (R^2 + r_o^2) / (R^2 - r_o^2) (Fritz 1972)."""


class Parameters(NamedTuple):
    """Added mass per length [kg/m], shape (2 n,)."""

    mass: Array


def parameters(block: AddedMass, model: DiscreteModel) -> Parameters:
    """Compute the added mass at the Gauss points."""
    outer = model.at_places(model.rod.outer_radius) ** 2
    around = block.coefficient * outer
    if block.confined:
        around = around * lateral_force(model).mass
    inside = model.at_places(bore_radius(model)) ** 2 if model.fluid_inside else np.zeros_like(outer)
    return Parameters(model.fluid_density * np.pi * (around + inside))


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the force -m_a (1 - t t) a."""
    m = parameters.added_mass.mass[here.place]
    resist_across(here, m, here.ax, here.ay, here.az, load)
    add_across(here, m / half_step, stiff)
