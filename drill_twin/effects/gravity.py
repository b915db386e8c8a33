# SPDX-License-Identifier: Apache-2.0
"""Gravity along the plumb line, less buoyancy; the hole may be inclined to it (`hole.inclination`)."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.effects.mud import displaced_area
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.point import Point
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Acceleration, Within


class Gravity(Block):
    """Weight of the string, buoyant where `mud` is listed: (m - rho A) g with the cross-section A that displaces mud.

    Axial forces and hookload are then the effective ones (Sparks 1984): they count the pressure of the mud.
    """

    work = "kept"

    magnitude: Annotated[
        Acceleration, Within(at_least="0 m/s^2", at_most="1000 m/s^2", reason="a hundred times that of the Earth")
    ] = 9.81
    """Acceleration of free fall, downwards [m/s^2]."""


class Parameters(NamedTuple):
    """Weight per length in the hole's frame [N/m], shape (2 n, 3)."""

    weight: Array


def line_weight(block: Gravity, site: Site) -> Array:
    """Weight per length less buoyancy (m - rho A) g, by element [N/m], shape (n,); negative where the string floats."""
    weight: Array = block.magnitude * (site.rod.line_mass - site.fluid_density * displaced_area(site))
    return weight


def parameters(block: Gravity, site: Site) -> Parameters:
    """Weight of the string at each Gauss point; the low side of an inclined hole is +x."""
    direction = np.array([np.sin(site.inclination), 0.0, -np.cos(site.inclination)])
    return Parameters(site.at_places(line_weight(block, site))[:, None] * direction)


@kernel
def point(parameters: Any, rod: Rod, here: Point, h2: float, load: Array, stiff: Array) -> None:
    """Weight: a constant force per length."""
    load[0] += parameters.gravity.weight[here.place, 0]
    load[1] += parameters.gravity.weight[here.place, 1]
    load[2] += parameters.gravity.weight[here.place, 2]
