# SPDX-License-Identifier: Apache-2.0
"""Codes, names and keys in messages of the contract that more than one package reads or writes."""

import hashlib
import json
from collections.abc import Mapping
from enum import IntEnum

from drill_twin.scene import Scene


class AdviceCode(IntEnum):
    """Codes of `advice` on `/advice/state`."""

    NONE = 0
    """There is none; the sentence in `/diagnostics` says why."""
    HOLD = 1
    """Calm, with margin."""
    NEAR = 2
    """Near a boundary, or a whirl that dies."""
    LEAVE = 3
    """Leave the set-point."""


REGIME_COLOURS = (
    "#009e73", "#b2df8a", "#f0e442", "#56b4e9", "#c7d9f1", "#bdbdbd", "#e69f00", "#d55e00", "#cc79a7", "#333333",
    "#bfa58a", "#a50f15", "#6a3d9a",
)  # fmt: skip
"""Colours of the regimes of `/advice/map`, in the order of its codes (Okabe and Ito 2008, light green and greys; of
creeping brown, of rolling dark red, of impacts violet)."""

SENSORS: Mapping[str, str] = {
    "weight_on_bit": "N",
    "bit_speed": "rad/s",
    "bit_torque": "N m",
    "radius": "m",
    "wall_force": "N",
    "bending_stress": "Pa",
}
"""Virtual sensors of `/estimate/state` and their units: bit, and weight on it, at the end of the window; largest radius
of a mark and largest wall force of a node in the window; largest bending stress at the end of the window."""

_SET_BY_MAP = ("weight_on_bit", "rotation", "duration", "start", "table")


def digest_of(scene: Scene) -> str:
    """Key of a scene in `/advice/map`: hash of the numbers of string, hole, top drive and effects.

    Set-points, names and resolution do not enter the key.
    """
    data = scene.model_dump(mode="json", exclude_none=True)
    rig = {name: value for name, value in data["rig"].items() if name not in _SET_BY_MAP}
    numbers = {"string": data["string"], "hole": data["hole"], "effects": data["effects"], "rig": rig}
    return hashlib.sha256(json.dumps(numbers, sort_keys=True).encode()).hexdigest()
