# SPDX-License-Identifier: Apache-2.0
"""The effects a scene can call for: one file each, with its scene block and its compiled function."""

from drill_twin.effects.bit_friction import BitFriction
from drill_twin.effects.block import Block
from drill_twin.effects.bow import Bow
from drill_twin.effects.drag import Drag
from drill_twin.effects.eccentricity import Eccentricity
from drill_twin.effects.gravity import Gravity
from drill_twin.effects.internal_damping import InternalDamping
from drill_twin.effects.lateral_kick import LateralKick
from drill_twin.effects.stretch import Stretch
from drill_twin.effects.torsion import Torsion
from drill_twin.effects.wall import Wall
from drill_twin.effects.wall_friction import WallFriction

BLOCKS: dict[str, type[Block]] = {
    "gravity": Gravity,
    "stretch": Stretch,
    "torsion": Torsion,
    "bow": Bow,
    "eccentricity": Eccentricity,
    "internal_damping": InternalDamping,
    "drag": Drag,
    "wall": Wall,
    "wall_friction": WallFriction,
    "bit_friction": BitFriction,
    "lateral_kick": LateralKick,
}
"""Key in a scene file -> block; the order is the order of reports."""

__all__ = [
    "BLOCKS",
    "BitFriction",
    "Block",
    "Bow",
    "Drag",
    "Eccentricity",
    "Gravity",
    "InternalDamping",
    "LateralKick",
    "Stretch",
    "Torsion",
    "Wall",
    "WallFriction",
]
