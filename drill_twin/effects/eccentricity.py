# SPDX-License-Identifier: Apache-2.0
"""Imbalance: the mass centre of each cross-section lies off the centre line and turns with the spin."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.point import Point
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Angle, Length, Within


class Eccentricity(Block):
    """Mass eccentricity, the same along the string."""

    offset: Annotated[Length, Within(at_least="0 m", at_most="1 m")]
    """Distance of the mass centre from the centre line [m]; below the outer radius."""
    angle: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg")] = 0.0
    """Direction of the mass centre in the material, from the spin's zero [rad]."""


class Parameters(NamedTuple):
    """Mass per length times offset of the mass centre [kg], shape (2 n,), and its angle in the material [rad]."""

    imbalance: Array
    angle: float


def parameters(block: Eccentricity, site: Site) -> Parameters:
    """The same offset along the whole string."""
    return Parameters(site.at_places(site.rod.line_mass) * block.offset, block.angle)


@kernel
def point(parameters: Any, rod: Rod, here: Point, h2: float, load: Array, stiff: Array) -> None:
    """Centrifugal force m e Omega^2 of the turning mass centre (Genta 2005, Jeffcott rotor)."""
    angle = here.spin + parameters.eccentricity.angle
    force = parameters.eccentricity.imbalance[here.place] * here.spin_rate * here.spin_rate
    load[0] += force * np.cos(angle)
    load[1] += force * np.sin(angle)
