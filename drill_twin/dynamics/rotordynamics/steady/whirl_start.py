# SPDX-License-Identifier: Apache-2.0
"""Initial state of `rig.start: whirl-state`: a steady whirl under the final set-points."""

from __future__ import annotations

import math

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.whirl_states import whirl_states
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command


def start_in_whirl(scene: Scene) -> tuple[Array, Array, Command]:
    """Position and velocity of the steady whirl whose disturbances decay fastest, or grow slowest, and its command.

    Raises:
        SceneError: No steady whirl can exist in the scene.
        RunError: None was found.
    """
    weight, rotation = scene.rig.first
    states = whirl_states(EquationsOfMotion(scene), Command(weight, rotation))
    if not states:
        raise RunError(
            f"{scene.name}: rig.start: expected a steady whirl at {weight:g} N and {rotation / math.tau:g} rev/s, "
            "found none; start from the axis instead (rig.start: axis)"
        )
    whirl = min(states, key=lambda state: state.growth).whirl
    u, v, _ = whirl.motion
    return u, v, whirl.command
