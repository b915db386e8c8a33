# SPDX-License-Identifier: Apache-2.0
"""The bit's unknowns in the frame of the hole at the bit.

Constraints and loads of the bit act along and across the hole there, and a curved hole does not run along z at the bit.
So the bit's rows and columns of the system are rotated into that frame before its loads and constraints are added, and
its Newton step is rotated back. In a straight hole the rotation is the identity, and exact.
"""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.wellbore import Axis


def bit_frame(axis: Axis | None) -> Array:
    """Transform into the frame of the hole at the bit, shape (3, 4): local = frame[:, :3] r + frame[:, 3].

    Its z is along the hole and minus the measured depth, its x and y are off the hole's axis.

    Args:
        axis: The hole at the bit, one point; None where it is straight.
    """
    if axis is None:
        return np.eye(3, 4)
    x, y, z = axis.tangent[0]
    turn = np.array([[1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), -x],
                     [-x * y / (1.0 + z), 1.0 - y * y / (1.0 + z), -y], [x, y, z]])  # fmt: skip
    shift = np.array([0.0, 0.0, axis.along[0]]) - turn @ axis.centre[0]
    return np.column_stack([turn, shift])


@kernel
def turn_vector(frame: Array, row: Array, first: int) -> None:
    """Rotate three entries of a row, a vector, into the frame."""
    x, y, z = row[first], row[first + 1], row[first + 2]
    for c in range(3):
        row[first + c] = frame[c, 0] * x + frame[c, 1] * y + frame[c, 2] * z


@kernel
def turn_back(frame: Array, row: Array, first: int) -> None:
    """Rotate three entries of a row, a vector, out of the frame."""
    x, y, z = row[first], row[first + 1], row[first + 2]
    for c in range(3):
        row[first + c] = frame[0, c] * x + frame[1, c] * y + frame[2, c] * z


@kernel
def turn_row(frame: Array, row: Array) -> None:
    """Rotate a node's row into the frame: r and r', or their velocities."""
    turn_vector(frame, row, 0)
    turn_vector(frame, row, 3)


@kernel
def turn_row_back(frame: Array, row: Array) -> None:
    """Rotate a node's row out of the frame."""
    turn_back(frame, row, 0)
    turn_back(frame, row, 3)


@kernel
def to_bit(frame: Array, row: Array, rate: Array) -> None:
    """Transform the bit's row and its velocities into the frame."""
    turn_row(frame, row)
    turn_row(frame, rate)
    for c in range(3):
        row[c] += frame[c, 3]


@kernel
def from_bit(frame: Array, row: Array, rate: Array) -> None:
    """Transform the bit's row and its velocities out of the frame."""
    for c in range(3):
        row[c] -= frame[c, 3]
    turn_row_back(frame, row)
    turn_row_back(frame, rate)


@kernel
def turn_blocks(frame: Array, own: Array, upper: Array, lower: Array) -> None:
    """Rotate the bit's blocks of the system: rows of `own` and `upper`, columns of `own` and `lower`."""
    for j in range(8):
        turn_column(frame, own, j)
        turn_column(frame, upper, j)
    for i in range(7):
        turn_row(frame, own[i])
        turn_row(frame, lower[i])


@kernel
def turn_column(frame: Array, block: Array, j: int) -> None:
    """Rotate the rows of r and r' in a column of a block into the frame."""
    for first in (0, 3):
        x, y, z = block[first, j], block[first + 1, j], block[first + 2, j]
        for c in range(3):
            block[first + c, j] = frame[c, 0] * x + frame[c, 1] * y + frame[c, 2] * z


@kernel
def turn_step_back(frame: Array, block: Array) -> None:
    """Rotate the bit's Newton step, in the last column of its block, out of the frame."""
    for first in (0, 3):
        x, y, z = block[first, 7], block[first + 1, 7], block[first + 2, 7]
        for c in range(3):
            block[first + c, 7] = frame[0, c] * x + frame[1, c] * y + frame[2, c] * z
