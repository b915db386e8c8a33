# SPDX-License-Identifier: Apache-2.0
"""The fast decoders agree with the general one on all messages, and check the bytes they use."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin.core.errors import MessageError
from drill_twin.io.messages import decode
from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.decode import JointStateReader, read_float64, read_joint_state, read_pose_array, read_string
from drill_twin.io.messages.stamps import header
from drill_twin.io.messages.topic_row import JOINT_STATE, POSE_ARRAY
from drill_twin.io.messages.type_store import message, serialize, typestore

number = st.floats(allow_nan=True, allow_infinity=True, width=64)
stamps = st.integers(0, 2**31 * 1_000_000_000 - 1)


@st.composite
def joint_states(draw):
    names = draw(st.lists(st.text(max_size=9), min_size=1, max_size=6))
    count = len(names)
    arrays = [
        np.array(draw(st.lists(number, min_size=count, max_size=count)) if draw(st.booleans()) else [], float)
        for _ in range(3)
    ]
    content = message(
        JOINT_STATE,
        header=header(draw(stamps), draw(st.text(max_size=5))),
        name=names,
        position=arrays[0],
        velocity=arrays[1],
        effort=arrays[2],
    )
    return content, arrays


def same(state, content, arrays):
    stamp = content.header.stamp
    assert state.stamp == stamp.sec * 1_000_000_000 + stamp.nanosec
    assert state.names == tuple(content.name)
    for found, expected in zip((state.position, state.velocity, state.effort), arrays, strict=True):
        assert found.dtype == np.float64
        assert found.tobytes() == expected.tobytes()


@settings(max_examples=150, deadline=None)
@given(st.lists(joint_states(), min_size=1, max_size=4), st.data())
def test_any_joint_states_in_any_order(messages, data):
    """One reader sees several layouts in turn, each more than once, big-endian ones too."""
    reader = JointStateReader()
    for content, arrays in messages + messages[::-1] + messages:
        little = data.draw(st.booleans())
        raw = bytes(typestore().serialize_cdr(content, JOINT_STATE, little_endian=little))
        same(reader.read(raw), content, arrays)


def test_many_messages_are_read_as_each_and_another_layout_is_seen():
    first, other = JointStateTemplate(["mark_1/x", "b"]), JointStateTemplate(["mark_2/x", "b"])
    raws = [first.fill(10**9 * k + k, *np.random.default_rng(k).random((3, 2))) for k in range(5)]
    reader = JointStateReader()
    states, each = reader.read_rows(raws), [JointStateReader().read(raw) for raw in raws]
    assert (states.stamps, states.names) == ([one.stamp for one in each], each[0].names)
    for name in ("position", "velocity", "effort"):
        np.testing.assert_array_equal(getattr(states, name), [getattr(one, name) for one in each])
    assert reader.read_rows([*raws, other.fill(0, *np.zeros((3, 2)))]) is None
    assert reader.read_rows([other.fill(0, *np.zeros((3, 2))), *raws]) is None
    with pytest.raises(MessageError, match="expected the CDR bytes"):
        JointStateReader().read_rows([b"rubbish", *raws])


def test_the_fast_way_is_taken(monkeypatch):
    template, reader = JointStateTemplate(["a/x", "b"]), JointStateReader()
    reader.read(template.fill(1, (1.0, 2.0), (3.0, 4.0), (5.0, 6.0)))
    monkeypatch.setattr(decode, "deserialize", lambda *_: pytest.fail("the slow way was taken"))
    state = reader.read(template.fill(2, (7.0, 8.0), (np.nan, 10.0), (11.0, 12.0)))
    assert (state.stamp, state.names) == (2, ("a/x", "b"))
    np.testing.assert_array_equal(
        np.stack((state.position, state.velocity, state.effort)), [[7.0, 8.0], [np.nan, 10.0], [11.0, 12.0]]
    )
    assert state.position.flags.aligned
    assert state.position.flags.writeable  # not the bytes of the message


def test_other_names_of_the_same_length_are_seen():
    reader = JointStateReader()
    first, second = JointStateTemplate(["mark_1/x"]), JointStateTemplate(["mark_2/x"])
    for template in (first, second, first):
        assert reader.read(template.fill(1, [1.0], [2.0], [3.0])).names == template.names


@pytest.mark.parametrize("filled", [(1, 1, 1), (1, 0, 1), (1, 0, 0), (0, 1, 1), (0, 0, 1), (0, 0, 0)])
def test_the_messages_of_rclpy_are_read(filled):
    """rclpy leaves arbitrary bytes in the padding and at the end; names of odd length need much padding."""
    serialization = pytest.importorskip("rclpy.serialization", reason="needs the ROS 2 wheels")
    import array

    from sensor_msgs.msg import JointState

    reader = JointStateReader()
    for k in range(30):
        arrays = [array.array("d", (k, 1.0, 2.0) if given else ()) for given in filled]
        ours = JointState(name=["a", "bc", "def" * (k % 2)], position=arrays[0], velocity=arrays[1], effort=arrays[2])
        ours.header.stamp.nanosec = k
        state = reader.read(serialization.serialize_message(ours))
        assert (state.stamp, state.names) == (k, tuple(ours.name))
        for found, expected in zip((state.position, state.velocity, state.effort), arrays, strict=True):
            assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("count", [0, 1, 3])
def test_the_poses_of_rclpy_are_read(count):
    serialization = pytest.importorskip("rclpy.serialization", reason="needs the ROS 2 wheels")
    from geometry_msgs.msg import Pose, PoseArray

    for frame_id in ("", "a", "abcd", "hole", "a/longer/one"):
        ours = PoseArray(poses=[Pose() for _ in range(count)])
        ours.header.frame_id = frame_id
        for k, pose in enumerate(ours.poses):
            pose.position.x = float(k)
        poses = read_pose_array(serialization.serialize_message(ours))
        assert poses.position[:, 0].tolist() == list(range(count))
        assert poses.orientation.tolist() == [[0.0, 0.0, 0.0, 1.0]] * count


def outcome(reader, raw):
    """What a reader makes of some bytes, in a form that compares bit for bit."""
    try:
        state = reader.read(raw)
    except MessageError:
        return None
    return state.stamp, state.names, *(a.tobytes() for a in (state.position, state.velocity, state.effort))


def test_a_layout_once_learned_is_not_trusted():
    """Any single byte that changes is judged as by a reader that sees its first message."""
    reader = JointStateReader()
    raw = JointStateTemplate(["mark_1/x", "bit"]).fill(5, (1.0, 2.0), (3.0, 4.0), (5.0, 6.0))
    for place in range(len(raw)):
        reader.read(raw)
        changed = raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :]
        assert outcome(reader, changed) == outcome(JointStateReader(), changed), place


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_damaged_bytes_are_refused_or_harmless(data):
    """Whatever happens to the bytes, there is a message or a MessageError, never another exception."""
    template = JointStateTemplate(["mark_1/x", "mark_1/y"])
    reader = JointStateReader()
    raw = template.fill(5, (1.0, 2.0), (3.0, 4.0), (5.0, 6.0))
    reader.read(raw)
    bad = bytearray(raw[: data.draw(st.integers(0, len(raw)))] if data.draw(st.booleans()) else raw)
    for _ in range(data.draw(st.integers(0, 4))):
        if bad:
            bad[data.draw(st.integers(0, len(bad) - 1))] = data.draw(st.integers(0, 255))
    for read in (reader.read, read_joint_state, read_pose_array, read_string, read_float64):
        with suppress(MessageError):
            read(bytes(bad))
    assert reader.read(raw).names == ("mark_1/x", "mark_1/y")


def test_arrays_must_match_the_names():
    content = message(
        JOINT_STATE,
        header=header(0, "hole"),
        name=["a", "b"],
        position=np.zeros(3),
        velocity=np.zeros(0),
        effort=np.zeros(0),
    )
    with pytest.raises(MessageError, match="no or 2 values of position, one a name, found 3"):
        read_joint_state(serialize(content, JOINT_STATE))


def test_a_missing_joint_is_named():
    state = read_joint_state(JointStateTemplate(["bit"]).fill(0, [0.0], [0.0], [0.0]))
    with pytest.raises(MessageError, match="expected a joint 'top_drive', found bit"):
        state.index("top_drive")


@pytest.mark.parametrize("frame_id", ["", "a", "ab", "abc", "abcd", "abcde", "hole", "über"])
@pytest.mark.parametrize("little", [True, False])
def test_poses_of_any_frame_and_byte_order(frame_id, little):
    values = np.arange(14.0).reshape(2, 7)
    raw = PoseArrayTemplate(2, frame_id).fill(1_500_000_001, values[:, :3], values[:, 3:])
    if not little:
        raw = bytes(
            typestore().serialize_cdr(typestore().deserialize_cdr(raw, POSE_ARRAY), POSE_ARRAY, little_endian=False)
        )
    poses = read_pose_array(raw)
    assert poses.stamp == 1_500_000_001
    np.testing.assert_array_equal(poses.position, values[:, :3])
    np.testing.assert_array_equal(poses.orientation, values[:, 3:])


@pytest.mark.parametrize("frame_id", ["", "a", "abcd", "hole"])
def test_no_poses(frame_id):
    raw = PoseArrayTemplate(0, frame_id).fill(3, np.zeros((0, 3)), np.zeros((0, 4)))
    assert read_pose_array(raw).position.shape == (0, 3)


def test_a_pose_array_with_bytes_left_over_is_refused():
    raw = PoseArrayTemplate(1).fill(0, np.zeros((1, 3)), np.zeros((1, 4)))
    with pytest.raises(MessageError, match="left over"):
        read_pose_array(raw + bytes(17))
