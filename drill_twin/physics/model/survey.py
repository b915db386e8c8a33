# SPDX-License-Identifier: Apache-2.0
"""Centre line of a surveyed hole: circular arcs between stations, by the minimum curvature method.

Between two stations the hole follows the circular arc with the surveyed directions at its ends; its curvature is the
angle between them over the difference of measured depth (Sawaryn and Thorogood 2005, SPE Drilling and Completion
20(1), 24-36, Eq. 1-9). Below the last station and above the first, the hole is straight.

Positions are in the frame `hole`: origin at the top clamp, z up along the axis there, x to the low side (in a hole that
starts plumb: away from the azimuth it then builds to), y = z times x.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model.wellbore import Axis

STRAIGHT = 1e-12  # angle between two stations below which the hole is straight there [rad]


class Survey(NamedTuple):
    """Surveyed centre line, m stations from the top down."""

    depth: Array  # measured depth from the top clamp [m], shape (m,), rising from 0
    position: Array  # of the stations [m], shape (m, 3)
    down: Array  # unit direction of the hole, downwards, at the stations, shape (m, 3)
    bend: Array  # unit vector towards the centre of curvature below each station, shape (m, 3)
    curvature: Array  # of the arc below each station [1/m], shape (m,); the last is 0

    def at(self, depth: Array) -> Axis:
        """Arcs at the given measured depths [m], shape (p,)."""
        number = np.clip(np.searchsorted(self.depth, depth, side="right") - 1, 0, self.depth.size - 1)
        curvature = np.where(depth < self.depth[0], 0.0, self.curvature[number])
        run = depth - self.depth[number]
        down, bend, turn = self.down[number], self.bend[number], curvature * run
        # sin(k s) / k and (1 - cos(k s)) / k, also where k = 0
        ahead, aside = run * np.sinc(turn / np.pi), 0.5 * run * turn * np.sinc(0.5 * turn / np.pi) ** 2
        cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
        return Axis(
            centre=self.position[number] + ahead[:, None] * down + aside[:, None] * bend,
            tangent=-(cos * down + sin * bend),
            normal=cos * bend - sin * down,
            curvature=curvature,
            along=-depth,
        )

    @property
    def straight(self) -> bool:
        """True if all curvatures are zero."""
        return bool(np.all(self.curvature == 0.0))


def directions(inclination: Array, azimuth: Array) -> Array:
    """Unit vectors down the hole in north, east, down; angles in rad, shape (m,); result shape (m, 3)."""
    across = np.sin(inclination)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(inclination)], -1)


def top_frame(inclination: float, azimuth: float) -> Array:
    """Rows: axes x, y, z of the frame `hole` in north, east, down, shape (3, 3)."""
    ci, si, ca, sa = np.cos(inclination), np.sin(inclination), np.cos(azimuth), np.sin(azimuth)
    return np.array([[-ci * ca, -ci * sa, si], [-sa, ca, 0.0], [-si * ca, -si * sa, -ci]])


def survey(depth: Array, inclination: Array, azimuth: Array) -> Survey:
    """Centre line through stations.

    Args:
        depth: Measured depth [m], shape (m,), rising from 0.
        inclination: From the vertical [rad], shape (m,).
        azimuth: From north, clockwise seen from above [rad], shape (m,).
    """
    down = directions(inclination, azimuth) @ top_frame(float(inclination[0]), float(azimuth[0])).T
    first, second, run = down[:-1], down[1:], np.diff(depth)
    cos = np.sum(first * second, -1)
    across = second - cos[:, None] * first
    sin = np.linalg.norm(across, axis=1)
    angle = np.arctan2(sin, cos)
    bends = angle > STRAIGHT
    bend = np.stack([_some_normal(d) for d in down])
    bend[:-1][bends] = across[bends] / sin[bends, None]
    curvature = np.append(np.where(bends, angle / run, 0.0), 0.0)
    # chord of an arc: along the mean direction, with the ratio factor tan(angle / 2) / (angle / 2)
    ratio = np.where(bends, np.tan(0.5 * angle) / np.where(bends, 0.5 * angle, 1.0), 1.0)
    legs = (0.5 * run * ratio)[:, None] * (first + second)
    position = np.concatenate([np.zeros((1, 3)), np.cumsum(legs, axis=0)])
    return Survey(depth, position, down, bend, curvature)


def dogleg(inclination: Array, azimuth: Array) -> Array:
    """Angle between the directions at neighbouring stations [rad], shape (m - 1,)."""
    way = directions(inclination, azimuth)
    return np.asarray(2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(np.diff(way, axis=0), axis=1), 0.0, 1.0)))


def _some_normal(direction: Array) -> Array:
    """Arbitrary unit vector normal to a direction."""
    other = np.eye(3)[np.argmin(np.abs(direction))]
    normal = np.cross(direction, other)
    return np.asarray(normal / np.linalg.norm(normal))
