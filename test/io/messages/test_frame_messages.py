# SPDX-License-Identifier: Apache-2.0
"""Frames and set-points are decoded as they were encoded, under the names of the contract."""

import math
from dataclasses import replace

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.core.errors import MessageError
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_clock, read_float64, read_joint_state, read_pose_array
from drill_twin.io.messages.drawing.geometry import default_exaggeration
from drill_twin.io.messages.drawing.transforms import orientation, spin_of
from drill_twin.io.messages.encode import TwinEncoder, wall_push
from drill_twin.io.messages.rig_messages import CommandEncoder, read_command, read_rig_state
from drill_twin.io.messages.stamps import seconds, stamp_ns
from drill_twin.io.messages.whirl_encode import WhirlStateEncoder
from drill_twin.scene.set_points.command import Command


@pytest.fixture
def encoder(make_geometry):
    return TwinEncoder(make_geometry())


def test_poses(encoder, make_frame):
    frame = make_frame()
    poses = read_pose_array(encoder.poses(frames_of(frame))[0])
    assert poses.stamp == 1_500_000_000
    np.testing.assert_array_equal(poses.position, frame.positions)
    np.testing.assert_allclose(np.linalg.norm(poses.orientation, axis=1), 1.0, rtol=1e-14)


def test_marks(encoder, make_frame):
    frame = make_frame()
    marks, state = frame.marks, read_joint_state(encoder.marks(frames_of(frame))[0])
    assert state.names[:5] == ("mark_1/x", "mark_1/y", "mark_1/z", "mark_1/spin", "mark_2/x")
    position, velocity, effort = (v.reshape(4, 4) for v in (state.position, state.velocity, state.effort))
    np.testing.assert_array_equal(position, np.column_stack((marks.position, marks.spin)))
    np.testing.assert_array_equal(velocity, np.column_stack((marks.velocity, marks.spin_rate)))
    np.testing.assert_allclose(np.hypot(effort[:, 0], effort[:, 1]), marks.wall_force, rtol=1e-14)
    assert (np.sum(effort[:, :2] * marks.centre[:, :2], axis=1) < 0.0).all()  # towards the axis
    np.testing.assert_array_equal(effort[:, 2:], 0.0)


def test_a_mark_on_the_axis_has_no_force(encoder, make_frame):
    frame = make_frame()
    on_axis = frame.marks._replace(centre=np.zeros((4, 3)), wall_force=np.zeros(4))
    state = read_joint_state(encoder.marks(frames_of(frame._replace(marks=on_axis)))[0])
    np.testing.assert_array_equal(state.effort, 0.0)


def test_rig_state(encoder, make_frame):
    frame = make_frame()
    state = read_joint_state(encoder.rig_state(frames_of(frame))[0])
    assert read_rig_state(state) == frame.rig
    rig = frame.rig
    # Written out: writer and reader share the table that says where a channel is.
    for array, expected in (
        (state.position, (rig.top_drive_angle, rig.bit_angle, rig.block_position, rig.drilled)),
        (state.velocity, (rig.top_drive_speed, rig.bit_speed, rig.block_velocity, rig.rate_of_penetration)),
        (state.effort, (rig.top_drive_torque, rig.bit_torque, rig.hookload, rig.bit_force)),
    ):
        found = [array[state.index(joint)] for joint in ("top_drive", "bit", "block", "bit_axial")]
        assert found == list(expected)
    assert len(set(rig[:12])) == len(rig[:12])


def test_clock(encoder):
    assert read_clock(encoder.clock(np.array([12.3456789]))[0]) == 12_345_678_900


def test_commands():
    encoder, command = CommandEncoder(), Command(weight_on_bit=40.0, rotation=4.0 * np.pi)
    state = read_joint_state(encoder.command(1_000_000_007, command))
    assert (state.stamp, read_command(state)) == (1_000_000_007, command)
    assert np.isnan(state.position).all()
    assert np.isnan(state.effort[state.index("top_drive")])
    assert read_float64(encoder.wob_command(command)) == 40.0
    assert read_float64(encoder.rps_command(command)) == 2.0


def test_a_command_in_another_order_is_understood():
    raw = JointStateTemplate(["top_drive", "extra", "bit_axial"]).fill(0, [0.0] * 3, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
    assert read_command(read_joint_state(raw)) == Command(weight_on_bit=6.0, rotation=1.0)


@pytest.mark.parametrize(
    ("names", "arrays", "given"),
    [
        (["bit_axial"], (True, True), (1.0, math.nan, 0.0)),
        (["bit_axial", "top_drive"], (True, False), (math.nan, 1.0, math.nan)),
        (["top_drive", "block"], (True, False), (math.nan, 1.0, 1.0)),
    ],
)
def test_a_part_of_a_command_is_read_and_a_weight_alone_lets_the_block_rest(names, arrays, given):
    template = JointStateTemplate(names, velocity=arrays[0], effort=arrays[1])
    ones = np.ones(len(names))
    raw = template.fill(0, ones, ones if arrays[0] else (), ones if arrays[1] else ())
    assert read_command(read_joint_state(raw)) == pytest.approx(given, nan_ok=True)


def test_half_a_rig_state_is_refused():
    raw = JointStateTemplate(["top_drive", "bit", "block"]).fill(0, np.ones(3), np.ones(3), np.ones(3))
    with pytest.raises(MessageError, match="bit_axial"):
        read_rig_state(read_joint_state(raw))


@pytest.mark.parametrize("time", [0.0, 0.1, 1e-9, 29.99, 123456.789])
def test_stamps_are_rounded_not_cut(time):
    assert seconds(stamp_ns(time)) == pytest.approx(time, abs=0.5e-9)


def test_frames_of_a_run_have_whole_stamps():
    assert [stamp_ns(0.01 * k) for k in range(3000)] == [10_000_000 * k for k in range(3000)]


@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf])
def test_a_time_that_is_none_is_refused(time):
    with pytest.raises(MessageError, match="finite time"):
        stamp_ns(time)


def test_a_stamp_that_does_not_fit_is_refused(encoder):
    with pytest.raises(MessageError, match="between"):
        encoder.clock(np.array([2.0**31]))


def test_orientation_turns_z_into_the_tangent_after_the_spin():
    from scipy.spatial.transform import Rotation

    random = np.random.default_rng(3)
    tangents = random.normal(size=(200, 3))
    tangents[:3] = [(0, 0, 1), (0, 0, -1), (1e-9, 0, -1)]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    spin = random.uniform(-2.0 * np.pi, 2.0 * np.pi, 200)
    quaternions = orientation(tangents, spin)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-6)
    np.testing.assert_allclose(Rotation.from_quat(quaternions).apply([0, 0, 1]), tangents, atol=1e-6)
    upright = orientation(np.tile([0.0, 0.0, 1.0], (200, 1)), spin)
    expected = np.column_stack((np.cos(spin), np.sin(spin), np.zeros(200)))
    np.testing.assert_allclose(Rotation.from_quat(upright).apply([1, 0, 0]), expected, atol=1e-14)
    regular = tangents[:, 2] > -0.99
    np.testing.assert_allclose(spin_of(quaternions)[regular], spin[regular], atol=1e-12)


def test_the_hole_is_drawn_about_a_tenth_as_wide_as_long(make_geometry):
    for length, radius, factor in [(8.0, 0.09, 5.0), (500.0, 0.155, 200.0), (0.5, 0.09, 1.0), (18.0, 0.09, 10.0)]:
        geometry = replace(make_geometry(), length=length, hole_radius=radius)
        assert default_exaggeration(geometry.length, geometry.hole_radius) == pytest.approx(factor)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_number_that_is_none_reaches_no_topic(encoder, make_frame, bad):
    def with_bad(name, part=None):
        frame = make_frame()
        values = getattr(frame if part is None else getattr(frame, part), name)
        values[values.shape[0] // 2] = bad
        return frame

    with pytest.raises(MessageError, match=r"/string/poses: expected finite numbers, found (nan|inf) at place 0, 25,"):
        encoder.poses(frames_of(with_bad("positions")))[0]
    for name in ("tangents", "spin"):
        with pytest.raises(MessageError, match="/string/poses"), np.errstate(invalid="ignore"):
            encoder.poses(frames_of(with_bad(name)))[0]
    for name in ("position", "velocity", "spin", "spin_rate", "wall_force", "centre"):
        with pytest.raises(MessageError, match="/marks/state"), np.errstate(invalid="ignore"):
            encoder.marks(frames_of(with_bad(name, "marks")))[0]
    for field in RigState._fields:
        frame = make_frame()
        broken = frame._replace(rig=frame.rig._replace(**{field: bad}))
        with pytest.raises(MessageError, match="/rig/state"):
            encoder.rig_state(frames_of(broken))[0]
    with pytest.raises(MessageError, match="/string/markers"):
        encoder.markers(frames_of(with_bad("wall_force")))[0]
    for command in (Command(bad, 1.0), Command(1.0, bad)):
        with pytest.raises(MessageError, match=r"/rig/command: expected a finite (weight on bit|rotation)"):
            CommandEncoder().command(0, command)
    with pytest.raises(MessageError, match="/rig/wob_command"):
        CommandEncoder().wob_command(Command(bad, 1.0))
    with pytest.raises(MessageError, match="/rig/rps_command"):
        CommandEncoder().rps_command(Command(1.0, bad))
    assert encoder.poses(frames_of(make_frame()))[0]


def test_what_is_not_known_of_whirl_may_be_nan_but_nothing_is_infinite():
    values = np.array([[[1.0, np.nan, 1.0, 1.0, 0.0]]])
    assert WhirlStateEncoder(["mark_1"]).rows([0], values)
    with pytest.raises(MessageError, match="/whirl/state: expected finite numbers, or NaN"):
        WhirlStateEncoder(["mark_1"]).rows([0], np.nan_to_num(values, nan=np.inf))


@pytest.mark.parametrize("radius", [0.0, 1e-320, 1e-310, 1e-200, 1e-12, 0.08])
@pytest.mark.parametrize("force", [0.0, 1.0, 10.0, 1e9])
def test_the_push_of_the_wall_is_finite_at_any_radius(radius, force):
    """On the axis it has no direction, off it the size of the force; `force / radius` may overflow."""
    with np.errstate(all="raise", under="ignore"):
        push = wall_push(np.array([[0.6 * radius, -0.8 * radius, 1.0]]), np.array([force]))
    assert np.isfinite(push).all()
    if radius == 0.0:
        assert not push.any()
    elif radius > 1e-300:
        assert push == pytest.approx(force * np.array([[-0.6, 0.8]]))
