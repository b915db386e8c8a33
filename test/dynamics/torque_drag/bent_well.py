# SPDX-License-Identifier: Apache-2.0
"""A well of a steel pipe in a bend; its set of effects is that of the exact checks."""

import math

from rod_scenes import WALLED, rod_scene

from drill_twin.scene import Scene

PIPE = {
    "name": "pipe", "length": 900.0, "outer_diameter": 0.127, "inner_diameter": 0.1086, "youngs_modulus": 206e9,
    "poisson_ratio": 0.3, "density": 7850.0, "yield_strength": 724e6, "make_up_torque": 30e3,
}  # fmt: skip
COLLAR = PIPE | {
    "name": "collar", "length": 90.0, "outer_diameter": 0.2032, "inner_diameter": 0.0714, "make_up_torque": 60e3,
}  # fmt: skip
STABILISER = COLLAR | {"name": "stabiliser", "length": 10.0, "blade_diameter": 0.308}


def well(
    friction: float = 0.25, sections: tuple[dict[str, object], ...] = (STABILISER, COLLAR, PIPE), **changes: object
) -> Scene:
    """Build to 60 deg between 200 and 600 m of 1,000 m."""
    stations = ((0.0, 0.0), (200.0, 0.0), (600.0, 60.0), (1000.0, 60.0))
    scene = rod_scene(
        effects=WALLED | {
            "gravity": {"magnitude": 9.81}, "wall": {"stiffness": 1e9}, "wall_friction": {"coefficient": friction},
        },
        sections=sections, elements=200, weight_on_bit=50e3, bit_end="pinned", marks=(30.0,), step=5e-3,
        hole={"radius": 0.1556, "survey": [
            {"depth": depth, "inclination": math.radians(angle), "azimuth": 0.5} for depth, angle in stations
        ]},
    )  # fmt: skip
    turn = scene.rig.rotation.model_copy(update={"value": 10.0})
    return scene.model_copy(update={"rig": scene.rig.model_copy(update={"rotation": turn}), **changes})
