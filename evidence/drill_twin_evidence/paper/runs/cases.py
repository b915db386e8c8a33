# SPDX-License-Identifier: Apache-2.0
"""Cases of the reproduction: loads and speeds of the paper's runs, and the scene of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from drill_twin.scene import Scene


class Case(NamedTuple):
    """One run of the bench."""

    weight_on_bit: float
    """[N]"""
    speed: float
    """[rev/s]"""

    def __str__(self) -> str:
        return f"{self.weight_on_bit:g} N, {self.speed:g} rev/s"

    def keys(self) -> dict[str, float]:
        """Load and speed by their keys in a scene, in SI."""
        return {"rig.weight_on_bit.value": self.weight_on_bit, "rig.rotation.value": self.speed * math.tau}


LOADS = (20.0, 40.0, 60.0, 80.0, 100.0, 150.0, 200.0, 250.0, 300.0)
"""Weights on bit of the paper's Table 2 [N]."""
SPEEDS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 6.5)
"""Speeds of the paper's Table 2 [rev/s]."""
LOAD, SPEED = 40.0, 2.0
"""Load of the sweep over speeds [N], and speed of the sweep over loads [rev/s]."""
REFERENCE = Case(LOAD, SPEED)
DAMPING = tuple(f"effects.internal_damping.{kind}_time" for kind in ("bending", "stretch", "torsion"))
"""Keys of the retardation times, which have one value because the material is one."""
MATRIX = (*(Case(LOAD, speed) for speed in SPEEDS), *(Case(load, SPEED) for load in LOADS if load != LOAD))
"""All cases of the bench, each once."""


def scene_of(scene: Scene, case: Case, changes: Mapping[str, float | str] | None = None) -> Scene:
    """The scene with load and speed of a case, and with other values changed.

    Args:
        scene: The bench.
        case: Load and speed.
        changes: Values in SI by their key in the scene, as `effects.drag.linear`.
    """
    for place, value in {**case.keys(), **(changes or {})}.items():
        scene = changed(scene, place, value)
    return scene


def changed(part: Any, place: str, value: float | str | None) -> Any:
    """A copy of a scene, or of a part of it, with one value changed; `place` as `effects.bow.amplitude`.

    Values are not checked again: a study changes them within bounds of its own.
    """
    name, _, rest = place.partition(".")
    old = getattr(part, name)
    return part.model_copy(update={name: changed(old, rest, value) if rest else value})


def value_at(scene: Scene, place: str) -> Any:
    """The value at a key of a scene."""
    value: Any = scene
    for name in place.split("."):
        value = getattr(value, name)
    return value
