# SPDX-License-Identifier: Apache-2.0
"""Contact with the wall of the hole: force per length K d^1.5 on the penetration d, with loss on rebound."""

from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.point import Point
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Dimensionless, HertzStiffness, Speed, Within


class Wall(Block):
    """Hertz contact with the loss of Hunt and Crossley (1975); the exponent is that of the paper's Eq. 11."""

    stiffness: Annotated[HertzStiffness, Within(above="0 N/m^2.5", at_most="1e15 N/m^2.5")]
    """Contact stiffness K per length of string [N/m^2.5]."""
    restitution: Annotated[Dimensionless, Within(above="0", at_most="1")] = 0.5
    """Speed after over speed before an impact at the reference speed [-]; 1 = no loss."""
    reference_speed: Annotated[Speed, Within(above="0 m/s", at_most="100 m/s")] = 0.1
    """Impact speed at which the restitution holds [m/s]."""

    exponent: ClassVar[float] = 1.5
    """Power of the penetration [-]."""


class Parameters(NamedTuple):
    """Wall per Gauss point: clearance [m] and, per metre of string, stiffness [N/m^2.5] and damping factor [s/m]."""

    clearance: Array
    stiffness: float
    damping: float


def parameters(block: Wall, site: Site) -> Parameters:
    """Clearance by section; Hunt and Crossley's damping factor 3/2 (1 - e) / v_0 for restitution e at speed v_0."""
    clearance = site.at_places(site.hole_radius - site.rod.outer_radius)
    return Parameters(clearance, block.stiffness, 1.5 * (1.0 - block.restitution) / block.reference_speed)


@kernel
def press(wall: Parameters, here: Point, h2: float) -> tuple[float, float, float, float, float]:
    """Normal force per length [N/m], its slope by the normal velocity, and the outward normal; zeros off the wall.

    N = K d^1.5 (1 + chi d_dot), not negative (Hertz; Hunt and Crossley 1975). d is the penetration of the string's
    surface into the wall: the paper's Eq. 12 with the condition that its print lost, d > 0.
    """
    square = here.x * here.x + here.y * here.y
    clearance = wall.clearance[here.place]
    if square <= clearance * clearance:
        return 0.0, 0.0, 0.0, 0.0, 1.0
    radius = np.sqrt(square)
    nx, ny = here.x / radius, here.y / radius
    depth = radius - clearance
    root = np.sqrt(depth)
    factor = 1.0 + wall.damping * (nx * here.vx + ny * here.vy)
    if factor <= 0.0:
        return 0.0, 0.0, nx, ny, radius
    hertz = wall.stiffness * depth * root
    slope = h2 * 1.5 * wall.stiffness * root * factor + hertz * wall.damping
    return hertz * factor, slope, nx, ny, radius


@kernel
def point(parameters: Any, rod: Rod, here: Point, h2: float, load: Array, stiff: Array) -> None:
    """Push the string back into the hole."""
    force, slope, nx, ny, radius = press(parameters.wall, here, h2)
    if force > 0.0:
        load[0] -= force * nx
        load[1] -= force * ny
        across = h2 * force / radius
        stiff[0, 0] += slope * nx * nx + across * ny * ny
        stiff[0, 1] += (slope - across) * nx * ny
        stiff[1, 0] += (slope - across) * nx * ny
        stiff[1, 1] += slope * ny * ny + across * nx * nx
