# SPDX-License-Identifier: Apache-2.0
"""The rig's two handles: weight on bit as an axial force, and the prescribed turn of the top.

The turn is a constraint and needs no force here (`drill_twin.solve.midpoint` sets it). Set-points arrive as an array:
weight on bit [N], top-drive speed [rad/s].
"""

from typing import NamedTuple

from drill_twin.rod.jit import kernel
from drill_twin.rod.types import Array

WEIGHT_ON_BIT, ROTATION = 0, 1
BIT, TOP, RESIDUAL = 0, 1, 7  # places in the array of the ends, shape (2, 7, 8)


class Drive(NamedTuple):
    """Where the weight on bit is applied."""

    from_top: float  # 1: pushed down at the top, the rock holds the bit; 0: pushed up at the bit, the top is held


@kernel
def weight_on_bit(drive: Drive, command: Array, ends: Array) -> None:
    """Add the axial force of the rig to the residual: compression is positive."""
    if drive.from_top > 0.0:
        ends[TOP, 2, RESIDUAL] += command[WEIGHT_ON_BIT]
    else:
        ends[BIT, 2, RESIDUAL] -= command[WEIGHT_ON_BIT]


@kernel
def set_points(first: Array, second: Array, share: float, out: Array) -> None:
    """Set-points between two commands, linearly."""
    out[WEIGHT_ON_BIT] = first[WEIGHT_ON_BIT] + share * (second[WEIGHT_ON_BIT] - first[WEIGHT_ON_BIT])
    out[ROTATION] = first[ROTATION] + share * (second[ROTATION] - first[ROTATION])
