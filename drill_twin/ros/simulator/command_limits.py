# SPDX-License-Identifier: Apache-2.0
"""Limits of commands, from the scene and the parameters."""

from __future__ import annotations

import math

from drill_twin.ros.simulator.command_arbiter import CommandLimits
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import SetPoint

_GENEROUS = 10.0  # times what the scene itself commands
_LEAST_WEIGHT = 100.0  # N
_LEAST_SPEED = 20.0 * math.pi  # rad/s, 10 rev/s
FASTEST = 200.0 * math.pi  # rad/s, 100 rev/s, as in a scene file
_STRAIN = 0.01  # of the weakest section, where the scene only says that a record is played


def limits_for(scene: Scene, *, max_weight_on_bit: float, max_speed: float, negative: bool) -> CommandLimits:
    """The limits of a scene; its own set-points are always within them.

    Args:
        scene: Scene.
        max_weight_on_bit: Largest weight on bit [N]; 0: ten times the scene's largest and at least 100 N, or where a
            record is played what strains the weakest section by 1 %.
        max_speed: Largest top-drive speed [rad/s]; 0: ten times the scene's largest and at least 10 rev/s, or where
            a record is played 100 rev/s.
        negative: Whether tension and left-hand rotation may be commanded although the scene does neither and plays
            no record.
    """
    rig = scene.rig
    weight = max_weight_on_bit or _largest(rig.weight_on_bit, _LEAST_WEIGHT, _strained(scene))
    speed = max_speed or _largest(rig.rotation, _LEAST_SPEED, FASTEST)
    return CommandLimits(
        weight_on_bit=_range(rig.weight_on_bit, weight, negative=negative),
        rotation=_range(rig.rotation, speed, negative=negative),
        block_not_followed=_block_not_followed(scene),
    )


def _block_not_followed(scene: Scene) -> str:
    if scene.rig.block is None:
        return "the scene has no `rig.block`"
    return "the auto-driller moves it" if scene.rig.block.auto_driller else ""


def _largest(planned: SetPoint, least: float, recorded: float) -> float:
    if planned.shape == "table":
        return recorded
    return max(_GENEROUS * abs(planned.value), _GENEROUS * abs(planned.initial), least)


def _strained(scene: Scene) -> float:
    return min(
        _STRAIN * section.youngs_modulus * 0.25 * math.pi * (section.outer_diameter**2 - section.inner_diameter**2)
        for section in scene.string.sections
    )


def _range(planned: SetPoint, largest: float, *, negative: bool) -> tuple[float, float]:
    low, high = min(0.0, planned.value, planned.initial), max(largest, planned.value, planned.initial)
    negative = negative or low < 0.0 or planned.shape == "table"  # a measured standstill wavers around zero
    return (min(low, -largest) if negative else low), high
