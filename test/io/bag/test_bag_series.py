# SPDX-License-Identifier: Apache-2.0
"""Arrays of a topic hold the recorded numbers."""

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.core.errors import MessageError
from drill_twin.io.bag.series import CommandSeries, MarkSeries, PoseSeries, RigSeries, WhirlSeries
from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.encode import MARK_AXES, TwinEncoder
from drill_twin.io.messages.stamps import header
from drill_twin.io.messages.topic_row import JOINT_STATE
from drill_twin.io.messages.topics import MARKS_STATE, RIG_COMMAND, RIG_STATE, STRING_POSES, WHIRL_STATE
from drill_twin.io.messages.type_store import message, serialize

MARKS = ("mark_1", "mark_2", "mark_3", "mark_4")
SERIES = {
    MARKS_STATE: MarkSeries,
    RIG_STATE: RigSeries,
    RIG_COMMAND: CommandSeries,
    STRING_POSES: PoseSeries,
    WHIRL_STATE: WhirlSeries,
}


@pytest.fixture
def read(messages):
    """The messages of the made-up bag on a topic as a series."""

    def series(topic):
        found = SERIES[topic]()
        for name, _, raw in messages:
            if name == topic:
                found.add_message(raw)
        return found

    return series


def test_poses(read, frames):
    poses = read(STRING_POSES)
    np.testing.assert_allclose(poses.time, [frame.time for frame in frames], rtol=1e-15)
    np.testing.assert_array_equal(poses.position, [frame.positions for frame in frames])
    np.testing.assert_allclose(poses.tangent, [frame.tangents for frame in frames], atol=1e-12)


def test_spin_is_unwrapped(make_frame, make_geometry):
    """Three quarters of a turn from one sample to the next."""
    encoder, poses = TwinEncoder(make_geometry(11)), PoseSeries()
    for k in range(200):
        frame = make_frame(11, time=0.01 * k)
        poses.add_message(encoder.poses(frames_of(frame._replace(spin=np.full(11, 1.5 * np.pi * k))))[0])
    np.testing.assert_allclose(poses.spin[-1] - poses.spin[0], 1.5 * np.pi * 199)


def test_one_pose_of_several_is_kept(messages):
    poses = PoseSeries(every=7)
    for name, _, raw in messages:
        if name == STRING_POSES:
            poses.add_message(raw)
    np.testing.assert_array_equal(poses.stamp, np.arange(0, 40, 7) * 10_000_000)


def test_marks(read, frames):
    marks = read(MARKS_STATE)
    assert marks.names == MARKS
    for name in ("position", "velocity", "spin", "spin_rate"):
        np.testing.assert_array_equal(getattr(marks, name), [getattr(frame.marks, name) for frame in frames])
    force = np.linalg.norm(marks.wall_force, axis=-1)
    np.testing.assert_allclose(force, [frame.marks.wall_force for frame in frames], rtol=1e-14)


def test_rig(read, frames):
    rig = read(RIG_STATE)
    for name in frames[0].rig._fields:
        np.testing.assert_array_equal(getattr(rig, name), [getattr(frame.rig, name) for frame in frames])


def test_commands(read):
    commands = read(RIG_COMMAND)
    np.testing.assert_array_equal(commands.weight_on_bit, np.full(40, 40.0))
    np.testing.assert_array_equal(commands.rotation, np.full(40, 4.0 * np.pi))


def test_whirl(read, frames):
    whirl = read(WHIRL_STATE)
    assert whirl.names == MARKS
    for values in (whirl.orbit_radius, whirl.precession_rad_s, whirl.ratio, whirl.confidence, whirl.motion):
        np.testing.assert_allclose(values, np.tile([[frame.time] for frame in frames], 4), rtol=1e-15)


@pytest.mark.parametrize("series", SERIES.values())
def test_empty_series(series):
    assert len(series()) == series().time.size == 0


def test_repeated_and_late_stamps_are_left_out():
    template, rig = JointStateTemplate(["top_drive"]), RigSeries()
    for stamp in (5, 9, 9, 7, 10):
        rig.add_message(template.fill(stamp, [0.0], [float(stamp)], [0.0]))
    assert rig.top_drive_speed.tolist() == [5.0, 9.0, 10.0]


def test_another_rig_gives_its_speeds():
    rig = RigSeries()
    rig.add_message(JointStateTemplate(["bit", "top_drive"], effort=False).fill(1, (0.0, 0.0), (2.0, 3.0)))
    assert (rig.top_drive_speed.tolist(), rig.bit_speed.tolist()) == ([3.0], [2.0])
    assert np.isnan(rig.bit_force).all()


def test_marks_of_a_camera_have_x_and_y_alone():
    marks = MarkSeries()
    marks.add_message(JointStateTemplate(["a/y", "a/x"], velocity=False, effort=False).fill(1, (2.0, 1.0)))
    np.testing.assert_array_equal(marks.position, [[[1.0, 2.0, np.nan]]])
    assert np.isnan([marks.spin, marks.spin_rate]).all()
    assert np.isnan(marks.wall_force).all()


def test_joints_in_another_order_are_the_same_marks():
    names = [f"{mark}/{axis}" for mark in "ab" for axis in MARK_AXES]
    values, marks = np.arange(8.0), MarkSeries()
    marks.add_message(JointStateTemplate(names).fill(1, values, values, values))
    marks.add_message(JointStateTemplate(names[::-1]).fill(2, *[values[::-1]] * 3))
    np.testing.assert_array_equal(marks.values[0], marks.values[1])


def test_the_layout_of_most_messages_counts_also_where_another_comes_first():
    poses, marks = PoseSeries(), MarkSeries()
    for stamp, nodes in ((1, 4), (2, 3), (3, 3)):
        poses.add_message(PoseArrayTemplate(nodes).fill(stamp, np.zeros((nodes, 3)), np.zeros((nodes, 4))))
    assert (poses.stamp.tolist(), poses.position.shape) == ([2, 3], (2, 3, 3))
    assert [(first, count) for first, count, _ in poses.other_layouts()] == [(1, 1)]
    for stamp, mark in ((1, "b"), (2, "a"), (3, "a")):
        marks.add_message(JointStateTemplate([f"{mark}/x", f"{mark}/y"]).fill(stamp, *np.zeros((3, 2))))
    assert (marks.stamp.tolist(), marks.names) == ([2, 3], ("a",))
    assert [reason for *_, reason in marks.other_layouts()] == [
        "expected a as in most messages, found b; of another scene"
    ]


@pytest.mark.parametrize("topic", SERIES)
def test_bytes_that_are_no_message(topic):
    with pytest.raises(MessageError, match="expected the CDR bytes of a") as caught:
        SERIES[topic]().add_message(b"\0\1\0\0rubbish")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("topic", [MARKS_STATE, RIG_STATE, RIG_COMMAND, WHIRL_STATE])
@pytest.mark.parametrize("names", [["a"], ["mark_1/x"], ["mark_1/orbit_radius"], ["bit"]])
def test_other_joints_are_refused(topic, names):
    with pytest.raises(MessageError, match="expected"):
        SERIES[topic]().add_message(JointStateTemplate(names).fill(0, *np.ones((3, len(names)))))


def test_marks_without_positions_are_refused():
    empty = np.zeros(0)
    content = message(
        JOINT_STATE, header=header(1, "hole"), name=["a/x", "a/y"], position=empty, velocity=empty, effort=empty
    )
    with pytest.raises(MessageError, match="expected x, y, z and spin of marks, found a/x, a/y"):
        MarkSeries().add_message(serialize(content, JOINT_STATE))
