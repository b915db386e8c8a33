# SPDX-License-Identifier: Apache-2.0
"""The string's curve between its nodes, so that a coarse mesh is not drawn with corners it does not have."""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import survey_of
from drill_twin.model.wellbore_coordinates import unrolled
from drill_twin.scene import Scene

FINEST = 100
"""Points a curve is drawn with; a mesh with more nodes is drawn as it is."""


def tangents(orientation: Array) -> Array:
    """Unit tangents of poses: z turned by unit quaternions x y z w, shape (..., 4) -> (..., 3)."""
    x, y, z, w = np.moveaxis(orientation, -1, 0)
    return np.stack((2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)), axis=-1)


def along_hole(scene: Scene, curves: Array) -> Array:
    """Curves as seen along the hole: x and y off its axis, z minus the measured depth; a straight hole is so already.

    Args:
        scene: What is drilled.
        curves: Places of the frame `hole` from the bit up [m], shape (T, k, 3).
    """
    line = survey_of(scene)
    if line is None or not curves.size:
        return curves
    steps = np.linalg.norm(np.diff(curves[0], axis=0), axis=1)
    up = np.concatenate(([0.0], np.cumsum(steps)))
    return unrolled(line.at(scene.length * (1.0 - up / up[-1])), curves)


def smooth(position: Array, tangent: Array) -> Array:
    """Cubic Hermite curve through nodes with their tangents, as the twin's own elements are.

    Args:
        position: Node positions [m], shape (T, n + 1, 3).
        tangent: Unit tangents, shape (T, n + 1, 3).

    Returns:
        Points on the curve [m], the nodes among them, shape (T, k, 3).
    """
    elements = position.shape[1] - 1
    pieces = max(1, FINEST // max(elements, 1))
    if pieces == 1 or elements < 1:
        return position
    u = np.arange(pieces)[:, None] / pieces  # shape (pieces, 1), from 0 up to, not with, 1
    begin, end = position[:, :-1, None], position[:, 1:, None]
    chord = np.linalg.norm(end - begin, axis=-1, keepdims=True)
    leave, arrive = chord * tangent[:, :-1, None], chord * tangent[:, 1:, None]
    curve = (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * begin
        + u * (1.0 - u) ** 2 * leave
        + u**2 * (3.0 - 2.0 * u) * end
        + u**2 * (u - 1.0) * arrive
    )
    return np.concatenate((curve.reshape(position.shape[0], -1, 3), position[:, -1:]), axis=1)
