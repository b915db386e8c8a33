# SPDX-License-Identifier: Apache-2.0
"""Largest growth rate of the string on the axis over weight on bit and speed: onset of whirl and of stick-slip."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, delayed_modes, eigenvalues, undamped_basis
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import balance, bit_unknowns, is_vertical
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame
from drill_twin.scene.set_points.command import Command

BASIS = 8
"""Undamped modes in which a point of the map is computed."""


class GrowthMap(NamedTuple):
    """Growth rates over a grid of w loads and p speeds."""

    weights: Array
    """Weight on bit [N], shape (w,)."""
    speeds: Array
    """Speed of rotation [rad/s], shape (p,)."""
    lateral: Array
    """Largest growth of a lateral mode [1/s], shape (w, p)."""
    torsional: Array | None
    """Largest growth of a motion about or along the axis [1/s], shape (w, p); None in the lateral form."""

    def onset(self, growth: Array) -> Array:
        """Least load from which the growth is above zero, at each speed [N], shape (p,); NaN where it never is."""
        return np.array([_first_crossing(self.weights, column) for column in growth.T])


def _first_crossing(weights: Array, growth: Array) -> float:
    above = np.flatnonzero(growth > 0.0)
    if not above.size:
        return float("nan")
    k = int(above[0])
    if k == 0:
        return float(weights[0])
    share = growth[k - 1] / (growth[k - 1] - growth[k])
    return float(weights[k - 1] + share * (weights[k] - weights[k - 1]))


def growth_map(
    equations: EquationsOfMotion,
    weights: Array,
    speeds: Array,
    progress: Callable[[int], None] | None = None,
) -> GrowthMap:
    """Compute the map on a basis of undamped modes of each load.

    Args:
        equations: Of a scene with a straight vertical hole.
        weights: Weight on bit [N], shape (w,), in order.
        speeds: [rad/s], shape (p,), in order.
        progress: Called with the number of rows done.

    Raises:
        RunError: The hole is not vertical, or there is no balance.
    """
    if not is_vertical(equations):
        raise RunError(
            f"{equations.scene.name}: expected a straight vertical hole, in which the string can turn on the axis, "
            "found an inclined or curved one: on its low side there is no single threshold to map"
        )
    frame = TurningFrame(equations)
    part = np.ix_(frame.rest, frame.rest)
    lateral = np.zeros((weights.size, speeds.size))
    torsional = np.zeros_like(lateral) if frame.rest.size else None
    for i, weight in enumerate(weights):
        bases: tuple[Array, ...] = ()
        for k, speed in enumerate(speeds):
            command = Command(float(weight), float(speed))
            system, delay = balance(equations, command).system, equations.delay(command)
            whirl = Pencil(*(frame.as_complex(matrix) for matrix in system.matrices))
            about = Pencil(*(matrix[part] for matrix in system.matrices))
            if not bases:
                bases = (undamped_basis(whirl, BASIS, bit_unknowns(equations, frame)),)
                if torsional is not None:
                    bases += (undamped_basis(about, BASIS),)
            lateral[i, k] = eigenvalues(whirl.on(bases[0]))[0].real.max()
            if torsional is not None:
                basis, moving = bases[1], about.on(bases[1])
                delayed = None if delay is None else delay.of(frame.rest).on(basis)
                found = eigenvalues(moving) if delayed is None else delayed_modes(moving, delayed)
                torsional[i, k] = found[0].real.max()
        if progress is not None:
            progress(i + 1)
    return GrowthMap(weights, speeds, lateral, torsional)
