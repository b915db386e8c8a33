# SPDX-License-Identifier: Apache-2.0
"""Scenes of the paper's rod with few effects: names of the exact checks, and what only tests need."""

from math import pi
from typing import Any

from drill_twin.scene import Scene
from drill_twin_evidence.verify import scenes as cases
from drill_twin_evidence.verify.scenes import (
    DENSITY,
    DIAMETER,
    EA,
    EI,
    FIRST,
    LENGTH,
    LINE_MASS,
    ROLLING,
    SHEAR,
    YOUNG,
    quiet_scene,
    rod_scene,
)
from drill_twin_evidence.verify.signals import AT_REST, first_mode

__all__ = [
    "AT_REST",
    "DENSITY",
    "DIAMETER",
    "EA",
    "EI",
    "EULER_LOAD",
    "FATIGUE",
    "FIRST",
    "LENGTH",
    "LINE_MASS",
    "ROLLING",
    "SHEAR",
    "STRESSED",
    "WALLED",
    "YOUNG",
    "first_mode",
    "in_equilibrium",
    "quiet_scene",
    "rod_scene",
]

EULER_LOAD = 4.0 * pi**2 * EI / LENGTH**2
"""Between clamps [N]."""
FATIGUE: dict[str, Any] = {
    "sections": [{"name": "middle", "distance_from_bit": 0.5 * LENGTH}],
    "line": {"stress_range": 1e6, "slope": 3.0}, "mean_stress": "none", "smallest_range": 1e4,
}  # fmt: skip
WALLED = {**cases.WALLED, "bit_friction": {"coefficient": 0.0, "radius": 1e-9}}
"""The effects of pa6_bench, so that the kernel of that scene serves all tests with a wall; the bit has no friction."""
STRESSED = {**WALLED, "fatigue": FATIGUE}
"""Set of effects with a wall, and the stress at mid-span."""


def in_equilibrium(scene: Scene) -> Scene:
    """The scene with its string in static equilibrium at time zero."""
    return scene.model_copy(update={"rig": scene.rig.model_copy(update={"start": "equilibrium"})})
