# SPDX-License-Identifier: Apache-2.0
"""Gravity along the vertical, less buoyancy; the hole may be inclined (`hole.inclination`)."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Acceleration, Within
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.effects.mud import displaced_area
from drill_twin.physics.model import DiscreteModel, Point, Rod


class Gravity(EffectConfig):
    """Weight of the string, buoyant if `mud` is listed: (m - rho A) g with the cross-section A that displaces mud.

    Axial forces and hookload are then effective forces (Sparks 1984), which include the pressure of the mud.
    """

    energy_class = "kept"

    magnitude: Annotated[
        Acceleration, Within(at_least="0 m/s^2", at_most="1000 m/s^2", reason="a hundred times the Earth's")
    ] = 9.81
    """Acceleration of free fall, downwards [m/s^2]."""


class Parameters(NamedTuple):
    """Weight per length in the hole's frame [N/m], shape (2 n, 3)."""

    weight: Array


def line_weight(block: Gravity, model: DiscreteModel, *, is_lumped: bool = True) -> Array:
    """Weight per length less buoyancy (m - rho A) g, by element [N/m], shape (n,); negative if the string floats.

    `is_lumped` adds the weight of a disc to the element below it, for the tension above it.
    """
    line = np.asarray(block.magnitude * (model.rod.line_mass - model.fluid_density * displaced_area(model)))
    if is_lumped and model.bodies is not None:
        below = np.maximum(model.bodies.node - 1, 0)
        np.add.at(line, below, model.bodies.weight / model.rod.length[below])
    return line


def parameters(block: Gravity, model: DiscreteModel) -> Parameters:
    """Compute the weight at the Gauss points; the low side of an inclined hole is +x."""
    direction = np.array([np.sin(model.inclination), 0.0, -np.cos(model.inclination)])
    return Parameters(model.at_places(line_weight(block, model, is_lumped=False))[:, None] * direction)


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the weight, a constant force per length."""
    load[0] += parameters.gravity.weight[here.place, 0]
    load[1] += parameters.gravity.weight[here.place, 1]
    load[2] += parameters.gravity.weight[here.place, 2]
