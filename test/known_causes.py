# SPDX-License-Identifier: Apache-2.0
"""Ten runs whose cause is known by construction, for the search of causes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rod_scenes import FIRST, ROLLING, WALLED, quiet_scene

from drill_twin.scene import Scene, load_scene
from drill_twin_evidence.verify.contact.regenerative import scene as drag_bit

SOON = {"wob": 5, "rig.weight_on_bit.duration": 2, "rig.rotation.duration": 2}
NO_DAMPING = {"internal_damping": {"bending_time": 0.0}}
BENCH = {"source": "a bench", "lateral_rms": [f"{g} g" for g in (0.01, 0.05, 0.1, 0.2)]}


def two_mass(torque: dict[str, Any], speed: float, duration: float, drive: dict[str, Any] | None = None, **damping: float) -> Scene:
    """Torsion of two masses on the bit's law; the top drive holds its speed where no other is given."""
    scene = load_scene("two_mass")
    data = scene.model_dump(mode="json", exclude_none=True)
    data["effects"].pop("bit_torque_stribeck")
    data["effects"] |= torque
    data["effects"]["bit_mass"]["damping"] = damping.get("bit", 0.0)
    data["effects"]["internal_damping"]["torsion_time"] = damping.get("torsion", 0.05)
    data["rig"] |= {"duration": duration, "top_drive": drive or {"model": "prescribed"}}
    data["rig"]["rotation"] = {"shape": "ramp", "value": speed, "duration": 5.0}
    return Scene.model_validate(data)
