# SPDX-License-Identifier: Apache-2.0
"""Encoded messages equal those of rclpy, field by field."""

import array
import os
import time

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.io.messages.cdr import ClockTemplate, JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics
from drill_twin.io.messages.drawing.markers import MarkerArrayTemplate
from drill_twin.io.messages.encode import TwinEncoder, encode_float64, encode_string
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import type_hash

rclpy_serialization = pytest.importorskip("rclpy.serialization", reason="needs the ROS 2 wheels")

SECOND = 1_000_000_000
STAMPS = [0, 1, 1_500_000_000, 2**31 * SECOND - 1, (2**31 - 1) * SECOND]


def header(stamp):
    from builtin_interfaces.msg import Time
    from std_msgs.msg import Header

    return Header(stamp=Time(sec=stamp // SECOND, nanosec=stamp % SECOND), frame_id="hole")


def doubles(values):
    return array.array("d", np.ascontiguousarray(values, np.float64).tobytes())


def decoded(raw, kind):
    return rclpy_serialization.deserialize_message(raw, kind)


def as_ros_decodes(message):
    """The message after a trip through rclpy's own serializer."""
    return decoded(rclpy_serialization.serialize_message(message), type(message))


def test_field_checks_are_on():
    from std_msgs.msg import Float64

    with pytest.raises(AssertionError):
        Float64(data=3)


@pytest.mark.parametrize("stamp", STAMPS)
@pytest.mark.parametrize("nodes", [2, 51, 200])
def test_pose_array(nodes, stamp):
    from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion

    random = np.random.default_rng(nodes)
    position, orientation = random.normal(size=(nodes, 3)), random.normal(size=(nodes, 4))
    template = PoseArrayTemplate(nodes)
    template.fill(5, orientation[:, :3], orientation)  # nothing of an earlier message may remain
    expected = PoseArray(header=header(stamp))
    for p, q in zip(position.tolist(), orientation.tolist(), strict=True):
        expected.poses.append(
            Pose(position=Point(x=p[0], y=p[1], z=p[2]), orientation=Quaternion(x=q[0], y=q[1], z=q[2], w=q[3]))
        )
    assert decoded(template.fill(stamp, position, orientation), PoseArray) == as_ros_decodes(expected)


@pytest.mark.parametrize("stamp", STAMPS)
@pytest.mark.parametrize("count", [1, 2, 51, 200])
@pytest.mark.parametrize("arrays", [(True, True), (False, False), (True, False), (False, True)])
def test_joint_state(count, stamp, arrays):
    from sensor_msgs.msg import JointState

    names = [f"mark_{i}/" + "x" * (i % 5) for i in range(count)]
    values = np.random.default_rng(count).normal(size=(3, count))
    velocity, effort = (values[i + 1] if given else () for i, given in enumerate(arrays))
    template = JointStateTemplate(names, velocity=arrays[0], effort=arrays[1])
    expected = JointState(
        header=header(stamp),
        name=names,
        position=doubles(values[0]),
        velocity=doubles(velocity),
        effort=doubles(effort),
    )
    assert decoded(template.fill(stamp, values[0], velocity, effort), JointState) == as_ros_decodes(expected)


def marker_array(template, stamp, frame, force):
    return template.rows([stamp], frame.positions[None], frame.marks.position[None], force[None])[0]


@pytest.mark.parametrize("stamp", STAMPS)
@pytest.mark.parametrize("nodes", [2, 51, 200])
def test_marker_array(nodes, stamp, make_frame, make_geometry):
    """Every marker is checked against a marker built with rclpy, so that no field can be off."""
    from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
    from std_msgs.msg import ColorRGBA
    from visualization_msgs.msg import Marker, MarkerArray

    frame, factor = make_frame(nodes), 5.0
    template = MarkerArrayTemplate(make_geometry(nodes), factor)
    first = make_frame(nodes, seed=2)
    marker_array(template, 7, first, first.wall_force)
    raw = marker_array(template, stamp, frame, frame.wall_force)
    markers = {(m.ns, m.id): m for m in decoded(raw, MarkerArray).markers}

    assert all(m.header == header(stamp) for m in markers.values())
    drawn = frame.positions * (factor, factor, 1.0)

    def points(rows):
        return [Point(x=x, y=y, z=z) for x, y, z in rows.tolist()]

    string = markers["string", 0]
    assert string == Marker(
        header=header(stamp),
        ns="string",
        id=0,
        type=Marker.LINE_STRIP,
        scale=Vector3(x=2 * factor * 0.00825, y=0.0, z=0.0),
        pose=Pose(orientation=Quaternion(w=1.0)),
        color=string.color,
        points=points(drawn),
    )
    assert string.color.a == 1.0
    hole = markers["hole", 0]
    assert hole.type == Marker.CYLINDER
    assert (hole.scale.x, hole.scale.y, hole.scale.z) == (2 * factor * 0.09, 2 * factor * 0.09, 8.0)
    assert hole.pose.position == Point(x=0.0, y=0.0, z=-4.0)
    assert 0.0 < hole.color.a < 0.5
    rings = np.array([(p.x, p.y, p.z) for p in markers["hole", 1].points])
    assert markers["hole", 1].type == Marker.LINE_LIST
    np.testing.assert_allclose(np.hypot(rings[:, 0], rings[:, 1]), factor * 0.09)
    assert set(rings[:, 2]) == {0.0, -8.0, 4.4 - 8.0, 2.5 - 8.0, 0.5 - 8.0}
    for i, place in enumerate(frame.marks.position * (factor, factor, 1.0)):
        mark = markers["marks", i]
        assert mark.type == Marker.SPHERE
        assert mark.pose.position == points(place[None])[0]
    contacts = markers["contacts", 0]
    assert contacts.type == Marker.SPHERE_LIST
    assert len(contacts.points) == len(contacts.colors) == nodes
    for force, place, point, colour in zip(
        frame.wall_force, points(drawn), contacts.points, contacts.colors, strict=True
    ):
        if force > 0.0:
            assert point == place
            assert colour.a == 1.0
        else:
            assert point == Point(x=0.0, y=0.0, z=0.0) or point == Point(x=-0.0, y=-0.0, z=-0.0)
            assert colour == ColorRGBA()
    assert markers["text", 0].type == Marker.TEXT_VIEW_FACING
    assert markers["text", 0].text == "lateral motion x 5"
    assert len(markers) == 1 + 2 + 4 + 1 + 1


def test_no_node_at_the_wall_draws_no_contact(make_frame, make_geometry):
    from visualization_msgs.msg import MarkerArray

    frame, template = make_frame(), MarkerArrayTemplate(make_geometry(), 2.0)
    marker_array(template, 0, frame, np.ones(51))
    raw = marker_array(template, 1, frame, np.zeros(51))
    contacts = next(m for m in decoded(raw, MarkerArray).markers if m.ns == "contacts")
    assert all(colour.a == 0.0 for colour in contacts.colors)


def test_exaggeration_changes_while_running(make_frame, make_geometry):
    from visualization_msgs.msg import MarkerArray

    encoder, frame = TwinEncoder(make_geometry()), make_frame()
    for factor in (None, 3.0, 7.5, None):
        markers = decoded(encoder.markers(frames_of(frame), factor)[0], MarkerArray).markers
        text = next(m.text for m in markers if m.ns == "text")
        used = float(text.removeprefix("lateral motion x "))
        assert factor is None or used == factor
        line = next(m for m in markers if m.ns == "string")
        assert line.points[3].x == frame.positions[3, 0] * used


@pytest.mark.parametrize("stamp", STAMPS)
def test_clock(stamp):
    from builtin_interfaces.msg import Time
    from rosgraph_msgs.msg import Clock

    assert decoded(ClockTemplate().fill(stamp), Clock) == Clock(clock=Time(sec=stamp // SECOND, nanosec=stamp % SECOND))


@pytest.mark.parametrize("value", [0.0, -1.5, 1e308, float("inf"), 3, np.float32(2.5), np.int64(7)])
def test_float64_of_any_number_is_a_float(value):
    from std_msgs.msg import Float64

    assert decoded(encode_float64(value), Float64).data == float(value)


def test_string():
    from std_msgs.msg import String

    text = "name: Bohrloch Nr. 7 – 12¼ in\n" * 50
    assert decoded(encode_string(text), String).data == text


def test_diagnostics_both_ways():
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

    statuses = [
        Status("simulator: guard", Level.WARN, "one step halved", {"time": "1.25", "node": "7"}, "bit"),
        Status("simulator: pace", Level.STALE, "", {}),
    ]
    expected = DiagnosticArray(
        header=header(STAMPS[2]),
        status=[
            DiagnosticStatus(
                level=bytes([status.level]),
                name=status.name,
                message=status.text,
                hardware_id=status.hardware_id,
                values=[KeyValue(key=key, value=value) for key, value in status.values.items()],
            )
            for status in statuses
        ],
    )
    assert decoded(encode_diagnostics(STAMPS[2], statuses, "hole"), DiagnosticArray) == expected
    theirs = rclpy_serialization.serialize_message(expected)
    assert decode_diagnostics(theirs) == (STAMPS[2], statuses)


@pytest.fixture
def node():
    import rclpy

    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=1 + os.getpid() % 100)
    made = rclpy.create_node("contract_check", context=context)
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)


def test_types_and_hashes_are_those_of_the_graph(node):
    from importlib import import_module

    for topic in TOPICS.values():
        package, _, name = topic.type_name.split("/")
        node.create_publisher(getattr(import_module(f"{package}.msg"), name), topic.name, topic.depth)
    for topic in TOPICS.values():
        found = []
        limit = time.monotonic() + 5.0
        while not found and time.monotonic() < limit:
            found = node.get_publishers_info_by_topic(topic.name)
        assert found, topic.name
        assert found[0].topic_type == topic.type_name
        assert str(found[0].topic_type_hash) == type_hash(topic.type_name), topic.name


def test_raw_bytes_travel_over_dds(node):
    """`publish(bytes)` of a template arrives at an ordinary subscriber as an ordinary message."""
    import rclpy
    from geometry_msgs.msg import PoseArray

    received = []
    publisher = node.create_publisher(PoseArray, "/string/poses", 10)
    node.create_subscription(PoseArray, "/string/poses", received.append, 10)
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    limit = time.monotonic() + 10.0
    while not publisher.get_subscription_count() and time.monotonic() < limit:
        executor.spin_once(timeout_sec=0.05)
    position = np.arange(9.0).reshape(3, 3)
    publisher.publish(PoseArrayTemplate(3).fill(STAMPS[2], position, np.eye(4)[[3, 3, 3]]))
    while not received and time.monotonic() < limit:
        executor.spin_once(timeout_sec=0.05)
    executor.shutdown()
    assert received[0].header == header(STAMPS[2])
    assert [(p.position.x, p.position.y, p.position.z) for p in received[0].poses] == [
        tuple(row) for row in position.tolist()
    ]
    assert all(p.orientation.w == 1.0 for p in received[0].poses)
