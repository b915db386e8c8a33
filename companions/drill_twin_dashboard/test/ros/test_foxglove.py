# SPDX-License-Identifier: Apache-2.0
"""`drill-twin watch --foxglove`: a client of the Foxglove protocol gets the topics, and the layouts show them."""

import json
import re
import struct
import sys
import time

from rclpy.qos import DurabilityPolicy
from rclpy.serialization import deserialize_message
from view_layouts import check_foxglove, check_plotjuggler, check_rviz, layout_topics
from websockets.sync.client import connect

from drill_twin.io.messages.topics import OF_EVERY_RUN, RIG_COMMAND, TOPICS, imu_topic, summary_topic
from drill_twin.ros.core.topics import message_class

STEADY = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
OF_LOW = (imu_topic("low"), summary_topic("low"))
DATA = struct.Struct("<BIQ")  # operation, subscription, time [ns]


def _messages(url, wanted):
    """Channels, and one message of each wanted topic."""
    with connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
        channels = {}
        while not {*TOPICS, *wanted} <= channels.keys():
            told = json.loads(socket.recv(timeout=20.0))
            channels |= {one["topic"]: one for one in told.get("channels", [])}
        topics = dict(enumerate(wanted))
        asked = [{"id": number, "channelId": channels[topic]["id"]} for number, topic in topics.items()]
        socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
        found, end = {}, time.monotonic() + 60.0
        while len(found) < len(topics):
            assert time.monotonic() < end, set(wanted) - found.keys()
            data = socket.recv(timeout=20.0)
            if isinstance(data, bytes):
                operation, number, _ = DATA.unpack_from(data)
                assert operation == 1
                found[topics[number]] = data[DATA.size :]
    return channels, found


def test_a_viewer_gets_every_topic_and_the_layouts_show_the_running_twin(bench):
    bench.start("analyzer")
    subs = "sensors={subs: [{name: low, distance_from_bit: 500 mm, rate: 100 Hz}]}"
    bench.start("simulator", overrides=f"{STEADY}; {subs}")
    bench.start("rig_driver", overrides=STEADY)
    command = [sys.executable, "-m", "drill_twin.cli", "watch", "--no-browser", "--port", "0", "--foxglove", "0"]
    page = bench.command("watch", command)
    bench.until(lambda: "for Foxglove: " in page.text, what="the address")
    url = re.search(r"for Foxglove: (\S+)", page.text)[1]
    bench.until(lambda: bench.simulated_time() > 1.0, what="a second of the run")
    # The scene and the onset are latched, and come again to a late viewer.
    channels, found = _messages(url, sorted({*OF_EVERY_RUN, *OF_LOW}))
    for topic in {*TOPICS, *OF_LOW}:
        row = TOPICS[topic]
        assert channels[topic]["schemaName"] == row.type_name
        assert (channels[topic]["encoding"], channels[topic]["schemaEncoding"]) == ("cdr", "ros2msg")
    messages = {topic: deserialize_message(raw, message_class(TOPICS[topic])) for topic, raw in found.items()}
    assert set(messages[RIG_COMMAND].name) == {"top_drive", "bit_axial", "block"}
    for check in (check_rviz, check_foxglove, check_plotjuggler):
        check(messages)
    # A viewer on DDS finds each topic of the layouts with the type and durability that it asks for.
    for topic in sorted(layout_topics()):
        offers = bench.node.get_publishers_info_by_topic(topic)
        assert {offer.topic_type for offer in offers} == {TOPICS[topic].type_name}, topic
        latched = {offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers}
        assert latched == {TOPICS[topic].latched}, topic


def test_a_bag_is_not_served_to_viewers(bench):
    command = [sys.executable, "-m", "drill_twin.cli", "watch", "bag_0", "--foxglove", "0"]
    process = bench.command("watch", command)
    assert process.wait() == 2
    assert "expected --foxglove without a bag" in process.text
