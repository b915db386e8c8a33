# SPDX-License-Identifier: Apache-2.0
"""An initial lateral velocity of the string: a repeatable stand-in for a pluck."""

from typing import Annotated, Literal

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.units import Speed, Within


class LateralKick(Block):
    """Initial velocity in x."""

    velocity: Annotated[Speed, Within(at_least="-100 m/s", at_most="100 m/s", reason="no string is kicked harder")]
    """Velocity at mid-span at time zero [m/s]."""
    shape: Literal["half_wave", "hump"] = "half_wave"
    """`half_wave`: one half sine over the length; `hump`: its square, which suits clamped ends."""


def start(block: LateralKick, site: Site, u: Array, v: Array) -> None:
    """Set the initial velocities of r and r' along x."""
    arc, length = site.rod.arc, site.string_length
    wave = np.pi / length
    if block.shape == "half_wave":
        v[:, 0] += block.velocity * np.sin(wave * arc)
        v[:, 3] += block.velocity * wave * np.cos(wave * arc)
    else:
        v[:, 0] += block.velocity * np.sin(wave * arc) ** 2
        v[:, 3] += block.velocity * wave * np.sin(2.0 * wave * arc)
