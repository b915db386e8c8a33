# SPDX-License-Identifier: Apache-2.0
"""The rig in the equations: weight on bit as an axial force, and the top drive.

Set-points arrive as an array: weight on bit [N], top-drive speed [rad/s]. A prescribed turn is a constraint and needs
no force here (the formulation sets it). Any other drive leaves the top free to turn and applies
``P (command - speed) + I (commanded angle - angle)``, within its torque limit.

Forces at the bit are shared through `drill_twin.model.bit`.
"""

from typing import NamedTuple

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.model.bit import BIT_WEIGHT, TOP_TORQUE, WEIGHT, WEIGHT_DAMPING, Bit
from drill_twin.model.mesh import SPIN

WEIGHT_ON_BIT, ROTATION = 0, 1
BIT, TOP, RESIDUAL = 0, 1, 7  # indices into the array of the ends, shape (2, 7, 8)

# Indices into Drive.memory: angle by which the top lags its command [rad]; of the current step the top's angle and
# speed at its start and the commanded speed at its middle.
LAG, START_ANGLE, START_SPEED, COMMAND = 0, 1, 2, 3


class Drive(NamedTuple):
    """Load and drive of the rig, with their memory."""

    from_top: float  # 1: pushed down at the top, bit constrained by the rock; 0: pushed up at the bit, top constrained
    hanging: float  # axial weight of the string, added to a weight set at the top [N]
    driven: float  # 1: the top is turned by a torque; 0: its turn is prescribed
    proportional: float  # torque per error of speed [N m s/rad]
    integral: float  # torque per error of angle [N m/rad]
    limit: float  # largest torque of the motor [N m]
    inertia: float  # of drive and motor about the string's axis [kg m2]
    damping: float  # of bearings and gears [N m s/rad]
    memory: Array  # (4,) see LAG
    bit: Bit


@kernel
def rig_end_load(drive: Drive, command: Array, h2: float, u: Array, v: Array, v_old: Array, ends: Array) -> None:
    """Add the forces of the rig to the residual: compression is positive, and so is right-handed torque."""
    bit = drive.bit
    for c in range(7):
        bit.start[c] = u[0, c] - h2 * v[0, c]
    bit.now[WEIGHT_DAMPING] = 0.0
    if drive.from_top > 0.0:
        ends[TOP, 2, RESIDUAL] += command[WEIGHT_ON_BIT]
        bit.now[WEIGHT] = command[WEIGHT_ON_BIT] + drive.hanging
    else:
        ends[BIT, 2, RESIDUAL] -= command[WEIGHT_ON_BIT]
        bit.now[WEIGHT] = command[WEIGHT_ON_BIT]
    if drive.driven > 0.0:
        last = u.shape[0] - 1
        speed, memory = v[last, SPIN], drive.memory
        memory[START_ANGLE], memory[START_SPEED] = u[last, SPIN] - h2 * speed, v_old[last, SPIN]
        memory[COMMAND] = command[ROTATION]
        lag = h2 * (command[ROTATION] - speed)
        torque = motor(drive, lag / h2, memory[LAG] + lag)
        slope = drive.proportional + h2 * drive.integral if abs(torque) < drive.limit else 0.0
        own = drive.damping + drive.inertia / h2
        ends[TOP, SPIN, SPIN] += slope + own
        ends[TOP, SPIN, RESIDUAL] -= torque - drive.damping * speed - drive.inertia * (speed - v_old[last, SPIN]) / h2


@kernel
def motor(drive: Drive, error: float, lag: float) -> float:
    """Torque of the motor for an error of speed [rad/s] and of angle [rad], within its limit [N m]."""
    torque = drive.proportional * error + drive.integral * lag
    return max(-drive.limit, min(drive.limit, torque))


@kernel
def rig_after_step(drive: Drive, step: float, u: Array, v: Array) -> None:
    """Update the memory after a step: rates of the bit, lag of the top, impulses of weight and drive.

    The lag does not grow while the motor is at its limit and would be driven further into it (conditional integration).
    """
    bit = drive.bit
    for c in range(7):
        bit.rate[c] = (u[0, c] - bit.start[c]) / step
    bit.impulse[BIT_WEIGHT] += step * bit.now[WEIGHT]
    if drive.driven > 0.0:
        last = u.shape[0] - 1
        memory = drive.memory
        speed = (u[last, SPIN] - memory[START_ANGLE]) / step
        lag = step * (memory[COMMAND] - speed)
        torque = motor(drive, lag / step, memory[LAG] + 0.5 * lag)
        if abs(torque) < drive.limit or torque * lag < 0.0:
            memory[LAG] += lag
        accelerating = drive.inertia * (v[last, SPIN] - memory[START_SPEED])
        bit.impulse[TOP_TORQUE] += step * (torque - drive.damping * speed) - accelerating


@kernel
def set_points(first: Array, second: Array, share: float, out: Array) -> None:
    """Set-points between two commands, linearly."""
    out[WEIGHT_ON_BIT] = first[WEIGHT_ON_BIT] + share * (second[WEIGHT_ON_BIT] - first[WEIGHT_ON_BIT])
    out[ROTATION] = first[ROTATION] + share * (second[ROTATION] - first[ROTATION])
