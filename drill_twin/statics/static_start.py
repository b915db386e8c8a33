# SPDX-License-Identifier: Apache-2.0
"""A run that begins in balance: the loaded shape at rest, then wound up and turning as one (`rig.start: equilibrium`).

Friction, torque of the rock and whatever shakes the string have no part in the shape; what it takes to turn the string
as it lies winds it up. A buckled string that turns in a straight vertical hole has no balance at all: its way from here
into whirl is the run's business.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import sections_of
from drill_twin.discretisation.initial_state import axial_weight
from drill_twin.discretisation.resolution import growth_time
from drill_twin.errors import RunError
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import SPIN
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.statics.static_equilibrium import StringAtRest, settle, torques, wind_up

SMALLEST_LOAD = 1e-3  # by which the balance of a string without weight or load is judged [N]
TOLERANCE = 1e-6  # of Newton's method while the balance is sought, as the scene's own
INSTANT = 1e-3  # of the time that a torsional wave takes through an element


class Turning(StringAtRest, Protocol):
    """Dynamics at their first instant (`drill_twin.twin.dynamics.Dynamics`)."""

    scene: Scene
    model: DiscreteModel

    def begin(self, u: Array, v: Array, command: Command) -> None:
        """Take up a state."""

    def advance(self, target: Array, seconds: float) -> bool:
        """Move on; False where that fails."""


def at_rest(scene: Scene) -> Scene:
    """The scene with its load on and nothing that turns, shakes or rubs, starting from the axis."""
    rig, effects = scene.rig, scene.effects
    stilled = {
        key: block.model_copy(update=dict.fromkeys(block.disabled_for_static, 0.0))
        for key, block in effects.blocks.items()
        if block.disabled_for_static
    }
    weight = rig.weight_on_bit.model_copy(update={"initial": rig.weight_on_bit.value})
    turn = rig.rotation.model_copy(update={"initial": 0.0, "value": 0.0})
    still = rig.model_copy(update={"weight_on_bit": weight, "rotation": turn, "start": "axis"})
    numerics = scene.numerics.model_copy(update={"tolerance": min(scene.tolerance, TOLERANCE)})
    return scene.model_copy(
        update={"rig": still, "effects": effects.model_copy(update=stilled), "numerics": numerics},
    )


def turning(scene: Scene) -> Scene:
    """The scene at its final set-points from the first instant, as its string is wound up, starting from the axis."""
    rig = scene.rig
    points = {key: getattr(rig, key) for key in ("weight_on_bit", "rotation")}
    begun = {key: point.model_copy(update={"initial": point.value}) for key, point in points.items()}
    return scene.model_copy(update={"rig": rig.model_copy(update={**begun, "start": "axis"})})


def start_in_equilibrium(dynamics: Turning, make: Callable[[Scene], Turning]) -> None:
    """Put the dynamics into static balance under its first command, turning as one.

    Args:
        dynamics: The dynamics at its first instant.
        make: Makes a dynamics of a scene.

    Raises:
        RunError: There is no balance, or none was found.
    """
    scene = dynamics.scene
    weight, rotation = scene.rig.first
    hanging = float(np.abs(axial_weight(scene, dynamics.model)).sum())
    growth = growth_time(sections_of(scene), max(abs(weight), 1.0))
    still = make(at_rest(scene))
    settle(still, growth, max(abs(weight), hanging, SMALLEST_LOAD), scene.numerics.seed)
    u, v = still.unknowns
    v[:, SPIN] = rotation
    command = Command(weight, rotation)
    if scene.effects.torsion is not None:
        u[:, SPIN] += _wound_up(make(turning(scene)), u, v, command)
    dynamics.begin(u, v, command)


def _wound_up(dynamics: Turning, u: Array, v: Array, command: Command) -> Array:
    """Spin by which the torques on the turning string twist it [rad]: in an instant they show as acceleration."""
    rod = dynamics.rod
    waves = np.sqrt(rod.torsion * rod.length / rod.spin_mass)
    instant = INSTANT * float((rod.length / waves).min())
    dynamics.begin(u, v, command)
    if not dynamics.advance(np.array([command.weight_on_bit, command.rotation]), instant):
        raise RunError(
            "rig.start: expected a turning string that can be followed for an instant, found no solution of "
            "its equations. Start from the axis instead (rig.start: axis)"
        )
    acceleration = (dynamics.unknowns[1][:, SPIN] - v[:, SPIN]) / instant
    torque = torques(rod, acceleration)
    body = dynamics.scene.effects.bit_mass
    if body is not None:
        torque[0] += body.inertia * acceleration[0]
    return wind_up(rod, torque)
