# SPDX-License-Identifier: Apache-2.0
"""Friction from which a string that slides along the wall may come to roll on it."""

from dataclasses import dataclass
from functools import cached_property

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

_INSIDE = 1.0 - 1e-6
"""Radius over the clearance at which forces are taken: no wall touches."""


@dataclass(frozen=True)
class RollingFriction:
    """Wall friction that rolling needs, for a scene.

    A string that rolls turns about the axis at -r / c times its rotation, r its contact radius and c its clearance. The
    wall carries its mass times its acceleration, N, and friction carries the drag on it, T: rolling exists as a state
    where the coefficient is T / N or more (own derivation: a rigid string, moved to the wall as a whole). The stiffness
    that would lift it off the wall is left out, since the string lies there already. So such a coefficient is necessary
    for rolling; it does not say that rolling begins, or when.
    """

    scene: Scene

    @property
    def vertical(self) -> bool:
        """The hole is straight and vertical, so that a string off its axis is bent by its load."""
        return not self.scene.hole.survey and self.scene.hole.inclination == 0.0

    @cached_property
    def _equations(self) -> EquationsOfMotion | None:
        try:
            return EquationsOfMotion(self.scene) if self.vertical else None
        except DrillTwinError:  # an effect that depends on time
            return None

    def ratio(self, mark: int) -> float:
        """Whirl ratio of pure rolling at a mark, without its sign."""
        here = self.scene.mark_table[mark]
        return self.scene.hole.radius_at(self.scene.length - here.distance_from_bit) / here.clearance - 1.0

    def needed(self, mark: int, speed: float) -> float:
        """Coefficient of friction that rolling needs at a mark.

        Args:
            mark: Number of the mark.
            speed: Rotation [rad/s].

        Returns:
            0, nothing known, in a hole that is not straight and vertical, or with an effect that depends on time.
        """
        if self._equations is None:
            return 0.0
        here, equations, command = self.scene.mark_table[mark], self._equations, Command(0.0, speed)
        node = int((equations.model.rod.length.cumsum() < here.distance_from_bit).sum())
        u, _ = equations.on_axis(command)
        u[:, 0] += _INSIDE * here.clearance
        whirl = SteadyWhirl(command, u, -speed * self.ratio(mark))
        outward, along = equations.rows(equations.evaluate(command, *whirl.motion).residual)[max(node, 1), :2]
        return float(abs(along / outward)) if outward else 0.0
