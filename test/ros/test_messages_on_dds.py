# SPDX-License-Identifier: Apache-2.0
"""Messages on DDS: every topic has the type of the contract, and every number its value."""

import math
import time
from collections import Counter
from functools import partial

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from std_msgs.msg import Float64

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    COMMANDER,
    MARKS_STATE,
    RIG_COMMAND,
    RPS_COMMAND,
    STRING_POSES,
    TOPICS,
    TWIN_SCENE,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WOB_COMMAND,
)
from drill_twin.io.messages.type_store import type_hash
from drill_twin.ros.core.topics import message_class
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Schedule


def _numbers(message):
    """All floating-point numbers in a message object."""
    if isinstance(message, float):
        yield message
    elif isinstance(message, str | bytes | int):
        return
    elif hasattr(message, "get_fields_and_field_types"):
        for field in message.get_fields_and_field_types():
            yield from _numbers(getattr(message, field))
    else:
        for item in message:
            yield from _numbers(item)


def _rubbish(number):
    """Value of an int that is sent in a float field: a number too small to be valid."""
    return number != 0.0 and abs(number) < 1e-300


def test_every_number_of_a_run_is_meant(small_bag):
    for topic, _, raw in Bag(small_bag).messages():
        message = deserialize_message(raw, message_class(TOPICS[topic]))
        assert not any(_rubbish(number) for number in _numbers(message)), topic


def test_an_int_would_have_been_caught():
    with pytest.raises(AssertionError):
        Float64(data=3, check_fields=True)


def test_a_run_has_its_marks_where_the_scene_puts_them(small_bag):
    raws = [raw for _, _, raw in Bag(small_bag).messages((MARKS_STATE,))]
    message = deserialize_message(raws[-1], message_class(TOPICS[MARKS_STATE]))
    values = dict(zip(message.name, message.position, strict=True))
    assert values["mark_3/z"] == pytest.approx(-4.5, abs=0.01)
    assert math.hypot(values["mark_3/x"], values["mark_3/y"]) == pytest.approx(0.00825, abs=0.005)


def test_the_set_points_of_the_driver_are_in_si_each_in_its_joint(small_bag):
    command, *_ = (
        deserialize_message(raw, message_class(TOPICS[RIG_COMMAND]))
        for number, (_, _, raw) in enumerate(Bag(small_bag).messages((RIG_COMMAND,)))
        if number == 49
    )
    planned = Schedule.from_scene(load_scene("pa6_bench")).at(0.5)  # at the 50th of 100 frames a second
    assert command.velocity[command.name.index("top_drive")] == pytest.approx(planned.rotation)
    assert command.effort[command.name.index("bit_axial")] == pytest.approx(planned.weight_on_bit)
    assert command.header.frame_id == "/rig_driver"
    assert planned.weight_on_bit > 0.0
    assert not list(Bag(small_bag).messages((WOB_COMMAND, RPS_COMMAND))), "a driver echoes nothing"


def test_the_graph_has_the_types_of_the_contract(bench):
    """Names, types and type hashes of a running twin are those of the table that the README shows."""
    process = bench.start("twin", record=True, bag=str(bench.folder / "bag_0"))
    bench.until(lambda: bench.node.count_publishers(STRING_POSES) == 1, what="the simulator")
    bench.until_ready("simulator", "analyzer", "recorder")
    found = dict(bench.node.get_topic_names_and_types())
    for name, topic in TOPICS.items():
        assert found[name] == [topic.type_name]
        for info in bench.node.get_publishers_info_by_topic(name):
            assert str(info.topic_type_hash) == type_hash(topic.type_name)
            assert str(info.qos_profile.reliability.name) == "RELIABLE"
            if topic.offered_latched:
                assert info.qos_profile.durability.name == "TRANSIENT_LOCAL"
    # Nothing else is published, but what every ROS node has.
    of_ros = ("/rosout", "/parameter_events", "/transition_event")  # the last: of every lifecycle node
    ours = {name for name in found if not name.endswith(of_ros)}
    assert ours == set(TOPICS)
    assert process.end() == 0


def test_a_late_reader_gets_one_old_sample_of_each_latched_topic(bench):
    """Also a reader that would take a thousand, as a recorder of another hand does."""
    process, told = bench.start("twin"), bench.collect(WHIRL_MOTION)
    bench.until(lambda: len(told) > 3, what="motion states")
    old, quality = Counter(), QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    taken, came = Counter(), time.time_ns()

    def received(name, _, info):
        taken[name] += 1
        old[name] += info["source_timestamp"] < came

    topics = {name: topic for name, topic in TOPICS.items() if bench.node.count_publishers(name)}
    offers = {name: bench.node.get_publishers_info_by_topic(name)[0].qos_profile.durability for name in topics}
    latched = [name for name, offered in offers.items() if offered == DurabilityPolicy.TRANSIENT_LOCAL]
    assert {CLOCK_TOPIC, COMMANDER, TWIN_SCENE, WHIRL_MOTION, WHIRL_ONSET} == set(latched)
    for name in latched:
        bench.node.create_subscription(message_class(topics[name]), name, partial(received, name), quality)
    bench.until(lambda: all(taken[name] for name in latched), what="a sample of each")
    assert not [name for name in latched if old[name] > 1], old
    assert process.end() == 0


def test_parameters_are_described_with_unit_and_range(bench):
    from rcl_interfaces.srv import DescribeParameters

    process = bench.start("simulator")
    client = bench.node.create_client(DescribeParameters, "/simulator/describe_parameters")
    bench.until(client.service_is_ready, what="the simulator's parameters")
    answer = client.call_async(DescribeParameters.Request(names=["frame_rate", "pace"]))
    bench.until(answer.done)
    rate, pace = answer.result().descriptors
    assert "[Hz]" in rate.description
    assert rate.floating_point_range[0].to_value == 1000.0
    assert rate.read_only
    assert "realtime, fast, lockstep" in pace.additional_constraints
    assert process.end() == 0
