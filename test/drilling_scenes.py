# SPDX-License-Identifier: Apache-2.0
"""Bits that cut, with a memory of the rock: below a spring, and below a kilometre of pipe in a block. SI."""

import math
from typing import Any

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

INERTIA, SPRING, MASS = 116.0, 938.0, 34e3
"""Of bit and string in one [kg m2], of the string [N m/rad], and [kg]."""
ENERGY, RADIUS, THRUST, FRICTION, STRENGTH, BLADES = 60e6, 0.108, 0.6, 0.6, 60e6, 4
AXIAL = THRUST * ENERGY * RADIUS
"""Weight per depth of cut [N/m]."""
TURNING = 0.5 * ENERGY * RADIUS**2
"""Torque per depth of cut [N]."""
DEPTH = 2e-3
LENGTH, DIAMETER = 0.1, 0.03


def rig(rig: dict[str, Any]) -> Scene:
    """A kilometre of pipe in the block, above a sharp regenerative bit, in a vertical hole."""
    return Scene.model_validate({
        "name": "block",
        "string": {
            "sections": [{
                "length": 1000.0, "outer_diameter": 0.127, "inner_diameter": 0.1086,
                "youngs_modulus": 206e9, "poisson_ratio": 0.3, "density": 7850.0,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.15},
        "rig": {"duration": 100.0, **rig},
        "effects": {
            "gravity": {"magnitude": 9.81}, "stretch": {}, "torsion": {},
            "internal_damping": {"bending_time": 1e-2, "stretch_time": 2e-2, "torsion_time": 1e-2},
            "bit_regenerative": {"radius": RADIUS, "specific_energy": ENERGY, "thrust": THRUST, "blades": BLADES},
        },
        "numerics": {"elements": 20, "step": 5e-3},
    })  # fmt: skip


def scene(worn: float, speed: float, step: float, *, inertia: float = INERTIA, regeneration: bool = True) -> Scene:
    """The bit below a short light rod, the spring; it cuts 2 mm a turn, and its wear flats carry `worn` [N]."""
    shear = SPRING * LENGTH / (math.pi / 32.0 * DIAMETER**4)
    weight = AXIAL * DEPTH + worn
    return Scene.model_validate({
        "name": "bit_on_spring",
        "string": {
            "sections": [{
                "length": LENGTH, "outer_diameter": DIAMETER, "inner_diameter": 0.0,
                "youngs_modulus": 2.6 * shear, "poisson_ratio": 0.3, "density": 1.0,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.2},
        "rig": {
            "weight_on_bit": {"shape": "step", "initial": weight, "value": weight, "at": "top"},
            "rotation": {"value": speed},
            "duration": 60.0,
        },
        "effects": {
            "stretch": {}, "torsion": {}, "bit_mass": {"mass": MASS, "inertia": inertia},
            "bit_regenerative": {
                "radius": RADIUS, "blades": BLADES, "specific_energy": ENERGY, "thrust": THRUST, "friction": FRICTION,
                "wear": worn / (RADIUS * STRENGTH), "contact_strength": STRENGTH, "regeneration": regeneration,
            },
        },
        "numerics": {"elements": 4, "step": step, "tolerance": 1e-9},
    })  # fmt: skip


def drilling(worn: float, speed: float, step: float, kick: float, **more: Any) -> tuple[Twin, Command]:
    """A twin in steady drilling, its rate of penetration larger by a share."""
    twin = Twin(scene(worn, speed, step, **more))
    command = Command(AXIAL * DEPTH + worn, speed)
    u, v = (rows.copy() for rows in twin.unknowns)
    u[:, 6] = twin.rod.arc / LENGTH * (TURNING * DEPTH + 0.5 * FRICTION * RADIUS * worn) / SPRING
    v[:, 6], v[:, 2] = speed, -(1.0 + kick) * speed * DEPTH / math.tau
    twin.dynamics.begin(u, v, command)
    return twin, command
