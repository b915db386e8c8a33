# SPDX-License-Identifier: Apache-2.0
"""The ends of the string in the equations: weight on bit as an axial force, the top drive, the frame of the bit.

Set-points arrive as an array: weight on bit [N], top-drive speed [rad/s], and with a block its speed [m/s]. The
block carries the top on the drilling lines, a spring. An auto-driller moves the block once a
step, by the error of the weight on bit that surface measurements give, proportional and integral, or by the error of
the torque where that is smaller. A prescribed turn is a constraint, which the formulation sets, and needs no force
here. Any other drive leaves the top free to turn and applies
``P (command - speed) + I (commanded angle - angle)``, within its torque limit. A drive that spins up with stiff gains
has its soft ones once its speed has been near a steady set-point for a while, without a jump of the torque.

Forces at the bit are shared through `drill_twin.physics.model.bit`.

Constraints and loads of the bit act along and across the hole there, and a curved hole does not run along z at the bit.
So the bit's rows and columns of the system are rotated into that frame before its loads and constraints are added, and
its Newton step is rotated back. In a straight hole the rotation is the identity, and exact.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model import SPIN, Axis
from drill_twin.physics.model.bit import BIT_WEIGHT, HOOK, TOP_TORQUE, WEIGHT, WEIGHT_DAMPING, Bit

WEIGHT_ON_BIT, ROTATION, BLOCK_SPEED = 0, 1, 2
BIT, TOP, RESIDUAL = 0, 1, 7  # indices into the array of the ends, shape (2, 7, 8)

# Indices into Drive.memory: angle by which the top lags its command [rad]; of the current step the top's angle and
# speed at its start and the commanded speed at its middle.
LAG, START_ANGLE, START_SPEED, COMMAND = 0, 1, 2, 3
# Of a drive that spins up: set-point about which the command is steady [rad/s], time that the speed is near it [s].
AIM, STEADY = 4, 5
# With a block: its place above the top at rest, without load [m]; of the current step the top's place at its start [m],
# the block's speed [m/s] and the weight to hold [N]; speed that the auto-driller asks for, and its integral part [m/s];
# mean torque on the string [N m].
PLACE, START_PLACE, SPEED, HELD, FEED, INTEGRAL, TURNING = 6, 7, 8, 9, 10, 11, 12
NEAR = 0.1
"""Share of the set-point: change from which the drive spins up, and least error of speed that keeps it stiff. Chosen:
stick-slip moves a stiff drive by 5 % (`drill_twin_evidence.validation.soft_drive`)."""
SLOWEST = 0.1
"""Least set-point to take a share of [rad/s]; chosen."""
SHARE = 0.05  # of the set-points, below which weight and torque have no ratio


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
    memory: Array  # (6,) see LAG, or (13,) with a block, see PLACE
    bit: Bit
    lines: float  # stiffness of the drilling lines [N/m]; 0: no block
    rate: float  # fastest motion of the block by the auto-driller [m/s]; 0: no auto-driller
    feed_gain: float  # its speed per error of weight [m/(N s)]
    feed_integral: float  # its acceleration per error of weight [m/(N s2)]
    held_torque: float  # torque on the string that it holds [N m]; infinite: none
    spin_up: Pair  # stiff gains, as `proportional` and `integral`
    wait: float  # time near a steady set-point after which the stiff gains end [s]; 0: there are none
    cancelled: float  # inertia whose torque the motor adds without them [kg m2]


@kernel
def rig_end_load(drive: Drive, command: Array, half_step: float, u: Array, v: Array, v_old: Array, ends: Array) -> None:
    """Add the forces of the rig to the residual: compression is positive, and so is right-handed torque."""
    bit = drive.bit
    for c in range(7):
        bit.start[c] = u[0, c] - half_step * v[0, c]
    bit.now[WEIGHT_DAMPING] = 0.0
    if drive.lines > 0.0:
        hoist(drive, command, half_step, u, v, ends)
    elif drive.from_top > 0.0:
        ends[TOP, 2, RESIDUAL] += command[WEIGHT_ON_BIT]
        bit.now[WEIGHT] = command[WEIGHT_ON_BIT] + drive.hanging
    else:
        ends[BIT, 2, RESIDUAL] -= command[WEIGHT_ON_BIT]
        bit.now[WEIGHT] = command[WEIGHT_ON_BIT]
    if drive.driven > 0.0:
        last = u.shape[0] - 1
        speed, memory = v[last, SPIN], drive.memory
        memory[START_ANGLE], memory[START_SPEED] = u[last, SPIN] - half_step * speed, v_old[last, SPIN]
        memory[COMMAND] = command[ROTATION]
        lag = half_step * (command[ROTATION] - speed)
        torque = motor(drive, lag / half_step, memory[LAG] + lag)
        proportional, integral = gains(drive)
        slope = proportional + half_step * integral if abs(torque) < drive.limit else 0.0
        inertia = felt_inertia(drive)
        own = drive.damping + inertia / half_step
        ends[TOP, SPIN, SPIN] += slope + own
        ends[TOP, SPIN, RESIDUAL] -= torque - drive.damping * speed - inertia * (speed - v_old[last, SPIN]) / half_step


@kernel
def hoist(drive: Drive, command: Array, half_step: float, u: Array, v: Array, ends: Array) -> None:
    """Add the pull of the lines; the rock alone puts weight on the bit."""
    memory, last = drive.memory, u.shape[0] - 1
    memory[START_PLACE] = u[last, 2] - half_step * v[last, 2]
    memory[SPEED] = memory[FEED] if drive.rate > 0.0 else command[BLOCK_SPEED]
    memory[HELD] = command[WEIGHT_ON_BIT]
    ends[TOP, 2, RESIDUAL] -= drive.lines * (memory[PLACE] + half_step * memory[SPEED] - u[last, 2])
    ends[TOP, 2, 2] += half_step * drive.lines
    drive.bit.now[WEIGHT] = 0.0


@kernel
def move_block(drive: Drive, step: float, top: float) -> None:
    """Move the block by a step that took the top to a height [m], add the impulse of the lines, and set the next feed.

    The integral part does not grow while the feed is at its limit and would be driven beyond (conditional integration).
    """
    memory = drive.memory
    middle = memory[PLACE] + 0.5 * step * memory[SPEED]
    pull = drive.lines * (middle - 0.5 * (memory[START_PLACE] + top))
    drive.bit.impulse[HOOK] += step * pull
    memory[PLACE] += step * memory[SPEED]
    if drive.rate > 0.0:
        weight = drive.hanging - pull
        error = memory[HELD] - weight
        if drive.held_torque < np.inf:  # as a weight, by the ratio at present; off bottom by the set-points' ratio
            torque = abs(memory[TURNING])
            ratio = (max(weight, 0.0) + SHARE * memory[HELD]) / (torque + SHARE * drive.held_torque)
            error = min(error, ratio * (drive.held_torque - torque))
        more = step * drive.feed_integral * error
        feed = drive.feed_gain * error + memory[INTEGRAL] + more
        if abs(feed) < drive.rate or feed * more < 0.0:
            memory[INTEGRAL] += more
        memory[FEED] = -max(-drive.rate, min(drive.rate, feed))


@kernel
def gains(drive: Drive) -> Pair:
    """Gains of the motor at present [N m s/rad], [N m/rad]."""
    return (drive.proportional, drive.integral) if drive.memory[STEADY] >= drive.wait else drive.spin_up


@kernel
def felt_inertia(drive: Drive) -> float:
    """Inertia of the drive that the string feels at present [kg m2]."""
    return drive.inertia - drive.cancelled if drive.memory[STEADY] >= drive.wait else drive.inertia


@kernel
def watch_set_point(drive: Drive, step: float, error: float) -> None:
    """Choose the gains by the set-point and the error of speed [rad/s]; where they change, the torque stays."""
    memory, before = drive.memory, gains(drive)
    size = max(abs(memory[COMMAND]), SLOWEST)
    if abs(memory[COMMAND] - memory[AIM]) > NEAR * size:
        memory[AIM], memory[STEADY] = memory[COMMAND], 0.0
    elif memory[STEADY] < drive.wait:
        memory[STEADY] = memory[STEADY] + step if abs(error) < NEAR * size else 0.0
    after = gains(drive)
    if after != before:
        memory[AIM] = memory[COMMAND]
        memory[LAG] = ((before[0] - after[0]) * error + before[1] * memory[LAG]) / after[1]


@kernel
def motor(drive: Drive, error: float, lag: float) -> float:
    """Torque of the motor for an error of speed [rad/s] and of angle [rad], within its limit [N m]."""
    proportional, integral = gains(drive)
    torque = proportional * error + integral * lag
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
        accelerating = felt_inertia(drive) * (v[last, SPIN] - memory[START_SPEED])
        bit.impulse[TOP_TORQUE] += step * (torque - drive.damping * speed) - accelerating
        if drive.rate > 0.0:  # a mean over the response of the weight, as torque vibrates
            turning = torque - drive.damping * speed - accelerating / step
            share = min(2.0 * step * drive.feed_integral / drive.feed_gain, 1.0)
            memory[TURNING] += share * (turning - memory[TURNING])
        if drive.wait > 0.0:
            watch_set_point(drive, step, lag / step)
    if drive.lines > 0.0:
        move_block(drive, step, u[u.shape[0] - 1, 2])


@kernel
def set_points(first: Array, second: Array, share: float, out: Array) -> None:
    """Set-points between two commands, linearly."""
    for k in range(out.shape[0]):
        out[k] = first[k] + share * (second[k] - first[k])


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
        turn_row(frame, own[:, j])
        turn_row(frame, upper[:, j])
    for i in range(7):
        turn_row(frame, own[i])
        turn_row(frame, lower[i])
