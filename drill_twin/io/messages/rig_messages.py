# SPDX-License-Identifier: Apache-2.0
"""Messages of the rig: encoding and reading of set-points, reading of `/rig/state`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import RIG_CHANNELS, RIG_JOINTS
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.messages.cdr import Float64Template, JointStateTemplate, finite_number
from drill_twin.io.messages.decode import JointState
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
        self._one = Float64Template()

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
        return self._one.fill(finite_number(WOB_COMMAND, "weight on bit", command.weight_on_bit))

    def rps_command(self, command: Command) -> bytes:
        """Top-drive speed [rev/s] as a Float64."""
        return self._one.fill(finite_number(RPS_COMMAND, "rotation", command.rotation) / math.tau)


def read_command(state: JointState) -> Command:
    """Set-points of a `/rig/command`, NaN where it has none, without a check of their range.

    A weight without a speed of the block lets the block rest.

    Raises:
        MessageError: The message has none of the joints, or another joint for the weight.
    """
    if "bit" in state.names and BIT_AXIAL not in state.names:
        raise MessageError(
            f"expected the weight on bit as effort of the joint {BIT_AXIAL!r} of a /rig/command, found a joint 'bit'"
        )
    if not any(name in COMMAND_JOINTS for name in state.names):
        found = ", ".join(state.names) or "none"
        raise MessageError(f"expected a joint of {', '.join(COMMAND_JOINTS)} in a /rig/command, found {found}")
    velocity = dict(zip(state.names, state.velocity.tolist(), strict=False))
    effort = dict(zip(state.names, state.effort.tolist(), strict=False))
    weight, block = effort.get(BIT_AXIAL, math.nan), velocity.get(BLOCK, math.nan)
    rests = math.isnan(block) and not math.isnan(weight)
    return Command(weight, velocity.get(TOP_DRIVE, math.nan), 0.0 if rests else block)


def read_measured_state(state: JointState) -> RigState:
    """State of a rig of which not all joints are measured: NaN where the message has nothing.

    Raises:
        MessageError: The message has none of the joints.
    """
    if not set(state.names) & set(RIG_JOINTS):
        raise MessageError(f"expected joints of {', '.join(RIG_JOINTS)}, found {', '.join(state.names) or 'none'}")
    found = dict.fromkeys(RigState._fields, math.nan)
    for field, channel in RIG_CHANNELS.items():
        values = getattr(state, channel.array)
        if channel.joint in state.names and values.size:
            found[field] = float(values[state.names.index(channel.joint)])
    return RigState(**found)


def read_rig_state(state: JointState) -> RigState:
    """Rig state of a `/rig/state`.

    Raises:
        MessageError: A joint or an array is missing.
    """
    if not (state.position.size and state.velocity.size and state.effort.size):
        raise MessageError("expected a /rig/state with position, velocity and effort, found one of the arrays empty")
    at = {joint: state.index(joint) for joint in RIG_JOINTS}
    found = {field: getattr(state, channel.array)[at[channel.joint]] for field, channel in RIG_CHANNELS.items()}
    return RigState(**{field: float(value) for field, value in found.items()})
