# SPDX-License-Identifier: Apache-2.0
"""Reading the string: tangents, wall forces and marks of one instant, in one compiled call.

In plain numpy a published frame cost as much as the motion between two of them. This file calls no other kernel, so
numba's own cache, which watches one file, is safe here.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drill_twin.rod.mesh import Rod
from drill_twin.rod.shape import hermite
from drill_twin.rod.types import Array


class Probe(NamedTuple):
    """Fixed places on the string, m of them."""

    element: NDArray[np.int64]  # (m,)
    shape: Array  # (m, 2, 4): value and first derivative
    share: Array  # (m,) place in the element, 0 to 1
    offset: Array  # (m,) distance from the centre line [m], 0 on it


class Sight(NamedTuple):
    """What is seen; n + 1 nodes and m marks."""

    tangents: Array  # (n + 1, 3)
    wall_force: Array  # (n + 1,) [N]
    centre: Array  # (m, 3) [m]
    position: Array  # (m, 3), offset included [m]
    velocity: Array  # (m, 3) of `position` [m/s]
    spin: Array  # (m,) [rad]
    spin_rate: Array  # (m,) [rad/s]
    mark_force: Array  # (m,) [N]


def make_probe(rod: Rod, places: list[float], on_wall: list[bool]) -> Probe:
    """Locate places given by their distance from the bit [m]."""
    arc = np.asarray(places, dtype=float)
    element = np.clip(np.searchsorted(rod.arc, arc, side="right") - 1, 0, rod.length.size - 1)
    xi = (arc - rod.arc[element]) / rod.length[element]
    shape = np.array(
        [hermite(np.array([x]), float(rod.length[e]))[0, :2] for x, e in zip(xi, element, strict=True)]
    ).reshape(-1, 2, 4)
    offset = np.where(np.asarray(on_wall, dtype=bool), rod.outer_radius[element], 0.0)
    return Probe(element.astype(np.int64), shape, xi, offset)


def make_sight(nodes: int, marks: int) -> Sight:
    """Fresh arrays to see into."""
    return Sight(
        np.empty((nodes, 3)), np.zeros(nodes), np.empty((marks, 3)), np.empty((marks, 3)), np.empty((marks, 3)),
        np.empty(marks), np.empty(marks), np.empty(marks),
    )  # fmt: skip


@njit(cache=True, error_model="numpy", nogil=True)
def observe(
    length: Array, shape: Array, u: Array, v: Array, clearance: Array, stiffness: float, probe: Probe, sight: Sight
) -> None:  # fmt: skip
    """Fill `sight` from node rows u, v (r, r', psi).

    Args:
        length: Element lengths [m], shape (n,).
        shape: Shape functions at the Gauss points, shape (n, 2, 3, 4).
        u: Node rows, shape (n + 1, 7).
        v: Their velocities, shape (n + 1, 7).
        clearance: Clearance at the Gauss points [m], shape (2 n,); infinite where there is no wall.
        stiffness: Hertz stiffness of the wall per metre [N/m^2.5].
        probe: The marks.
        sight: Result.
    """
    nodes = u.shape[0]
    for i in range(nodes):
        g = 1.0 / np.sqrt(u[i, 3] ** 2 + u[i, 4] ** 2 + u[i, 5] ** 2)
        for c in range(3):
            sight.tangents[i, c] = u[i, 3 + c] * g
        sight.wall_force[i] = 0.0
    for e in range(nodes - 1):
        for p in range(2):
            n0, n1, n2, n3 = shape[e, p, 0, 0], shape[e, p, 0, 1], shape[e, p, 0, 2], shape[e, p, 0, 3]
            x = n0 * u[e, 0] + n1 * u[e, 3] + n2 * u[e + 1, 0] + n3 * u[e + 1, 3]
            y = n0 * u[e, 1] + n1 * u[e, 4] + n2 * u[e + 1, 1] + n3 * u[e + 1, 4]
            depth = np.sqrt(x * x + y * y) - clearance[2 * e + p]
            if depth > 0.0:
                force = stiffness * depth * np.sqrt(depth) * 0.5 * length[e]
                far = n2 + (n3 - n1) / length[e]  # place of the Gauss point in the element, 0 to 1
                sight.wall_force[e] += (1.0 - far) * force
                sight.wall_force[e + 1] += far * force
    for m in range(probe.element.shape[0]):
        e, far, out = probe.element[m], probe.share[m], probe.offset[m]
        near = 1.0 - far
        psi = near * u[e, 6] + far * u[e + 1, 6]
        rate = near * v[e, 6] + far * v[e + 1, 6]
        w, d = probe.shape[m, 0], probe.shape[m, 1]
        t = np.zeros(3)
        for c in range(3):
            place = w[0] * u[e, c] + w[1] * u[e, 3 + c] + w[2] * u[e + 1, c] + w[3] * u[e + 1, 3 + c]
            sight.centre[m, c] = place
            sight.velocity[m, c] = w[0] * v[e, c] + w[1] * v[e, 3 + c] + w[2] * v[e + 1, c] + w[3] * v[e + 1, 3 + c]
            t[c] = d[0] * u[e, c] + d[1] * u[e, 3 + c] + d[2] * u[e + 1, c] + d[3] * u[e + 1, 3 + c]
        t /= np.sqrt(t[0] ** 2 + t[1] ** 2 + t[2] ** 2)
        # the material's direction: the spin about z, then the smallest turn that takes z to the tangent
        for quarter in range(2):
            cx, cy = np.cos(psi + 0.5 * np.pi * quarter), np.sin(psi + 0.5 * np.pi * quarter)
            across = cx * t[0] + cy * t[1]
            along = across / (1.0 + t[2])
            if quarter == 0:
                sight.position[m, 0] = sight.centre[m, 0] + out * (cx - t[0] * along)
                sight.position[m, 1] = sight.centre[m, 1] + out * (cy - t[1] * along)
                sight.position[m, 2] = sight.centre[m, 2] - out * across
            else:
                sight.velocity[m, 0] += out * rate * (cx - t[0] * along)
                sight.velocity[m, 1] += out * rate * (cy - t[1] * along)
                sight.velocity[m, 2] -= out * rate * across
        sight.spin[m] = psi
        sight.spin_rate[m] = rate
        sight.mark_force[m] = near * sight.wall_force[e] + far * sight.wall_force[e + 1]
