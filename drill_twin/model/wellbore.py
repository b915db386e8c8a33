# SPDX-License-Identifier: Apache-2.0
"""Where a point of the string is in the hole: how far off the axis, to which side, and which way the hole runs there.

A straight hole runs along z and costs nothing. Of a curved one each point of the string knows the circular arc that
passes its place (`drill_twin.model.survey`); the nearest point of an arc is known in closed form. Which of the two is
compiled follows from the type of `Bore.axis`: numba drops the other branch.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel


class Axis(NamedTuple):
    """The arcs of the hole's centre line that p places of the string lie at."""

    centre: Array  # of the hole, at the places' depth in the unstretched string [m], shape (p, 3)
    tangent: Array  # unit tangent there, upwards, shape (p, 3)
    normal: Array  # unit vector towards the centre of curvature, shape (p, 3)
    curvature: Array  # [1/m], shape (p,)
    along: Array  # minus the measured depth [m], shape (p,)


class Bore(NamedTuple):
    """The hole around p places of the string."""

    clearance: Array  # how far the centre line can move before the string touches the wall [m], shape (p,)
    axis: Axis | None  # None: straight, along z


class Aside(NamedTuple):
    """A point off the hole's axis, and the axis at its foot."""

    x: float  # offset from the axis, normal to it [m]
    y: float
    z: float
    tx: float  # unit tangent of the axis, upwards
    ty: float
    tz: float


@kernel
def aside(axis: Axis | None, place: int, x: float, y: float, z: float) -> Aside:
    """Offset of a point from the hole's axis, measured from the nearest point of its arc."""
    if axis is None:
        return Aside(x, y, 0.0, 0.0, 0.0, 1.0)
    c, t, n, k = axis.centre[place], axis.tangent[place], axis.normal[place], axis.curvature[place]
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    a = dx * t[0] + dy * t[1] + dz * t[2]
    b = dx * n[0] + dy * n[1] + dz * n[2]
    # with q = distance from the centre of curvature over its radius, the foot is the angle atan2(k a, 1 - k b) on
    q = np.sqrt((k * a) ** 2 + (1.0 - k * b) ** 2)
    cos, sin = (1.0 - k * b) / q, k * a / q
    out = (2.0 * b - k * (a * a + b * b)) / (1.0 + q)
    from_t, from_n = -a - out * sin, out * cos - b
    return Aside(
        dx + from_t * t[0] + from_n * n[0], dy + from_t * t[1] + from_n * n[1], dz + from_t * t[2] + from_n * n[2],
        cos * t[0] + sin * n[0], cos * t[1] + sin * n[1], cos * t[2] + sin * n[2],
    )  # fmt: skip


@kernel
def along(axis: Axis | None, place: int, x: float, y: float, z: float) -> float:
    """Place of a point along the hole [m]: minus the measured depth of the nearest point of the axis."""
    if axis is None:
        return z
    c, t, n, k = axis.centre[place], axis.tangent[place], axis.normal[place], axis.curvature[place]
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    a = dx * t[0] + dy * t[1] + dz * t[2]
    if k > 0.0:
        b = dx * n[0] + dy * n[1] + dz * n[2]
        a = np.arctan2(k * a, 1.0 - k * b) / k
    return float(axis.along[place] + a)
