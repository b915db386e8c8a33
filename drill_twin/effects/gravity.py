# SPDX-License-Identifier: Apache-2.0
"""Gravity along the plumb line; the hole may be inclined to it (`hole.inclination`)."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.point import Point
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Acceleration, Within


class Gravity(Block):
    """Weight of the string."""

    magnitude: Annotated[Acceleration, Within(at_least="0 m/s^2", at_most="1000 m/s^2")] = 9.81
    """Acceleration of free fall, downwards [m/s^2]."""


class Parameters(NamedTuple):
    """Weight per length in the hole's frame [N/m], shape (2 n, 3)."""

    weight: Array


def parameters(block: Gravity, site: Site) -> Parameters:
    """Weight of the string at each Gauss point; the low side of an inclined hole is +x."""
    direction = np.array([np.sin(site.inclination), 0.0, -np.cos(site.inclination)])
    return Parameters(block.magnitude * site.at_places(site.rod.line_mass)[:, None] * direction)


@kernel
def point(parameters: Any, rod: Rod, here: Point, h2: float, load: Array, stiff: Array) -> None:
    """Weight: a constant force per length."""
    load[0] += parameters.gravity.weight[here.place, 0]
    load[1] += parameters.gravity.weight[here.place, 1]
    load[2] += parameters.gravity.weight[here.place, 2]
