# SPDX-License-Identifier: Apache-2.0
"""The effects a scene can call for: one file each, with its scene block and its compiled function."""

from drill_twin.effects.added_mass import AddedMass
from drill_twin.effects.bit_cutting import BitCutting
from drill_twin.effects.bit_friction import BitFriction
from drill_twin.effects.bit_mass import BitMass
from drill_twin.effects.bit_side_force import BitSideForce
from drill_twin.effects.bit_stabiliser import BitStabiliser
from drill_twin.effects.bit_torque_stribeck import BitTorqueStribeck
from drill_twin.effects.bit_torque_tanh import BitTorqueTanh
from drill_twin.effects.block import Block
from drill_twin.effects.bow import Bow
from drill_twin.effects.drag import Drag
from drill_twin.effects.eccentricity import Eccentricity
from drill_twin.effects.gravity import Gravity
from drill_twin.effects.internal_damping import InternalDamping
from drill_twin.effects.lateral_kick import LateralKick
from drill_twin.effects.mud import Mud
from drill_twin.effects.quadratic_drag import QuadraticDrag
from drill_twin.effects.random_force import RandomForce
from drill_twin.effects.rock_floor import RockFloor
from drill_twin.effects.rotation_drag import RotationDrag
from drill_twin.effects.stretch import Stretch
from drill_twin.effects.top_shake import TopShake
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
    "mud": Mud,
    "quadratic_drag": QuadraticDrag,
    "added_mass": AddedMass,
    "rotation_drag": RotationDrag,
    "wall": Wall,
    "wall_friction": WallFriction,
    "rock_floor": RockFloor,
    "bit_cutting": BitCutting,
    "bit_friction": BitFriction,
    "bit_torque_tanh": BitTorqueTanh,
    "bit_torque_stribeck": BitTorqueStribeck,
    "bit_mass": BitMass,
    "bit_stabiliser": BitStabiliser,
    "bit_side_force": BitSideForce,
    "lateral_kick": LateralKick,
    "random_force": RandomForce,
    "top_shake": TopShake,
}
"""Key in a scene file -> block; the order is the order of reports."""

__all__ = [
    "BLOCKS",
    "AddedMass",
    "BitCutting",
    "BitFriction",
    "BitMass",
    "BitSideForce",
    "BitStabiliser",
    "BitTorqueStribeck",
    "BitTorqueTanh",
    "Block",
    "Bow",
    "Drag",
    "Eccentricity",
    "Gravity",
    "InternalDamping",
    "LateralKick",
    "Mud",
    "QuadraticDrag",
    "RandomForce",
    "RockFloor",
    "RotationDrag",
    "Stretch",
    "TopShake",
    "Torsion",
    "Wall",
    "WallFriction",
]
