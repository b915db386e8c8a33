# SPDX-License-Identifier: Apache-2.0
"""Growth of small motion under given set-points, and the weight and speed below which it ends, in words."""

from __future__ import annotations

import numpy as np

from drill_twin.api.rotordynamics import held_at, modes, steady_scene
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.rotordynamics.campbell import growth_map
from drill_twin.dynamics.rotordynamics.equations import TIME_DEPENDENT, EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import LATERAL, ModeTable
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command

STEPS = 20
"""Shares of weight or speed at which the end of growth is sought."""


def modes_under(scene: Scene, command: Command) -> ModeTable:
    """Modes of a scene under constant set-points, without effects that depend on time.

    Raises:
        SceneError: The scene has no modes.
        RunError: There is no balance.
    """
    return modes(_held(scene, command))


def buckling(scene: Scene, command: Command) -> str:
    """Sentence that the weight buckles a string on the axis, with a space before it; empty where it does not.

    Raises:
        RunError: There is no balance.
    """
    at_rest = modes_under(scene, Command(command.weight_on_bit, 0.0)).fastest(LATERAL)
    if at_rest is None or at_rest.growth <= 0.0:
        return ""
    return f" The weight buckles the string: without rotation, too, it leaves the axis with {at_rest.growth:.2g} 1/s."


def limits(scene: Scene, command: Command, units: UnitSystem) -> str:
    """Sentence on the largest lower weight and speed at which no lateral mode about the axis grows.

    Raises:
        RunError: The hole is not vertical, or there is no balance.
    """
    equations, shares = EquationsOfMotion(_held(scene, command)), np.arange(1, STEPS + 1) / STEPS
    weight, speed = command.weight_on_bit, command.rotation
    by_weight = growth_map(equations, weight * shares, np.array([speed])).lateral[:, 0]
    by_speed = growth_map(equations, np.array([weight]), speed * shares).lateral[0]
    found = []
    for name, quantity, value, growth in (
        ("weight", "force", weight, by_weight),
        ("speed", "rotation", speed, by_speed),
    ):
        if (quiet := np.flatnonzero(growth <= 0.0)).size:
            found.append(f"when the {name} alone falls to {units.text(value * shares[quiet[-1]], quantity)}")
        else:
            found.append(f"at no lower {name} alone")
    return f"The growth about the axis ends {', and '.join(found)} (sought in steps of {1 / STEPS:.0%})."


def rate(growth: float) -> str:
    """Growth or decay [1/s] in words."""
    return f"grows with {growth:.2g} 1/s" if growth > 0.0 else f"decays with {-growth:.2g} 1/s"


def _held(scene: Scene, command: Command) -> Scene:
    """The scene under constant set-points, without effects that depend on time."""
    left_out = [key for key in scene.effect_names if key in TIME_DEPENDENT]
    return steady_scene(held_at(scene, command), None, left_out)
