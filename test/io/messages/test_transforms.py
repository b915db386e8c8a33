# SPDX-License-Identifier: Apache-2.0
"""Transforms for tf2: positions and orientations of bit and marks, and the bytes of the message."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.dynamics.sensors.motion import sub_motion
from drill_twin.dynamics.sensors.subs import places_of, subs_of
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.decode import read_joint_state, read_pose_array
from drill_twin.io.messages.drawing.transforms import StringTransforms, static_message
from drill_twin.io.messages.encode import TwinEncoder
from drill_twin.io.messages.stamps import header_stamp, stamp_ns
from drill_twin.io.messages.topic_row import MARKER_ARRAY, TF_TYPE
from drill_twin.io.messages.type_store import deserialize
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.physics.model.strain import transverse_axes
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command


class Transform(NamedTuple):
    """A transform of a message."""

    parent: str
    child: str
    stamp: int
    translation: np.ndarray
    rotation: np.ndarray


def transforms_of(raw):
    """The transforms that a message of tf holds."""
    read = deserialize(raw, TF_TYPE).transforms
    for one in read:
        place, turn = one.transform.translation, one.transform.rotation
        yield Transform(
            one.header.frame_id, one.child_frame_id, header_stamp(one),
            np.array([place.x, place.y, place.z]), np.array([turn.x, turn.y, turn.z, turn.w]),
        )  # fmt: skip


def turned(quaternion, vector):
    """The vector, turned."""
    axis, scalar = quaternion[:3], quaternion[3]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + scalar * vector)


def test_bit_and_marks_are_where_the_topics_say(make_frame, make_geometry):
    geometry = make_geometry(11)
    frame = make_frame(nodes=11)
    transforms = list(transforms_of(StringTransforms(geometry).message(frame)))
    assert [one.child for one in transforms] == ["bit", *geometry.mark_names]
    assert {(one.parent, one.stamp) for one in transforms} == {("hole", stamp_ns(frame.time))}
    poses = read_pose_array(TwinEncoder(geometry).poses(frames_of(frame))[0])
    np.testing.assert_array_equal(transforms[0].translation, poses.position[0])
    np.testing.assert_allclose(transforms[0].rotation, poses.orientation[0], atol=1e-12)
    np.testing.assert_array_equal([one.translation for one in transforms[1:]], frame.marks.position)
    for one in transforms:
        assert np.linalg.norm(one.rotation) == pytest.approx(1.0, abs=1e-12)


def test_a_mark_is_turned_with_the_spin_of_its_section(make_frame, make_geometry):
    geometry, frame = make_geometry(11), make_frame(nodes=11)
    upright = np.broadcast_to([0.0, 0.0, 1.0], frame.tangents.shape)
    frame = frame._replace(tangents=upright)
    _, *marks = transforms_of(StringTransforms(geometry).message(frame))
    for one, spin in zip(marks, frame.marks.spin, strict=True):
        np.testing.assert_allclose(
            turned(one.rotation, np.array([1.0, 0.0, 0.0])), [np.cos(spin), np.sin(spin), 0.0], atol=1e-12
        )


def test_a_sub_is_where_its_sensor_is_with_the_axes_of_its_readings():
    """As the readings are computed, from shape functions and by another formula for the axes."""
    at = "distance_from_bit: 1700 mm, radius: 6 mm, rate: 100 Hz"
    scene = load_scene("pa6_bench", overrides={
        "sensors": f"{{subs: [{{name: low, {at}, angle: 40 deg}}, {{name: mark_2, {at}}}]}}",
        "effects.bow.amplitude": "3 mm", "numerics.elements": "12"})  # fmt: skip
    twin = Twin(scene)
    for _ in range(20):
        frame = twin.advance(Command(40.0, 20.0), 0.01)
    transforms = {
        one.child: one
        for one in transforms_of(StringTransforms(string_geometry(twin.scene, twin.rod.arc)).message(frame))
    }
    assert list(transforms) == ["bit", *(mark.name for mark in scene.string.marks), "low"]  # mark_2 has its place
    places, (u, v) = places_of(subs_of(scene), twin.rod), twin.unknowns
    motion, low = sub_motion(places, u, v), places.element[0]
    x, y = transverse_axes(motion.tangent)
    outwards = (np.cos(motion.spin)[:, None] * x + np.sin(motion.spin)[:, None] * y)[0]
    ends = np.stack([u[low, 0:3], u[low, 3:6], u[low + 1, 0:3], u[low + 1, 3:6]])
    where = places.shape[0, 0] @ ends + 0.006 * outwards
    found = transforms["low"]
    np.testing.assert_allclose(turned(found.rotation, np.array([1.0, 0.0, 0.0])), outwards, atol=1e-4)
    np.testing.assert_allclose(turned(found.rotation, np.array([0.0, 0.0, 1.0])), motion.tangent[0], atol=1e-4)
    np.testing.assert_allclose(found.translation, where, atol=1e-5)


def test_plus_x_of_an_inclined_hole_is_its_low_side():
    """As gravity acts: along (sin i, 0, -cos i) of the hole."""
    (hole,) = transforms_of(static_message(0.3, ""))
    plumb = turned(hole.rotation, np.array([np.sin(0.3), 0.0, -np.cos(0.3)]))
    np.testing.assert_allclose(plumb, [0.0, 0.0, -1.0], atol=1e-12)
    assert (hole.parent, hole.child) == ("rig", "hole")


def test_frames_of_a_prefix_are_those_of_the_messages(make_geometry, make_frame):
    """Two twins can then share a tf tree: every frame and every header has the prefix."""
    geometry, frame = replace(make_geometry(11), frame_prefix="rig2/"), make_frame(nodes=11)
    encoder = TwinEncoder(geometry)
    for raw in (encoder.marks(frames_of(frame))[0], encoder.rig_state(frames_of(frame))[0]):
        assert read_joint_state(raw).frame_id == "rig2/hole"
    markers = deserialize(encoder.markers(frames_of(frame))[0], MARKER_ARRAY).markers
    assert {marker.header.frame_id for marker in markers} == {"rig2/hole"}
    messages = static_message(0.3, geometry.frame_prefix), StringTransforms(geometry).message(frame)
    transforms = [one for raw in messages for one in transforms_of(raw)]
    assert {one.parent for one in transforms} == {"rig2/rig", "rig2/hole"}
    assert all(one.child.startswith("rig2/") for one in transforms)
