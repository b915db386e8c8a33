# SPDX-License-Identifier: Apache-2.0
"""Unknowns across the axis of the hole, the quarter turn J that takes x to y and y to minus x, and the hole's frame."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.discretisation.discretise import axis_at
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion

ISOTROPIC = 1e-4
"""Largest difference between the directions x and y, over the largest entry, of equations without a direction."""

UPRIGHT = 1e-6
"""Sine of the inclination below which a hole has no low side."""


def quarter_turn(rows: Array) -> Array:
    """J applied to rows of seven: positions and slopes across the axis are turned, the rest is zero."""
    turned = np.zeros_like(rows)
    turned[:, 0], turned[:, 1], turned[:, 3], turned[:, 4] = -rows[:, 1], rows[:, 0], -rows[:, 4], rows[:, 3]
    return turned


class TurningFrame:
    """Free unknowns across the axis and along it, and matrices of the free unknowns on x + i y.

    Attributes:
        x: Numbers of the free unknowns x and x', by node.
        y: Numbers of y and y', in the same order.
        rest: Numbers of the others: along and about the axis.
        at_node: Of each entry of `x` whether it is a position, not a slope.
        is_round: True if every support of the string acts alike in all directions.
    """

    def __init__(self, equations: EquationsOfMotion) -> None:
        """Find the unknowns across the axis."""
        free = equations.free
        number = np.full(free.shape, -1)
        number[free] = np.arange(equations.unknowns)
        column = np.broadcast_to(equations.columns, free.shape)[free]
        self.x: NDArray[np.int64] = np.flatnonzero((column == 0) | (column == 3))
        self.y: NDArray[np.int64] = np.flatnonzero((column == 1) | (column == 4))
        self.rest: NDArray[np.int64] = np.setdiff1d(np.arange(equations.unknowns), np.concatenate([self.x, self.y]))
        self.at_node = column[self.x] == 0
        self._free, self._columns = free, equations.columns
        self.is_round: bool = all(support.is_isotropic for support in equations.scene.string.supports)

    def values(self, rows: Array) -> Array:
        """Values of the free unknowns in rows of seven, shape (m,)."""
        return np.asarray(rows[:, self._columns][self._free])

    def farthest(self, values: Array) -> int:
        """Number of the unknown y of the node that is farthest from the axis."""
        distance = np.hypot(values[self.x], values[self.y]) * self.at_node
        return int(self.y[int(np.argmax(distance))])

    def is_isotropic(self, matrix: Array) -> bool:
        """True if a matrix is the same in all directions, and does not couple them with the rest."""
        x, y, rest, size = self.x, self.y, self.rest, float(np.abs(matrix).max())
        differences = [
            matrix[np.ix_(x, x)] - matrix[np.ix_(y, y)],
            matrix[np.ix_(x, y)] + matrix[np.ix_(y, x)],
            *(matrix[np.ix_(one, other)] for way in (x, y) for one, other in ((way, rest), (rest, way))),
        ]
        return self.is_round and all(np.abs(part).max(initial=0.0) <= ISOTROPIC * size for part in differences)

    def as_complex(self, matrix: Array) -> ComplexArray:
        """Isotropic matrix on x + i y."""
        x, y = self.x, self.y
        same = 0.5 * (matrix[np.ix_(x, x)] + matrix[np.ix_(y, y)])
        turn = 0.5 * (matrix[np.ix_(y, x)] - matrix[np.ix_(x, y)])
        return np.asarray(same + 1j * turn)


class HoleFrame(NamedTuple):
    """Directions of the hole at the n + 1 nodes, unit vectors, shape (n + 1, 3) each."""

    low: Array
    """Across the hole, to its low side; x in a vertical hole."""
    side: Array
    """Across the hole, level: along times low, so that a string that turns goes from low to side."""
    along: Array
    """Along the hole, upwards."""
    bit: Array
    """Rotation into the frame of the bit's row (`drill_twin.dynamics.solver.boundary`), shape (3, 3)."""

    @classmethod
    def of(cls, equations: EquationsOfMotion) -> HoleFrame:
        """Frame of the nodes of a string."""
        scene, model = equations.scene, equations.model
        axis = axis_at(scene, scene.length - model.rod.arc)
        along = np.tile([0.0, 0.0, 1.0], (model.rod.arc.size, 1)) if axis is None else axis.tangent
        down = np.array([np.sin(model.inclination), 0.0, -np.cos(model.inclination)])
        low = down - (along @ down)[:, None] * along
        upright = np.linalg.norm(low, axis=1) < UPRIGHT
        x = np.array([1.0, 0.0, 0.0])
        low[upright] = (x - (along @ x)[:, None] * along)[upright]
        low /= np.linalg.norm(low, axis=1)[:, None]
        return cls(low, np.cross(along, low), along, equations.bit_frame[:, :3])

    def local(self, rows: Any) -> Any:
        """Rows (r, r', psi) of small motions of the free unknowns, as low, side and along; shape (..., n + 1, 7)."""
        result, basis = self.fixed(rows), np.stack([self.low, self.side, self.along], axis=-1)
        for part in (result[..., 0:3], result[..., 3:6]):
            part[:] = np.einsum("...nc,nck->...nk", part, basis)
        return result

    def fixed(self, rows: Any, back: bool = False) -> Any:
        """The same rows with the bit's row out of its frame, or `back` in it."""
        result, turn = rows.copy(), self.bit.T if back else self.bit
        for first in (0, 3):
            result[..., 0, first : first + 3] = rows[..., 0, first : first + 3] @ turn
        return result

    def forces(self, size: Array) -> ComplexArray:
        """Forces that turn with the string, low - i side, at the nodes, at the bit in the bit's frame; (n + 1, 3)."""
        vectors = np.asarray(size[:, None] * (self.low - 1j * self.side), complex)
        vectors[0] = self.bit @ vectors[0]
        return vectors
