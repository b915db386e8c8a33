# SPDX-License-Identifier: Apache-2.0
"""Observation of the string: tangents, wall forces, marks and penetration at one instant, in one compiled call.

In plain numpy a published frame takes as long as the motion between two published frames. The force of the wall is
evaluated with the function of the solver (`drill_twin.physics.effects.wall.contact_force`).

Marks are in the frame of the hole at their depth, so that orbits are around the axis in a curved hole too: x and y from
the hole's axis, z along the hole (minus the measured depth). The directions x and y of the frame `hole` are
turned by the smallest rotation of z onto the axis, as in the definition of the spin.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model import (
    Axis,
    Point,
    Rod,
    Wellbore,
    along_element,
    axis_offset,
    distance_along,
    locate,
    rotate_to_tangent,
)

DEPTH, PLACE = 0, 1  # indices into Observation.deepest


class MarkPlaces(NamedTuple):
    """Fixed points on the string, m of them."""

    element: NDArray[np.int64]  # (m,)
    shape: Array  # (m, 2, 4): value and first derivative
    share: Array  # (m,) coordinate in the element, 0 to 1
    offset: Array  # (m,) distance from the centre line [m]
    axis: Axis | None  # the hole there


class Observation(NamedTuple):
    """State of n + 1 nodes and m marks."""

    tangents: Array  # (n + 1, 3)
    wall_force: Array  # (n + 1,) [N]
    centre: Array  # (m, 3) [m]
    position: Array  # (m, 3), offset included [m]
    velocity: Array  # (m, 3) of `position` [m/s]
    spin: Array  # (m,) [rad]
    spin_rate: Array  # (m,) [rad/s]
    mark_force: Array  # (m,) [N]
    deepest: Array  # (2,) largest penetration of the surface into the wall [m], and its Gauss point
    gauss_arc: Array  # (2 n,) of the Gauss points from the bit [m]
    side: Array  # (2 k,) force per length on the wall at the last Gauss points, where the string follows the hole [N/m]


def locate_marks(rod: Rod, places: Array, offset: Array, axis: Axis | None = None) -> MarkPlaces:
    """Locate marks in the mesh.

    Args:
        rod: The string.
        places: Their distance from the bit [m], shape (m,).
        offset: Their distance from the centre line [m], shape (m,).
        axis: Axis of the hole there; None for a straight hole.
    """
    element, xi, shape = locate(rod, places)
    return MarkPlaces(element, shape[:, :2].copy(), xi, np.asarray(offset, dtype=float).reshape(-1), axis)


def make_observation(gauss_arc: Array, marks: int, side: Array) -> Observation:
    """Arrays for an observation of Gauss points and a number of marks; `side` as in `Observation`."""
    n, m = gauss_arc.size // 2 + 1, marks
    shapes = ((n, 3), (n,), (m, 3), (m, 3), (m, 3), (m,), (m,), (m,), (2,))
    arrays: list[Array] = [np.zeros(shape) for shape in shapes]
    return Observation._make((*arrays, gauss_arc, side))


@kernel
def observe_nodes(u: Array, out: Observation) -> None:
    """Compute tangents and clear the wall forces."""
    for i in range(u.shape[0]):
        g = 1.0 / np.sqrt(u[i, 3] ** 2 + u[i, 4] ** 2 + u[i, 5] ** 2)
        for c in range(3):
            out.tangents[i, c] = u[i, 3 + c] * g
        out.wall_force[i] = 0.0


@kernel
def observe_marks(u: Array, v: Array, marks: MarkPlaces, out: Observation) -> None:
    """Compute position and velocity of the marks in the frame of the hole at their depth, spin and wall force."""
    for m in range(marks.element.shape[0]):
        e, far, radius = marks.element[m], marks.share[m], marks.offset[m]
        near = 1.0 - far
        psi = near * u[e, 6] + far * u[e + 1, 6]
        rate = near * v[e, 6] + far * v[e + 1, 6]
        w, d = marks.shape[m, 0], marks.shape[m, 1]
        r, dr, t = along_element(w, u, e), along_element(w, v, e), along_element(d, u, e)
        g = 1.0 / np.sqrt(t[0] ** 2 + t[1] ** 2 + t[2] ** 2)
        arm = rotate_to_tangent(t[0] * g, t[1] * g, t[2] * g, radius * np.cos(psi), radius * np.sin(psi))
        sweep = rotate_to_tangent(
            t[0] * g, t[1] * g, t[2] * g, -radius * rate * np.sin(psi), radius * rate * np.cos(psi)
        )
        off = axis_offset(marks.axis, m, r[0], r[1], r[2])
        ex = rotate_to_tangent(off.tx, off.ty, off.tz, 1.0, 0.0)
        ey = rotate_to_tangent(off.tx, off.ty, off.tz, 0.0, 1.0)
        ez = (off.tx, off.ty, off.tz)
        out.centre[m, 0] = ex[0] * off.x + ex[1] * off.y + ex[2] * off.z
        out.centre[m, 1] = ey[0] * off.x + ey[1] * off.y + ey[2] * off.z
        out.centre[m, 2] = distance_along(marks.axis, m, r[0], r[1], r[2])
        vx, vy, vz = dr[0] + sweep[0], dr[1] + sweep[1], dr[2] + sweep[2]
        out.position[m, 0] = out.centre[m, 0] + ex[0] * arm[0] + ex[1] * arm[1] + ex[2] * arm[2]
        out.position[m, 1] = out.centre[m, 1] + ey[0] * arm[0] + ey[1] * arm[1] + ey[2] * arm[2]
        out.position[m, 2] = out.centre[m, 2] + ez[0] * arm[0] + ez[1] * arm[1] + ez[2] * arm[2]
        out.velocity[m, 0] = ex[0] * vx + ex[1] * vy + ex[2] * vz
        out.velocity[m, 1] = ey[0] * vx + ey[1] * vy + ey[2] * vz
        out.velocity[m, 2] = ez[0] * vx + ez[1] * vy + ez[2] * vz
        out.spin[m] = psi
        out.spin_rate[m] = rate
        out.mark_force[m] = near * out.wall_force[e] + far * out.wall_force[e + 1]


def bind(contact_force: Any) -> Callable[..., None]:
    """Bind the observation to the wall's contact law, `contact_force` of its effect; None for a string without one."""

    @kernel
    def observe_wall(
        length: Array, shape: Array, bore: Wellbore, wall: Any, u: Array, v: Array, out: Observation
    ) -> None:
        """Compute the largest penetration, and distribute the wall forces to the nodes by the lever rule."""
        free = u.shape[0] - 1 - out.side.size // 2
        for e in range(free):
            for p in range(2):
                w, place = shape[e, p, 0], 2 * e + p
                x, y, z = along_element(w, u, e)
                off = axis_offset(bore.axis, place, x, y, z)
                depth = np.sqrt(off.x**2 + off.y**2 + off.z**2) - bore.clearance[place]
                if depth > out.deepest[DEPTH]:
                    out.deepest[DEPTH], out.deepest[PLACE] = depth, place
                if wall is not None and depth > 0.0:
                    vx, vy, vz = along_element(w, v, e)
                    here = Point(
                        e, place, 0.0, x, y, z, vx, vy, vz, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
                        0.0, 0.0, 0.0, 1.0, 0.0, True, 0.0,
                    )  # fmt: skip
                    force = contact_force(wall, here, 0.0).force * 0.5 * length[e]
                    far = w[2] + (w[1] + w[3]) / length[e]  # coordinate of the Gauss point in the element, 0 to 1
                    out.wall_force[e] += (1.0 - far) * force
                    out.wall_force[e + 1] += far * force
        for k in range(out.side.size):
            e = free + k // 2
            w, force = shape[e, k % 2, 0], out.side[k] * 0.5 * length[e]
            far = w[2] + (w[1] + w[3]) / length[e]
            out.wall_force[e] += (1.0 - far) * force
            out.wall_force[e + 1] += far * force

    @kernel
    def observe(
        length: Array, shape: Array, hole: Wellbore, wall: Any, u: Array, v: Array, marks: MarkPlaces, out: Observation
    ) -> None:
        """Observe a state given by its node rows u, v (r, r', psi), shape (n + 1, 7) each."""
        out.deepest[DEPTH], out.deepest[PLACE] = -np.inf, 0.0
        observe_nodes(u, out)
        observe_wall(length, shape, hole, wall, u, v, out)
        observe_marks(u, v, marks, out)

    return observe
