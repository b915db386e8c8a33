# SPDX-License-Identifier: Apache-2.0
"""Scenes whose ends matter: another rig, another bit end, other sections. Plain numbers are SI."""

from typing import Any

from drill_twin.scene import Scene, load_scene
from drill_twin_evidence.verify.scenes import steel

__all__ = ["steel", "two_mass", "with_rig"]


def with_rig(scene: Scene, **parts: Any) -> Scene:
    """The scene with parts of its rig replaced."""
    data = scene.model_dump(exclude_none=True)
    data["rig"] |= parts
    return Scene.model_validate(data)


def two_mass(weight_on_bit: float) -> Scene:
    """The installed two-mass scene under a weight on bit [N]."""
    return load_scene("two_mass", overrides={"wob": f"{weight_on_bit} N"})
