# SPDX-License-Identifier: Apache-2.0
"""Messages of the rig: encoding and reading of set-points, reading of `/rig/state`."""

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import RIG_CHANNELS, RIG_JOINTS
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.messages.cdr import JointStateTemplate, finite_number
from drill_twin.io.messages.decode import JointArrays, JointState
from drill_twin.io.messages.encode import encode_float64
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.scene.set_points.command import Command

TOP_DRIVE, BIT_AXIAL, BLOCK = COMMAND_JOINTS = ("top_drive", "bit_axial", "block")
"""Joints of a `/rig/command`: velocity of the top drive, effort of the bit along the hole, velocity of the block.

NaN stands for no set-point, as in ros2_control: what a command does not name stays, and a weight without a speed of the
block lets the block rest.
"""
DRIVER = "/rig_driver"
"""Source of the commands in a bag of a session: full name of the node that sends them where there are nodes."""
_NAMES = ("weight on bit", "rotation", "speed of the block")


class CommandEncoder:
    """Encoder of `/rig/command`, `/rig/wob_command` and `/rig/rps_command`.

    Raises:
        MessageError: Raised by all methods for a set-point that is not finite.
    """

    def __init__(self, source: str = DRIVER) -> None:
        """Make the templates.

        Args:
            source: Who commands, in `header.frame_id` of each `/rig/command`: the full name of a node.
        """
        self._all = JointStateTemplate(COMMAND_JOINTS, frame_id=source)

    def command(self, stamp: int, command: Command) -> bytes:
        """The set-points at a stamp [ns], as a JointState; all other fields are NaN."""
        return self.commands([stamp], [command])[0]

    def commands(self, stamps: Sequence[int], commands: Sequence[Command]) -> list[bytes]:
        """As `command`, at each stamp [ns]."""
        given = np.array(commands).reshape(-1, len(COMMAND_JOINTS))
        if not np.isfinite(given).all():
            for name, value in zip(_NAMES, given[~np.isfinite(given).all(axis=1)][0].tolist(), strict=True):
                finite_number(RIG_COMMAND, name, value)
        values = np.full((3, *given.shape), np.nan)
        values[2, :, 1], values[1, :, 0], values[1, :, 2] = given.T
        return self._all.rows(stamps, *values)

    def wob_command(self, command: Command) -> bytes:
        """Weight on bit [N] as a Float64."""
        return encode_float64(finite_number(WOB_COMMAND, "weight on bit", command.weight_on_bit))

    def rps_command(self, command: Command) -> bytes:
        """Top-drive speed [rev/s] as a Float64."""
        return encode_float64(finite_number(RPS_COMMAND, "rotation", command.rotation) / math.tau)


def read_command(state: JointState) -> Command:
    """Set-points of a `/rig/command`, as `read_commands`."""
    return Command(*read_commands(state).tolist())


def read_commands(states: JointArrays) -> Array:
    """Set-points of `/rig/command`, NaN where it has none, without a check of their range.

    A weight without a speed of the block lets the block rest.

    Returns:
        Weight on bit [N], speed of the top drive [rad/s] and of the block [m/s], shape (..., 3).

    Raises:
        MessageError: The message has none of the joints, or another joint for the weight.
    """
    if "bit" in states.names and BIT_AXIAL not in states.names:
        raise MessageError(
            f"expected the weight on bit as effort of the joint {BIT_AXIAL!r} of a /rig/command, found a joint 'bit'"
        )
    if not any(name in COMMAND_JOINTS for name in states.names):
        found = ", ".join(states.names) or "none"
        raise MessageError(f"expected a joint of {', '.join(COMMAND_JOINTS)} in /rig/command, found {found}")
    weight, block = states.column("effort", BIT_AXIAL), states.column("velocity", BLOCK)
    rests = np.isnan(block) & ~np.isnan(weight)
    return np.stack((weight, states.column("velocity", TOP_DRIVE), np.where(rests, 0.0, block)), axis=-1)


def read_measured_states(states: JointArrays) -> Array:
    """Fields of `RigState`, shape (..., 12), of a rig of which not all joints are measured: NaN without a value.

    Raises:
        MessageError: The message has none of the joints.
    """
    if not set(states.names) & set(RIG_JOINTS):
        raise MessageError(f"expected joints of {', '.join(RIG_JOINTS)}, found {', '.join(states.names) or 'none'}")
    channels = (RIG_CHANNELS[field] for field in RigState._fields)
    return np.stack([states.column(channel.array, channel.joint) for channel in channels], axis=-1)


def read_rig_state(state: JointState) -> RigState:
    """State of a `/rig/state`, as `read_rig_states`."""
    return RigState(*read_rig_states(state).tolist())


def read_rig_states(states: JointArrays) -> Array:
    """Fields of `RigState`, shape (..., 12), of `/rig/state`.

    Raises:
        MessageError: A joint or an array is missing.
    """
    if not (states.position.size and states.velocity.size and states.effort.size):
        raise MessageError("expected a /rig/state with position, velocity and effort, found one of the arrays empty")
    for joint in RIG_JOINTS:
        states.index(joint)
    return read_measured_states(states)
