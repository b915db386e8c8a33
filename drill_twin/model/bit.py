# SPDX-License-Identifier: Apache-2.0
"""What rig and rock share at the bit: the weight on it, how it moves in the step at hand, and the impulses of both.

The rig writes the weight it sets, rock that carries the bit writes what it gives instead, and the laws of friction and
torque read it. A law is asked twice: within a step for its force and tangent (hook `end`), and once more when the step
has been taken, at the velocity found, for its impulse (hook `done`).
"""

from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, Pair
from drill_twin.base.jit import kernel
from drill_twin.model.mesh import SPIN

# Places in Bit.now: weight on the bit [N] and minus its slope by the bit's upward velocity [N s/m], both at mid-step;
# weight on the bit at the start of the run, to which the string is in balance [N].
WEIGHT, YIELD, INITIAL = 0, 1, 2
# Places in Bit.impulse: weight on the bit [N s], torque of the rock on it and of the drive on the string [N m s], and
# the depth drilled [m].
BIT_WEIGHT, BIT_TORQUE, TOP_TORQUE, DRILLED = 0, 1, 2, 3


class Bit(NamedTuple):
    """The bit in the step at hand; arrays, so that a checkpoint can copy them."""

    now: Array  # (3,) see WEIGHT
    start: Array  # (7,) its row at the start of the step
    rate: Array  # (7,) its velocity at mid-step, known when the step has been taken
    impulse: Array  # (4,) since the start of the run, see BIT_WEIGHT


def make_bit(weight: float) -> Bit:
    """A bit at rest under a weight [N]."""
    return Bit(np.array([weight, 0.0, weight]), np.zeros(7), np.zeros(7), np.zeros(4))


@kernel
def pressed(bit: Bit) -> float:
    """Weight that presses the bit on the rock, not negative [N]."""
    return float(max(bit.now[WEIGHT], 0.0))


@kernel
def rock_height(bit: Bit, stiffness: float) -> float:
    """Height at which a rock of a stiffness [N/m] carries the bit at the start of the run [m]."""
    return float(bit.start[2] + max(bit.now[INITIAL], 0.0) / stiffness)


@kernel
def resist(bit: Bit, law: Pair, ends: Array) -> None:
    """Turn the bit against a torque that is proportional to the weight on it; `law` is torque and slope by speed."""
    torque, slope = law
    ends[0, SPIN, 7] += torque
    ends[0, SPIN, SPIN] += slope
    if bit.now[WEIGHT] > 0.0:
        ends[0, SPIN, 2] -= torque * bit.now[YIELD] / bit.now[WEIGHT]


@kernel
def carry(bit: Bit, weight: float, slope: float, ends: Array) -> None:
    """Let rock carry the bit: its force up, and minus its slope by the bit's upward velocity."""
    bit.now[WEIGHT], bit.now[YIELD] = weight, slope
    ends[0, 2, 7] -= weight
    ends[0, 2, 2] += slope


@kernel
def carried(bit: Bit, weight: float, step: float) -> None:
    """Correct the weight's impulse to what the rock gave in the step taken."""
    bit.impulse[BIT_WEIGHT] += step * (weight - bit.now[WEIGHT])
    bit.now[WEIGHT] = weight
