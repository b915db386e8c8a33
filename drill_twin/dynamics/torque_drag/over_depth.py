# SPDX-License-Identifier: Apache-2.0
"""Hookload and torque of the soft string over the depth of its bit, for several coefficients of friction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.torque_drag.analysis import hole_and_string, steady
from drill_twin.dynamics.torque_drag.soft_string import Operation, operations, soft_string
from drill_twin.scene import Scene

OWN = 1e-12
"""Difference from the coefficient of the law from which an interval has its own."""


@dataclass(frozen=True, eq=False)
class OverDepth:
    """Loads at the surface; o operations, f coefficients, d depths."""

    scene: Scene
    depth: Array
    """Measured depth of the bit [m], shape (d,)."""
    friction: Array
    """Coefficients, shape (f,)."""
    operations: tuple[Operation, ...]
    """Trip out, trip in, off bottom."""
    hookload: Array
    """[N], shape (o, f, d)."""
    torque: Array
    """While it rotates off bottom [N m], shape (f, d)."""

    def friction_of(self, load: str, depth: Array, measured: Array) -> Array:
        """Coefficients of friction at which the loads at the surface are the measured loads, shape (p,).

        Args:
            load: Name of an operation, whose hookload is measured [N], or `torque`, off bottom [N m].
            depth: Measured depths of the bit [m], shape (p,).
            measured: Measured loads, shape (p,).

        Returns:
            NaN where no coefficient of the range gives the load.
        """
        names = [operation.name for operation in self.operations]
        rows = self.torque if load == "torque" else self.hookload[names.index(load)]
        found = np.full(depth.shape, math.nan)
        for k, (place, value) in enumerate(zip(depth.tolist(), measured.tolist(), strict=True)):
            loads = np.array([np.interp(place, self.depth, row) for row in rows])
            order = np.argsort(loads)
            found[k] = np.interp(value, loads[order], self.friction[order], left=math.nan, right=math.nan)
        return found


def over_depth(scene: Scene, friction: Sequence[float], depths: int) -> OverDepth:
    """Loads of the lower part of a string whose bit is on its way down.

    Args:
        scene: The scene; elements given or `auto`.
        friction: Coefficients on the wall; an interval with a coefficient of its own, such as a casing, keeps its own.
        depths: Number of depths, evenly spaced down to the depth of the scene.
    """
    equations = EquationsOfMotion(steady(scene))
    law = getattr(scene.effects, "wall_friction", None)
    depth, coefficients = np.linspace(0.0, scene.length, depths + 1)[1:], np.asarray(friction, float)
    wanted = tuple(operations(0.0, 1.0))
    hookload = np.empty((len(wanted), coefficients.size, depths))
    torque = np.empty((coefficients.size, depths))
    for d, bit in enumerate(depth.tolist()):
        string = hole_and_string(equations.scene, equations.model, bit)
        own = np.zeros(string.length.size, bool) if law is None else abs(string.friction - law.coefficient) > OWN
        for f, coefficient in enumerate(coefficients.tolist()):
            rubbing = string._replace(friction=np.where(own, string.friction, coefficient))
            for o, operation in enumerate(wanted):
                loads = soft_string(rubbing, operation)
                hookload[o, f, d] = loads.hookload
                if operation.rotation:
                    torque[f, d] = loads.surface_torque
    return OverDepth(scene, depth, coefficients, wanted, hookload, torque)
