# SPDX-License-Identifier: Apache-2.0
"""Friction from which a string that slides along the wall may come to roll on it."""

from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl.criteria import CONTACT_RADIUS
from drill_twin_studies.maps.regimes import OFF_AXIS, Regime

FRICTION = "effects.wall_friction.coefficient"
_INSIDE = 1.0 - 1e-6
"""Radius over the clearance at which the forces are taken: no wall touches."""


class RollingFriction:
    """Comparison of the wall friction with what rolling needs, at the mark with the largest radius.

    A string that rolls turns about the axis at -r / c times its rotation, r its contact radius and c its clearance. The
    wall carries its mass times acceleration N, and friction carries the drag T: rolling exists as a state where the
    coefficient is T / N or more (own derivation: a rigid string, moved to the wall as a whole). The stiffness that
    would lift it off the wall is left out, since the string lies there already. So the test is necessary for rolling,
    and does not say that rolling begins, or when.
    """

    def __init__(self, scene: Scene) -> None:
        """Take a scene."""
        self._scene = scene
        self._equations: EquationsOfMotion | None = None
        self.vertical = not scene.hole.survey and scene.hole.inclination == 0.0
        """The hole is straight and vertical, so that a string off its axis is bent by its load."""

    def suffices(self, regime: Regime, radius_shares: Array, speed: float, values: Mapping[str, float | str]) -> bool:
        """True if a string that creeps, or is buckled and touches the wall, may come to roll.

        Args:
            regime: Its motion at the end of a run.
            radius_shares: Largest radius of each mark over its clearance, shape (m,).
            speed: Rotation [rad/s].
            values: Values of the uncertain numbers of the run by key.
        """
        touches = regime is Regime.CREEPING or float(radius_shares.max()) > CONTACT_RADIUS
        friction = float(values.get(FRICTION, number_at(self._scene, FRICTION) or 0.0))
        if regime not in OFF_AXIS or not touches or friction <= 0.0:
            return False
        return friction >= self.needed(int(np.argmax(radius_shares)), speed)

    def needed(self, mark: int, speed: float) -> float:
        """Coefficient that rolling needs at a mark; 0, nothing known, in a hole that is not straight and vertical.

        Args:
            mark: Number of the mark.
            speed: Rotation [rad/s].
        """
        if not self.vertical:
            return 0.0
        try:
            equations = self._equations = self._equations or EquationsOfMotion(self._scene)
        except DrillTwinError:  # an effect that depends on time
            return 0.0
        model, command = equations.model, Command(0.0, speed)
        arc = np.concatenate(([0.0], np.cumsum(model.rod.length)))
        node = int(np.argmin(np.abs(arc - self._scene.mark_table[mark].distance_from_bit)[1:-1])) + 1
        clearance, radius = float(model.wellbore.clearance[2 * node]), float(model.contact_radius[2 * node])
        u, _ = equations.on_axis(command)
        u[:, 0] += _INSIDE * clearance
        turns = SteadyWhirl(command, u, -speed * radius / clearance)
        outward, along = equations.rows(equations.evaluate(command, *turns.motion).residual)[node, :2]
        return abs(along / outward) if outward else 0.0
