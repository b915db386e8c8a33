# SPDX-License-Identifier: Apache-2.0
"""Campbell diagram: lateral modes over the speed of rotation, followed by their shapes, and critical speeds.

The map of growth rates has the largest of the string on the axis over weight on bit and speed: onset of whirl and of
stick-slip.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.eigenvalues import (
    Pencil,
    damped_modes,
    delayed_modes,
    eigenvalues,
    undamped_basis,
)
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import balance, is_vertical
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

AT_REST = 1e-6
"""Speed over the largest, up to which a string is at rest; chosen: rounding left 1e-26."""
SPARE = 6
"""Modes computed beyond the number asked for, so that no mode is lost where the order of modes changes."""


class Campbell(NamedTuple):
    """Lateral modes over speeds of rotation; p speeds, m modes."""

    scene: Scene
    weight_on_bit: float
    """[N]."""
    speeds: Array
    """Speed of rotation [rad/s], shape (p,)."""
    eigenvalues: ComplexArray
    """Growth [1/s] and frequency [rad/s], positive in the sense of rotation, shape (p, m)."""
    critical: tuple[tuple[int, float], ...]
    """Mode, and speed of rotation [rad/s] that the mode's frequency equals."""


def mac(first: ComplexArray, second: ComplexArray) -> Array:
    """Modal assurance criterion between the columns of two matrices (Allemang 1982), 0 to 1, shape (m, k)."""
    scale = np.outer(np.sum(np.abs(first) ** 2, axis=0), np.sum(np.abs(second) ** 2, axis=0))
    return np.asarray(np.abs(first.conj().T @ second) ** 2 / np.maximum(scale, 1e-300))


def campbell(
    equations: EquationsOfMotion, weight_on_bit: float, speeds: Array, count: int = 6, numbered_at: float | None = None
) -> Campbell:
    """Follow the lateral modes of the string on the axis over the speed of rotation.

    Args:
        equations: Of a scene with a straight vertical hole.
        weight_on_bit: [N].
        speeds: [rad/s], shape (p,), in order.
        count: Modes, the lowest at the first speed.
        numbered_at: Speed [rad/s] at which they are the lowest, in their order, instead; the nearest of `speeds`.

    Raises:
        RunError: The hole is not vertical, or there is no balance.
    """
    frame = _frame_on_axis(
        equations, "found an inclined or curved one; `drill-twin modes` gives its modes at one speed"
    )
    from scipy.optimize import linear_sum_assignment  # takes 0.2 s, which modes do not need

    values = np.zeros((speeds.size, count), dtype=complex)
    first = 0 if numbered_at is None else int(np.argmin(np.abs(speeds - numbered_at)))
    shapes: ComplexArray | None = None
    at_first: ComplexArray | None = None
    for k in (*range(first, speeds.size), *range(first - 1, -1, -1)):
        system = balance(equations, Command(weight_on_bit, float(speeds[k]))).system
        pencil = Pencil(*(frame.as_complex(matrix) for matrix in system.matrices))
        found, vectors = damped_modes(pencil)
        order = np.argsort(np.abs(found))[: count + SPARE]
        found, vectors = found[order], vectors[frame.at_node][:, order]
        beside = k - 1 if k > first else k + 1
        if shapes is None or at_first is None:
            chosen = np.arange(count)
            at_first = vectors[:, chosen]
        else:
            if k == first - 1:
                shapes = at_first
            # one shape belongs to two eigenvalues, forward and backward: the nearer of equal shapes
            scale = np.abs(values[beside]).max()
            apart = np.abs(values[beside][:, None] - found[None, :]) / scale
            chosen = linear_sum_assignment(1.0 - mac(shapes, vectors) + apart)[1]
        values[k], shapes = found[chosen], vectors[:, chosen]
    return Campbell(equations.scene, weight_on_bit, speeds, values, critical_speeds(speeds, values))


def critical_speeds(speeds: Array, eigenvalues: ComplexArray) -> tuple[tuple[int, float], ...]:
    """Speeds of rotation that the frequency of a mode equals, by linear interpolation.

    A mode without oscillation has a frequency of rounding, which a string at rest passes: no critical speed.
    """
    found: list[tuple[int, float]] = []
    ahead = eigenvalues.imag - speeds[:, None]
    for k, mode in zip(*np.nonzero(ahead[:-1] * ahead[1:] <= 0.0), strict=True):
        before, after = ahead[k, mode], ahead[k + 1, mode]
        share = before / (before - after) if before != after else 0.0
        speed = float(speeds[k] + share * (speeds[k + 1] - speeds[k]))
        if speed > AT_REST * np.abs(speeds).max() and not any(
            other == mode and math.isclose(speed, at) for other, at in found
        ):
            found.append((int(mode), speed))
    return tuple(found)


BASIS = 8
"""Undamped modes in which a point of the map is computed."""


class GrowthMap(NamedTuple):
    """Growth rates over a grid of w loads and p speeds."""

    scene: Scene
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
    k = int(np.argmax(growth > 0.0))
    if k == 0:
        return float(weights[0]) if growth[0] > 0.0 else math.nan
    return float(np.interp(0.0, growth[k - 1 : k + 1], weights[k - 1 : k + 1]))


def growth_map(
    equations: EquationsOfMotion, weights: Array, speeds: Array, progress: Callable[[int], None] | None = None
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
    frame = _frame_on_axis(
        equations, "found an inclined or curved one: on its low side there is no single threshold to map"
    )
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
                of_bit = np.arange(int(np.isin(np.flatnonzero(equations.free[0]), frame.x).sum()))  # among frame.x
                bases = (undamped_basis(whirl, BASIS, of_bit),)
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
    return GrowthMap(equations.scene, weights, speeds, lateral, torsional)


def _frame_on_axis(equations: EquationsOfMotion, found: str) -> TurningFrame:
    """Frame that turns with a string on the axis of its hole; `found` ends the message on a hole without one."""
    if not is_vertical(equations):
        raise RunError(
            f"{equations.scene.name}: expected a straight vertical hole, in which the string can turn on the axis, "
            f"{found}"
        )
    frame = TurningFrame(equations)
    if not frame.is_round:
        raise RunError(
            f"{equations.scene.name}: expected supports that act alike in all directions, found string.supports with "
            "two stiffnesses or dampings; `drill-twin modes` gives its modes at one speed"
        )
    return frame
