# SPDX-License-Identifier: Apache-2.0
"""Scenes whose ends matter: another rig, another bit end, other sections. Plain numbers are SI."""

from typing import Any

from drill_twin.scene import Scene, load_scene


def with_rig(scene: Scene, **parts: Any) -> Scene:
    """The scene with parts of its rig replaced."""
    data = scene.model_dump(exclude_none=True)
    data["rig"] |= parts
    return Scene.model_validate(data)


def two_mass(weight_on_bit: float) -> Scene:
    """The installed two-mass scene under a weight on bit [N]."""
    return load_scene("two_mass", overrides={"wob": f"{weight_on_bit} N"})


def steel(effects: dict[str, Any], *, at: str = "bit", weight_on_bit: float = 0.0, step: float = 1e-3) -> Scene:
    """A short stiff steel pipe above a drill bit, turned at a constant rate."""
    return Scene.model_validate({
        "name": "steel",
        "string": {
            "sections": [{
                "length": 10.0, "outer_diameter": 0.2, "inner_diameter": 0.1,
                "youngs_modulus": 210e9, "poisson_ratio": 0.3, "density": 7850.0,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.2},
        "rig": {
            "weight_on_bit": {"shape": "step", "initial": weight_on_bit, "value": weight_on_bit, "at": at},
            "rotation": {"value": 10.0},
            "duration": 10.0,
        },
        "effects": {
            "stretch": {}, "torsion": {},
            "internal_damping": {"bending_time": 1e-3, "stretch_time": 2e-3, "torsion_time": 2e-3}, **effects,
        },
        "numerics": {"elements": 8, "step": step},
    })  # fmt: skip
