# SPDX-License-Identifier: Apache-2.0
"""Encoding of frames to the messages of the simulator."""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.rig_channels import ARRAYS, RIG_CHANNELS, RIG_JOINTS
from drill_twin.dynamics.twin.frame import Frames, RigState
from drill_twin.io.messages.cdr import ClockTemplate, JointStateTemplate, PoseArrayTemplate, check_finite
from drill_twin.io.messages.drawing.geometry import StringGeometry, default_exaggeration
from drill_twin.io.messages.drawing.markers import MarkerArrayTemplate
from drill_twin.io.messages.drawing.transforms import orientation
from drill_twin.io.messages.stamps import stamps_ns
from drill_twin.io.messages.topic_row import FLOAT64, STRING
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_MARKERS, STRING_POSES, STRING_STRESS
from drill_twin.io.messages.type_store import message, serialize
from drill_twin.physics.model.section_stress import SCALARS

MARK_AXES = ("x", "y", "z", "spin")
_FIELDS = {(channel.array, channel.joint): field for field, channel in RIG_CHANNELS.items()}
RIG_COLUMNS = np.array([[RigState._fields.index(_FIELDS[array, joint]) for joint in RIG_JOINTS] for array in ARRAYS])
"""Field of `RigState` in position, velocity and effort of each joint of `/rig/state`, shape (3, 4)."""


class TwinEncoder:
    """Encoder of the simulator's topics, for frames of one scene; sizes are fixed by the geometry.

    Each method gives one message a frame.

    Raises:
        MessageError: Raised by all methods for a frame with a number that is not finite.
    """

    def __init__(self, geometry: StringGeometry) -> None:
        self._geometry = geometry
        self._poses = PoseArrayTemplate(len(geometry.node_distances), geometry.frame_id)
        joints = [f"{name}/{axis}" for name in geometry.mark_names for axis in MARK_AXES]
        self._mark_state = JointStateTemplate(joints, frame_id=geometry.frame_id)
        sections = [f"{name}/{scalar}" for name in geometry.section_names for scalar in SCALARS]
        self._stress = JointStateTemplate(sections, velocity=False, effort=False, frame_id=geometry.frame_id)
        self._rig = JointStateTemplate(RIG_JOINTS, frame_id=geometry.frame_id)
        self._clock = ClockTemplate()
        self._exaggeration = default_exaggeration(geometry.length, geometry.hole_radius)
        self._markers: MarkerArrayTemplate | None = None

    def poses(self, frames: Frames) -> list[bytes]:
        """`/string/poses`."""
        turned = orientation(frames.tangents, frames.spin)
        check_finite(STRING_POSES, frames.positions)
        check_finite(STRING_POSES, turned)
        return self._poses.rows(stamps_ns(frames.time), frames.positions, turned)

    def marks(self, frames: Frames) -> list[bytes]:
        """`/marks/state`."""
        marks = frames.marks
        values = np.zeros((3, *marks.spin.shape, len(MARK_AXES)))
        values[0, ..., :3], values[0, ..., 3] = marks.position, marks.spin
        values[1, ..., :3], values[1, ..., 3] = marks.velocity, marks.spin_rate
        values[2, ..., :2] = wall_push(marks.centre, marks.wall_force)
        check_finite(MARKS_STATE, values)
        return self._mark_state.rows(stamps_ns(frames.time), *values)

    def stress(self, frames: Frames) -> list[bytes]:
        """`/string/stress` of a scene with `fatigue`."""
        values = np.zeros((len(frames.time), 0)) if frames.stress is None else frames.stress
        check_finite(STRING_STRESS, values.reshape(len(values), -1))
        return self._stress.rows(stamps_ns(frames.time), values)

    def rig_state(self, frames: Frames) -> list[bytes]:
        """`/rig/state`."""
        values = frames.rig[:, RIG_COLUMNS]
        check_finite(RIG_STATE, values)
        return self._rig.rows(stamps_ns(frames.time), *values.swapaxes(0, 1))

    def markers(self, frames: Frames, exaggeration: float | None = None) -> list[bytes]:
        """`/string/markers`, with this factor on lateral motion; by default `default_exaggeration`."""
        wanted = self._exaggeration if exaggeration is None else exaggeration
        if self._markers is None or wanted != self._exaggeration:
            self._exaggeration = wanted
            self._markers = MarkerArrayTemplate(self._geometry, wanted)
        for values in (frames.positions, frames.marks.position, frames.wall_force):
            check_finite(STRING_MARKERS, values)
        return self._markers.rows(stamps_ns(frames.time), frames.positions, frames.marks.position, frames.wall_force)

    def clock(self, time: Array) -> list[bytes]:
        """`/clock` of simulated times [s], shape (F,)."""
        return self._clock.rows(stamps_ns(time))


def wall_push(centre: Array, wall_force: Array) -> Array:
    """Force of the wall on the string at marks across the hole [N], shape (..., m, 2): towards the axis of the hole.

    A mark on the axis has no direction to the wall: its force is 0.

    Args:
        centre: Positions of the centre line from the axis [m], shape (..., m, 3).
        wall_force: Normal forces [N], shape (..., m).
    """
    outwards = centre[..., :2]
    radius = np.maximum(np.hypot(outwards[..., 0], outwards[..., 1]), np.finfo(float).tiny)
    return np.asarray(-wall_force[..., None] * (outwards / radius[..., None]))  # direction first: a force may overflow


def encode_string(text: str) -> bytes:
    """CDR of a std_msgs/String, as on `/twin/scene`."""
    return serialize(message(STRING, data=text), STRING)


def encode_float64(value: float) -> bytes:
    """CDR of a std_msgs/Float64, as on `/twin/realtime_factor`."""
    return serialize(message(FLOAT64, data=value), FLOAT64)
