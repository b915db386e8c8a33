# SPDX-License-Identifier: Apache-2.0
"""Encoding of frames to the messages of the simulator."""

from __future__ import annotations

import numpy as np

from drill_twin.io.messages.cdr import ClockTemplate, JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.finite import check_finite
from drill_twin.io.messages.geometry import StringGeometry, default_exaggeration
from drill_twin.io.messages.markers import MarkerArrayTemplate
from drill_twin.io.messages.pose import orientation
from drill_twin.io.messages.rig_messages import RIG_JOINTS
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import (
    FLOAT64,
    MARKS_STATE,
    RIG_STATE,
    STRING,
    STRING_MARKERS,
    STRING_POSES,
    STRING_STRESS,
)
from drill_twin.io.messages.type_store import message, serialize
from drill_twin.model.section_stress import SCALARS
from drill_twin.twin.frame import Frame

MARK_AXES = ("x", "y", "z", "spin")


class TwinEncoder:
    """Encoder of the simulator's topics, for frames of one scene; sizes are fixed by the geometry.

    Raises:
        MessageError: Raised by all methods for a frame with a number that is not finite.
    """

    def __init__(self, geometry: StringGeometry) -> None:
        self._geometry = geometry
        self._marks = len(geometry.mark_names)
        self._poses = PoseArrayTemplate(geometry.node_count, geometry.frame_id)
        self._quaternions = np.empty((geometry.node_count, 4))
        joints = [f"{name}/{axis}" for name in geometry.mark_names for axis in MARK_AXES]
        self._mark_state = JointStateTemplate(joints, frame_id=geometry.frame_id)
        self._mark_values = np.zeros((3, self._marks, len(MARK_AXES)))
        sections = [f"{name}/{scalar}" for name in geometry.section_names for scalar in SCALARS]
        self._stress = JointStateTemplate(sections, velocity=False, effort=False, frame_id=geometry.frame_id)
        self._rig = JointStateTemplate(RIG_JOINTS, frame_id=geometry.frame_id)
        self._clock = ClockTemplate()
        self._exaggeration = default_exaggeration(geometry.length, geometry.hole_radius)
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

    def stress(self, frame: Frame) -> bytes:
        """`/string/stress` of a scene with `fatigue`."""
        values = np.zeros(0) if frame.stress is None else frame.stress.ravel()
        check_finite(STRING_STRESS, values)
        return self._stress.fill(stamp_ns(frame.time), values)

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
