# SPDX-License-Identifier: Apache-2.0
"""Initial state of `rig.start: equilibrium`: static equilibrium, twisted and in rigid rotation.

Friction, torque of the rock and excitation are left out of the search for the shape; the torques on the string rotating
in this shape then twist it. A rotating buckled string in a straight vertical hole has no equilibrium: its transition to
whirl is part of the run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.discretisation.discretise import sections_of
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.dynamics.discretisation.resolution import growth_time
from drill_twin.dynamics.equilibrium.static_equilibrium import (
    StringAtRest,
    find_equilibrium,
    inertia_torques,
    twist_under,
)
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import SPIN, Rod
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

SMALLEST_LOAD = 1e-3  # reference of the residual force for a string without weight or load [N]
TOLERANCE = 1e-6  # of Newton's method in the search, as `numerics.tolerance`
INSTANT = 1e-3  # over the travel time of a torsional wave through an element


class StartingDynamics(StringAtRest, Protocol):
    """Dynamics at the first instant (`drill_twin.dynamics.twin.dynamics.Dynamics`)."""

    scene: Scene
    model: DiscreteModel

    def begin(self, u: Array, v: Array, command: Command) -> None:
        """Set state and set-points."""

    def advance(self, target: Array, seconds: float) -> bool:
        """Advance by a time [s] to the target set-points; False if that fails."""


def static_scene(scene: Scene) -> Scene:
    """Scene with its load, without rotation, excitation and friction, starting from the axis."""
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


def rotating_scene(scene: Scene) -> Scene:
    """Scene with its final set-points from the first instant, starting from the axis."""
    rig = scene.rig
    points = {key: getattr(rig, key) for key in ("weight_on_bit", "rotation")}
    begun = {key: point.model_copy(update={"initial": point.value}) for key, point in points.items()}
    return scene.model_copy(update={"rig": rig.model_copy(update={**begun, "start": "axis"})})


def start_in_equilibrium(dynamics: StartingDynamics, make: Callable[[Scene, Rod], StartingDynamics]) -> None:
    """Set the dynamics to static equilibrium under the first command, in rigid rotation.

    Args:
        dynamics: Dynamics at the first instant.
        make: Constructor of the dynamics of a scene with a mesh: that of `dynamics`, whatever the set-points.

    Raises:
        RunError: No equilibrium was found.
    """
    scene = dynamics.scene
    weight, rotation = scene.rig.first
    hanging = float(np.abs(axial_weight(scene, dynamics.model)).sum())
    growth = growth_time(sections_of(scene), max(abs(weight), 1.0))
    still = make(static_scene(scene), dynamics.rod)
    find_equilibrium(still, growth, max(abs(weight), hanging, SMALLEST_LOAD), scene.numerics.seed)
    u, v = still.unknowns
    v[:, SPIN] = rotation
    command = Command(weight, rotation)
    if scene.effects.torsion is not None:
        u[:, SPIN] += _static_twist(make(rotating_scene(scene), dynamics.rod), u, v, command)
    dynamics.begin(u, v, command)


def _static_twist(dynamics: StartingDynamics, u: Array, v: Array, command: Command) -> Array:
    """Static twist by the torques on the rotating string [rad], from its acceleration in a short step."""
    rod = dynamics.rod
    waves = np.sqrt(rod.torsion * rod.length / rod.spin_mass)
    instant = INSTANT * float((rod.length / waves).min())
    dynamics.begin(u, v, command)
    if not dynamics.advance(command.array(), instant):
        raise RunError(
            "rig.start: expected a step of the rotating string to converge, found no solution of its equations. "
            "Start from the axis instead (rig.start: axis)"
        )
    acceleration = (dynamics.unknowns[1][:, SPIN] - v[:, SPIN]) / instant
    torque = inertia_torques(rod, acceleration)
    body = dynamics.scene.effects.bit_mass
    if body is not None:
        torque[0] += body.inertia * acceleration[0]
    return twist_under(rod, torque)
