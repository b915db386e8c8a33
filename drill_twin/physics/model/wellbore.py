# SPDX-License-Identifier: Apache-2.0
"""Position of a point of the string in the hole: offset from the axis, and direction of the axis.

A straight hole is along z. In a curved hole, each point of the string has the circular arc at its depth
(`drill_twin.physics.model.survey`), whose nearest point is known in closed form. The type of `Wellbore.axis` selects
straight or curved at compile time: numba drops the other branch. For pictures, whole arrays are converted between the
frame `hole` and coordinates along the hole.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.strain import transverse_axes


class Axis(NamedTuple):
    """Arcs of the hole's centre line at p points of the string."""

    centre: Array  # of the hole, at the points' depth in the unstretched string [m], shape (p, 3)
    tangent: Array  # unit tangent there, upwards, shape (p, 3)
    normal: Array  # unit vector towards the centre of curvature, shape (p, 3)
    curvature: Array  # [1/m], shape (p,)
    along: Array  # minus the measured depth [m], shape (p,)


class Wellbore(NamedTuple):
    """Hole around p points of the string."""

    clearance: Array  # radius of the hole minus contact radius of the string [m], shape (p,)
    axis: Axis | None  # None: straight, along z


class AxisOffset(NamedTuple):
    """Offset of a point from the hole's axis, and the axis at its nearest point."""

    x: float  # offset from the axis, normal to it [m]
    y: float
    z: float
    tx: float  # unit tangent of the axis, upwards
    ty: float
    tz: float


@kernel
def axis_offset(axis: Axis | None, place: int, x: float, y: float, z: float) -> AxisOffset:
    """Offset of a point from the hole's axis, measured from the nearest point of its arc."""
    if axis is None:
        return AxisOffset(x, y, 0.0, 0.0, 0.0, 1.0)
    c, t, n, k = axis.centre[place], axis.tangent[place], axis.normal[place], axis.curvature[place]
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    a = dx * t[0] + dy * t[1] + dz * t[2]
    b = dx * n[0] + dy * n[1] + dz * n[2]
    # q = distance from the centre of curvature over its radius; the nearest point is at the angle atan2(k a, 1 - k b)
    q = np.sqrt((k * a) ** 2 + (1.0 - k * b) ** 2)
    cos, sin = (1.0 - k * b) / q, k * a / q
    out = (2.0 * b - k * (a * a + b * b)) / (1.0 + q)
    from_t, from_n = -a - out * sin, out * cos - b
    return AxisOffset(
        dx + from_t * t[0] + from_n * n[0], dy + from_t * t[1] + from_n * n[1], dz + from_t * t[2] + from_n * n[2],
        cos * t[0] + sin * n[0], cos * t[1] + sin * n[1], cos * t[2] + sin * n[2],
    )  # fmt: skip


@kernel
def distance_along(axis: Axis | None, place: int, x: float, y: float, z: float) -> float:
    """Coordinate of a point along the hole [m]: minus the measured depth of the nearest point of the axis."""
    if axis is None:
        return z
    c, t, n, k = axis.centre[place], axis.tangent[place], axis.normal[place], axis.curvature[place]
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    a = dx * t[0] + dy * t[1] + dz * t[2]
    if k > 0.0:
        b = dx * n[0] + dy * n[1] + dz * n[2]
        a = np.arctan2(k * a, 1.0 - k * b) / k
    return float(axis.along[place] + a)


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
