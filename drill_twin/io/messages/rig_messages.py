# SPDX-License-Identifier: Apache-2.0
"""Messages of the rig: encoding and reading of set-points, reading of `/rig/state`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import RIG_CHANNELS, RIG_JOINTS
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.messages.cdr import Float64Template, JointStateTemplate
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.finite import check_rows, finite_number
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.scene.set_points.command import Command

COMMAND_JOINTS = ("bit", "top_drive")
BLOCK = "block"
"""Joint of a `/rig/command` with the velocity of the travelling block; without it the block rests."""


class CommandEncoder:
    """Encoder of `/rig/command`, `/rig/wob_command` and `/rig/rps_command`.

    Raises:
        MessageError: Raised by all methods for a set-point that is not finite.
    """

    def __init__(self) -> None:
        self._both = JointStateTemplate(COMMAND_JOINTS)
        self._all = JointStateTemplate((*COMMAND_JOINTS, BLOCK))
        self._one = Float64Template()

    def command(self, stamp: int, command: Command) -> bytes:
        """The set-points at a stamp [ns], as a JointState; all other fields are NaN. A block at rest is left out."""
        weight = finite_number(RIG_COMMAND, "weight on bit", command.weight_on_bit)
        rotation = finite_number(RIG_COMMAND, "rotation", command.rotation)
        if command.block != 0.0:
            speed = finite_number(RIG_COMMAND, "speed of the block", command.block)
            return self._all.fill(stamp, (np.nan,) * 3, (np.nan, rotation, speed), (weight, np.nan, np.nan))
        return self._both.fill(stamp, (np.nan, np.nan), (np.nan, rotation), (weight, np.nan))

    def commands(self, stamps: Sequence[int], commands: Sequence[Command]) -> list[bytes]:
        """As `command`, at each stamp [ns]."""
        if any(command.block != 0.0 for command in commands):
            return [self.command(*one) for one in zip(stamps, commands, strict=True)]
        values = np.full((3, len(commands), 2), np.nan)
        values[1, :, 1] = [command.rotation for command in commands]
        values[2, :, 0] = [command.weight_on_bit for command in commands]
        check_rows(RIG_COMMAND, values[(1, 2), :, (1, 0)])
        return self._both.rows(stamps, *values)

    def wob_command(self, command: Command) -> bytes:
        """Weight on bit [N] as a Float64."""
        return self._one.fill(finite_number(WOB_COMMAND, "weight on bit", command.weight_on_bit))

    def rps_command(self, command: Command) -> bytes:
        """Top-drive speed [rev/s] as a Float64."""
        return self._one.fill(finite_number(RPS_COMMAND, "rotation", command.rotation) / math.tau)


def read_command(state: JointState, absent_weight: float | None = None) -> Command:
    """Set-points of a `/rig/command`, without a check of their range.

    Args:
        state: The message.
        absent_weight: Weight on bit [N] where the message has no joint `bit`, as none is prescribed: of a scene whose
            block is moved by its speed. None: the joint must be there.

    Raises:
        MessageError: A set-point is missing.
    """
    weight = None if "bit" in state.names else absent_weight
    if not state.velocity.size or (weight is None and not state.effort.size):
        raise MessageError("expected a /rig/command with velocity and effort, found one of them empty")
    return Command(
        weight_on_bit=float(state.effort[state.index("bit")]) if weight is None else weight,
        rotation=float(state.velocity[state.index("top_drive")]),
        block=float(state.velocity[state.index(BLOCK)]) if BLOCK in state.names else 0.0,
    )


def read_rig_state(state: JointState) -> RigState:
    """Rig state of a `/rig/state`.

    Raises:
        MessageError: A joint or an array is missing.
    """
    if not (state.position.size and state.velocity.size and state.effort.size):
        raise MessageError("expected a /rig/state with position, velocity and effort, found one of them empty")
    at = {joint: state.index(joint) for joint in RIG_JOINTS}
    found = {field: getattr(state, channel.array)[at[channel.joint]] for field, channel in RIG_CHANNELS.items()}
    return RigState(**{field: float(value) for field, value in found.items()})
