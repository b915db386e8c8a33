# SPDX-License-Identifier: Apache-2.0
"""Initial bow: a stress-free curvature fixed in the material, which turns with the spin."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.section import COUPLE, MX, MY, MZ, Strain
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Angle, Length, Within


class Bow(Block):
    """A string that is not straight when at rest; the seed from which buckling and whirl grow."""

    amplitude: Annotated[Length, Within(at_least="0 m", at_most="10 m")]
    """Deflection of the stress-free string off the straight line at mid-span [m]; below the clearance."""
    shape: Literal["half_wave", "uniform"] = "half_wave"
    """`half_wave`: one half sine over the length; `uniform`: constant curvature."""
    angle: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg")] = 0.0
    """Direction of the bow in the material, from the spin's zero [rad]."""


class Parameters(NamedTuple):
    """EI times the stress-free curvature [N m], shape (2 n,), and its direction in the material [rad]."""

    moment: Array
    angle: float


def parameters(block: Bow, site: Site) -> Parameters:
    """Curvature of a half sine wave or an arc with the block's height at mid-span."""
    length = site.string_length
    if block.shape == "half_wave":
        curvature = -block.amplitude * (np.pi / length) ** 2 * np.sin(np.pi * site.places / length)
    else:
        curvature = np.full(site.places.shape, -8.0 * block.amplitude / length**2)
    return Parameters(site.at_places(site.rod.bending) * curvature, block.angle)


@kernel
def section(parameters: Any, rod: Rod, strain: Strain, h2: float, resultants: Array) -> None:
    """Moment EI (q - q_0) with q_0 fixed in the material: the smallest turn of z onto t, then the spin."""
    moment = parameters.bow.moment[strain.place]
    angle = strain.psi + parameters.bow.angle
    cx, cy = moment * np.cos(angle), moment * np.sin(angle)
    along = (cx * strain.tx + cy * strain.ty) / (1.0 + strain.tz)
    mx, my, mz = cx - strain.tx * along, cy - strain.ty * along, -(cx * strain.tx + cy * strain.ty)
    resultants[MX] -= mx
    resultants[MY] -= my
    resultants[MZ] -= mz
    # m . (t x q_0) with m = EI (q - q_0), and t x q_0 is normal to q_0
    resultants[COUPLE] += -(mx * strain.px + my * strain.py + mz * strain.pz)
