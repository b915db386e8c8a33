# SPDX-License-Identifier: Apache-2.0
"""State of the bit, shared by rig and rock: weight on bit, motion in the current step, impulses.

The rig writes the prescribed weight, an effect that supports the bit overwrites it with its force, and the laws of
friction and torque read it. A law is evaluated in the iteration for force and tangent (hook `end_load`), and after the
step, at the velocity found, for its impulse (hook `after_step`).
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.mesh import SPIN

# Indices into Bit.now: weight on bit [N] and minus its slope by the bit's upward velocity [N s/m], both at mid-step;
# weight on bit at the start of the run, with which the string is in equilibrium [N].
WEIGHT, WEIGHT_DAMPING, INITIAL = 0, 1, 2
# Indices into Bit.impulse: weight on bit [N s], torque of the rock on it and of the drive on the string [N m s], and
# the depth drilled [m]; where the block is moved, the pull of the lines [N s].
BIT_WEIGHT, BIT_TORQUE, TOP_TORQUE, DRILLED, HOOK = 0, 1, 2, 3, 4


class Bit(NamedTuple):
    """State of the bit in the current step, in arrays, for checkpoints."""

    now: Array  # (3,) see WEIGHT
    start: Array  # (7,) its row at the start of the step
    rate: Array  # (7,) its velocity at mid-step, known after the step
    impulse: Array  # (4,), or (5,) with a block, since the start of the run, see BIT_WEIGHT
    off_bottom: float  # height above the rock at the start of the run [m]


def make_bit(weight: float, impulses: int = 4, off_bottom: float = 0.0) -> Bit:
    """Make a bit at rest under a weight [N], or at a height above the rock [m]."""
    return Bit(np.array([weight, 0.0, weight]), np.zeros(7), np.zeros(7), np.zeros(impulses), off_bottom)


@kernel
def contact_weight(bit: Bit) -> float:
    """Weight on bit, not negative [N]."""
    return float(max(bit.now[WEIGHT], 0.0))


@kernel
def rock_height(bit: Bit, stiffness: float) -> float:
    """Height of the surface of rock of a stiffness [N/m] that supports the bit at the start of the run [m]."""
    return float(bit.start[2] - bit.off_bottom + max(bit.now[INITIAL], 0.0) / stiffness)


@kernel
def apply_torque(bit: Bit, law: Pair, ends: Array) -> None:
    """Add a torque proportional to the weight on bit; `law` is the torque [N m] and its slope by the speed [N m s]."""
    torque, slope = law
    ends[0, SPIN, 7] += torque
    ends[0, SPIN, SPIN] += slope
    if bit.now[WEIGHT] > 0.0:
        ends[0, SPIN, 2] -= torque * bit.now[WEIGHT_DAMPING] / bit.now[WEIGHT]


@kernel
def apply_support(bit: Bit, weight: float, slope: float, ends: Array) -> None:
    """Add the supporting force of the rock, given with minus its slope by the bit's upward velocity."""
    bit.now[WEIGHT], bit.now[WEIGHT_DAMPING] = weight, slope
    ends[0, 2, 7] -= weight
    ends[0, 2, 2] += slope


@kernel
def correct_weight_impulse(bit: Bit, weight: float, step: float) -> None:
    """Correct the impulse of the weight on bit to the supporting force in the step."""
    bit.impulse[BIT_WEIGHT] += step * (weight - bit.now[WEIGHT])
    bit.now[WEIGHT] = weight
