# SPDX-License-Identifier: Apache-2.0
"""Encoding of frames and set-points to messages, and reading of set-points and rig states."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.errors import MessageError
from drill_twin.io.messages.cdr import ClockTemplate, Float64Template, JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.finite import check_finite, finite_number
from drill_twin.io.messages.geometry import StringGeometry, default_exaggeration
from drill_twin.io.messages.markers import MarkerArrayTemplate
from drill_twin.io.messages.pose import orientation
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import (
    FLOAT64,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    STRING,
    STRING_MARKERS,
    STRING_POSES,
    WOB_COMMAND,
)
from drill_twin.io.messages.type_store import message, serialize
from drill_twin.schedule.command import Command
from drill_twin.twin.frame import Frame, RigState

MARK_AXES = ("x", "y", "z", "spin")
RIG_JOINTS = ("top_drive", "bit", "block", "bit_torque")
COMMAND_JOINTS = ("bit", "top_drive")


class CommandEncoder:
    """Encoder of `/rig/command`, `/rig/wob_command` and `/rig/rps_command`.

    Raises:
        MessageError: Raised by all methods for a set-point that is not finite.
    """

    def __init__(self) -> None:
        self._both = JointStateTemplate(COMMAND_JOINTS)
        self._one = Float64Template()

    def command(self, stamp: int, command: Command) -> bytes:
        """Both set-points at a stamp [ns], as a JointState; all other fields are NaN."""
        weight = finite_number(RIG_COMMAND, "weight on bit", command.weight_on_bit)
        rotation = finite_number(RIG_COMMAND, "rotation", command.rotation)
        return self._both.fill(stamp, (np.nan, np.nan), (np.nan, rotation), (weight, np.nan))

    def wob_command(self, command: Command) -> bytes:
        """Weight on bit [N] as a Float64."""
        return self._one.fill(finite_number(WOB_COMMAND, "weight on bit", command.weight_on_bit))

    def rps_command(self, command: Command) -> bytes:
        """Top-drive speed [rev/s] as a Float64."""
        return self._one.fill(finite_number(RPS_COMMAND, "rotation", command.rotation) / math.tau)


class TwinEncoder:
    """Encoder of the simulator's topics, for frames of one scene; sizes are fixed by the geometry.

    Raises:
        MessageError: Raised by all methods for a frame with a number that is not finite.
    """

    def __init__(self, geometry: StringGeometry) -> None:
        self._geometry = geometry
        self._marks = len(geometry.mark_names)
        self._poses = PoseArrayTemplate(geometry.node_count)
        self._quaternions = np.empty((geometry.node_count, 4))
        self._mark_state = JointStateTemplate([f"{name}/{axis}" for name in geometry.mark_names for axis in MARK_AXES])
        self._mark_values = np.zeros((3, self._marks, len(MARK_AXES)))
        self._rig = JointStateTemplate(RIG_JOINTS)
        self._clock = ClockTemplate()
        self._exaggeration = default_exaggeration(geometry)
        self._markers: MarkerArrayTemplate | None = None

    def poses(self, frame: Frame) -> bytes:
        """`/string/poses`."""
        turned = orientation(frame.tangents, frame.spin, self._quaternions)
        check_finite(STRING_POSES, frame.positions)
        check_finite(STRING_POSES, turned)
        return self._poses.fill(stamp_ns(frame.time), frame.positions, turned)

    def marks(self, frame: Frame) -> bytes:
        """`/marks/state`; the wall pushes a mark's section towards the axis of the hole."""
        marks, (position, velocity, effort) = frame.marks, self._mark_values
        position[:, :3], position[:, 3] = marks.position, marks.spin
        velocity[:, :3], velocity[:, 3] = marks.velocity, marks.spin_rate
        outwards = marks.centre[:, :2]
        radius = np.maximum(np.hypot(outwards[:, 0], outwards[:, 1]), np.finfo(float).tiny)
        effort[:, :2] = -(marks.wall_force / radius)[:, None] * outwards
        check_finite(MARKS_STATE, self._mark_values)
        return self._mark_state.fill(stamp_ns(frame.time), *self._mark_values.reshape(3, -1))

    def rig_state(self, frame: Frame) -> bytes:
        """`/rig/state`."""
        rig = frame.rig
        values = np.array(
            (
                (rig.top_drive_angle, rig.bit_angle, rig.block_position, rig.bit_angle),
                (rig.top_drive_speed, rig.bit_speed, rig.block_velocity, rig.bit_speed),
                (rig.top_drive_torque, rig.bit_force, rig.hookload, rig.bit_torque),
            )
        )
        check_finite(RIG_STATE, values)
        return self._rig.fill(stamp_ns(frame.time), *values)

    def markers(self, frame: Frame, exaggeration: float | None = None) -> bytes:
        """`/string/markers`, with this factor on lateral motion; by default `default_exaggeration`."""
        wanted = self._exaggeration if exaggeration is None else exaggeration
        if self._markers is None or wanted != self._exaggeration:
            self._exaggeration = wanted
            self._markers = MarkerArrayTemplate(self._geometry, wanted)
        for values in (frame.positions, frame.marks.position, frame.wall_force):
            check_finite(STRING_MARKERS, values)
        return self._markers.fill(stamp_ns(frame.time), frame.positions, frame.marks.position, frame.wall_force)

    def clock(self, time: float) -> bytes:
        """`/clock` of a simulated time [s]."""
        return self._clock.fill(stamp_ns(time))


def encode_string(text: str) -> bytes:
    """CDR of a std_msgs/String, as on `/twin/scene`."""
    return serialize(message(STRING, data=text), STRING)


def encode_float64(value: float) -> bytes:
    """CDR of a std_msgs/Float64, as on `/twin/realtime_factor`."""
    return serialize(message(FLOAT64, data=value), FLOAT64)


def read_command(state: JointState) -> Command:
    """Set-points of a `/rig/command`, without a check of their range.

    Raises:
        MessageError: One of the two set-points is missing.
    """
    if not state.effort.size or not state.velocity.size:
        raise MessageError("expected a /rig/command with velocity and effort, found one of them empty")
    return Command(
        weight_on_bit=float(state.effort[state.index("bit")]),
        rotation=float(state.velocity[state.index("top_drive")]),
    )


def read_rig_state(state: JointState) -> RigState:
    """Rig state of a `/rig/state`.

    Raises:
        MessageError: A joint or an array is missing.
    """
    if not (state.position.size and state.velocity.size and state.effort.size):
        raise MessageError("expected a /rig/state with position, velocity and effort, found one of them empty")
    drive, bit, block, torque = (state.index(name) for name in RIG_JOINTS)
    return RigState(
        top_drive_angle=float(state.position[drive]),
        top_drive_speed=float(state.velocity[drive]),
        top_drive_torque=float(state.effort[drive]),
        bit_angle=float(state.position[bit]),
        bit_speed=float(state.velocity[bit]),
        bit_torque=float(state.effort[torque]),
        bit_force=float(state.effort[bit]),
        block_position=float(state.position[block]),
        block_velocity=float(state.velocity[block]),
        hookload=float(state.effort[block]),
    )
