# SPDX-License-Identifier: Apache-2.0
"""Subscriptions of a node bring decoded messages; one that cannot be used is counted, and ends nothing."""

import re

import pytest
import rclpy
from documented_lines import ros2_lines
from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.cdr import ClockTemplate
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import CLOCK_TOPIC, TOPICS, TWIN_SCENE, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import OnsetMessage, SubjectMotion, encode_motion, encode_onset
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.topics import message_class


class Observer(TwinNode):
    """Node that is never configured."""

    NAME = "observer"


@pytest.fixture
def observer(bench):
    context = Context()
    rclpy.init(args=[], context=context, domain_id=bench.domain, signal_handler_options=SignalHandlerOptions.NO)
    node = Observer(context)
    yield node
    node.destroy_node()
    context.try_shutdown()


def latched(bench, topic):
    quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return bench.node.create_publisher(message_class(TOPICS[topic]), topic, quality)


def until(node, happened):
    for _ in range(400):
        node.spin_once(0.05)
        if happened():
            return
    pytest.fail("expected a message within 20 s")


def test_a_message_that_cannot_be_used_is_counted_and_the_next_one_is_taken(bench, observer):
    clocks, onsets = [], []
    observer.topics.subscribe(CLOCK_TOPIC, clocks.append)
    observer.topics.subscribe(WHIRL_ONSET, onsets.append)
    clock, onset = bench.publisher(CLOCK_TOPIC), latched(bench, WHIRL_ONSET)
    clock.publish(b"\x00\x01\x00\x00\x07")  # no Clock
    onset.publish(encode_string("a message of another type"))
    until(observer, lambda: len(observer.samples.values()) == 4)
    assert observer.samples.values()[f"unreadable {CLOCK_TOPIC}"] == "1"
    clock.publish(ClockTemplate().fill(2_500_000_000))
    onset.publish(encode_onset(2_500_000_000, OnsetMessage(1.25, "mark")))
    until(observer, lambda: clocks and onsets)
    assert (clocks[0], onsets[0][1].time) == (2_500_000_000, 1.25)
    assert observer.samples.values()[f"unreadable {WHIRL_ONSET}"] == "1"


def test_after_a_scene_that_took_long_the_newest_waits_for_its_turn(bench, observer):
    found, clock = [], [0.0]

    def take(raw):
        found.append(raw)
        clock[0] += 0.06

    observer.topics.subscribe_scenes(take)
    gate = observer.topics.scenes
    gate._clock = lambda: clock[0]  # the machine's own clock goes on while the test waits for a processor
    scenes, (loads, first, second, third) = latched(bench, TWIN_SCENE), map(encode_string, ("0", "1", "2", "3"))
    scenes.publish(loads)  # modules are loaded with the first scene, whose time does not count
    until(observer, lambda: bool(found))
    scenes.publish(first)
    until(observer, lambda: len(found) == 2)
    scenes.publish(second)
    until(observer, lambda: gate.waits)
    scenes.publish(third)
    until(observer, lambda: gate.put_off == 1)
    assert found == [loads, first]
    clock[0] += 60.0
    until(observer, lambda: len(found) > 2)
    assert found == [loads, first, third]


def echo_quality(line, offers):
    """Quality of service that `ros2 topic echo` of Jazzy asks for: with any flag it starts from sensor data."""
    flags = dict(re.findall(r"--qos-(\w+) (\w+)", line))
    reliable = all(offer.reliability == ReliabilityPolicy.RELIABLE for offer in offers) and not flags
    latched = all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers) and not flags
    return QoSProfile(
        depth=int(flags.get("depth", 5)),
        reliability=ReliabilityPolicy[flags.get("reliability", "reliable" if reliable else "best_effort").upper()],
        durability=DurabilityPolicy[flags.get("durability", "transient_local" if latched else "volatile").upper()],
    )


@pytest.mark.parametrize("line", [line for line in ros2_lines().documented() if "topic echo" in line])
def test_a_documented_echo_is_connected_and_gets_what_is_latched(bench, observer, line):
    topic, got = line.split()[-1], []
    kind = message_class(TOPICS[topic])
    publisher = observer.topics.advertise(topic)
    publisher.publish(kind())
    bench.until(lambda: bench.node.count_publishers(topic), what=topic)
    offers = [info.qos_profile for info in bench.node.get_publishers_info_by_topic(topic)]
    bench.node.create_subscription(kind, topic, got.append, echo_quality(line, offers))
    if not TOPICS[topic].latched:
        bench.until(publisher.get_subscription_count)
        publisher.publish(kind())
    bench.until(lambda: got, 20.0, f"a message for {line}")


def test_a_flood_of_a_latched_topic_reaches_a_recorder(bench, observer):
    """One sample is kept, and is replaced once the readers have it."""
    bag = bench.folder / "bag_0"
    recorder = bench.start("recorder", bag=str(bag), topics=WHIRL_MOTION)
    motions = observer.topics.advertise(WHIRL_MOTION)
    bench.until(motions.get_subscription_count, what="the recorder")
    bench.until_ready("recorder")
    for stamp in range(3000):
        observer.topics.publish(WHIRL_MOTION, encode_motion(stamp, [SubjectMotion("string", "spiral", "")]))
    observer.flush()
    assert recorder.end() == 0, recorder.text
    assert Bag(bag).topics[WHIRL_MOTION].count > 2900  # a busy machine may keep it for 0.1 s from one of them
