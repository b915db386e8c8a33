# SPDX-License-Identifier: Apache-2.0
"""Conversion between the frame `hole` and coordinates along a curved hole, for pictures.

The geometry of `drill_twin.physics.model.wellbore`, for whole arrays.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model.frames import transverse_axes
from drill_twin.physics.model.wellbore import Axis

_STRAIGHT = 1e-12  # curvature [1/m] below which an arc is a line


class Offsets(NamedTuple):
    """Offsets of p points from the hole's axis."""

    off: Array  # from the axis to the point, normal to it [m], shape (..., p, 3)
    tangent: Array  # of the axis there, shape (..., p, 3)
    along: Array  # minus the measured depth [m], shape (..., p)


def offsets(axis: Axis, places: Array) -> Offsets:
    """Offsets of points [m], shape (..., p, 3), from their nearest points of the axis."""
    t, n, k = axis.tangent, axis.normal, axis.curvature
    d = places - axis.centre
    a, b = (d * t).sum(-1), (d * n).sum(-1)
    q = np.sqrt((k * a) ** 2 + (1.0 - k * b) ** 2)
    cos, sin = (1.0 - k * b) / q, k * a / q
    out = (2.0 * b - k * (a * a + b * b)) / (1.0 + q)
    off = d + (-a - out * sin)[..., None] * t + (out * cos - b)[..., None] * n
    arc = np.where(k > _STRAIGHT, np.arctan2(k * a, 1.0 - k * b) / np.maximum(k, _STRAIGHT), a)
    return Offsets(off, cos[..., None] * t + sin[..., None] * n, axis.along + arc)


def to_hole_coordinates(axis: Axis, places: Array) -> Array:
    """Convert points to the frame of the hole at their depth: x and y from the axis, z minus the measured depth [m]."""
    here = offsets(axis, places)
    ex, ey = transverse_axes(here.tangent)
    return np.stack(((here.off * ex).sum(-1), (here.off * ey).sum(-1), here.along), axis=-1)


def from_hole_coordinates(axis: Axis, places: Array) -> Array:
    """Convert points to the frame `hole` [m]; the inverse of `to_hole_coordinates`."""
    t, n, k = axis.tangent, axis.normal, np.maximum(axis.curvature, _STRAIGHT)
    angle = k * (places[..., 2] - axis.along)
    foot = axis.centre + (np.sin(angle) / k)[..., None] * t + (2.0 * np.sin(0.5 * angle) ** 2 / k)[..., None] * n
    ex, ey = transverse_axes(np.cos(angle)[..., None] * t + np.sin(angle)[..., None] * n)
    return foot + places[..., 0:1] * ex + places[..., 1:2] * ey
