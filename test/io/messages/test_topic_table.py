# SPDX-License-Identifier: Apache-2.0
"""The table of topics is the contract of the design."""

import subprocess
import sys

import pytest

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.readers import reader_of
from drill_twin.io.messages.topics import OF_SUBS, TOPICS
from drill_twin.io.messages.type_store import definition


def test_the_contract():
    assert {name: topic.type_name.split("/")[-1] for name, topic in TOPICS.items()} == {
        "/rig/command": "JointState",
        "/rig/wob_command": "Float64",
        "/rig/rps_command": "Float64",
        "/rig/commander": "String",
        "/rig/state": "JointState",
        "/string/poses": "PoseArray",
        "/string/stress": "JointState",
        "/marks/state": "JointState",
        "/string/markers": "MarkerArray",
        "/whirl/state": "JointState",
        "/whirl/motion": "DiagnosticArray",
        "/whirl/onset": "TimeReference",
        "/measured/rig/state": "JointState",
        "/surface/state": "JointState",
        "/advice/state": "JointState",
        "/advice/map": "String",
        "/estimate/state": "JointState",
        "/twin/scene": "String",
        "/twin/summary": "JointState",
        "/twin/realtime_factor": "Float64",
        "/diagnostics": "DiagnosticArray",
        "/clock": "Clock",
    }
    latched = {name: topic.publisher_depth for name, topic in TOPICS.items() if topic.offered_latched}
    names = ("/rig/commander", "/whirl/motion", "/whirl/onset", "/advice/map", "/twin/scene", "/clock")
    assert latched == dict.fromkeys(names, 1)


def test_every_definition_is_known():
    for topic in TOPICS.values():
        assert definition(topic.type_name)


@pytest.mark.parametrize("topic", [*TOPICS, *(row.name.replace("SUB", "low") for row in OF_SUBS)])
def test_every_topic_has_a_decoder(topic):
    with pytest.raises(MessageError):
        reader_of(topic)(b"\x00\x01\x00\x00\x07")


def test_messages_and_bags_do_without_ros():
    code = "import sys, drill_twin.io.messages.encode, drill_twin.io.bag.series; sys.exit('rclpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
