# SPDX-License-Identifier: Apache-2.0
"""Layouts for RViz, Foxglove and PlotJuggler refer to topics, types, joints and fields of a real run."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import yaml
from rclpy.serialization import deserialize_message

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import FRAME_ID, JOINT_STATE, MARKER_ARRAY, OF_EVERY_RUN, POSE_ARRAY, TOPICS
from drill_twin.ros.core.topics.rclpy_topics import message_class

VIEWS = Path(__file__).resolve().parents[2] / "config" / "views"
RVIZ_TYPES = {"rviz_default_plugins/MarkerArray": MARKER_ARRAY, "rviz_default_plugins/PoseArray": POSE_ARRAY}
FOXGLOVE_PATH = re.compile(r"(?P<topic>/\w+(?:/\w+)*)(?:\.(?P<field>\w+)\[(?P<index>\d+|:)\])?")


@pytest.fixture(scope="module")
def messages(small_bag):
    """The last message of each topic of a run of the paper's scene."""
    bag = Bag(small_bag)
    return {topic: deserialize_message(bag.last(topic), message_class(TOPICS[topic])) for topic in OF_EVERY_RUN}


def test_rviz_shows_topics_of_the_twin_in_its_frame(messages):
    manager = yaml.safe_load((VIEWS / "twin.rviz").read_text("utf-8"))["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == FRAME_ID
    assert manager["Displays"]
    for display in manager["Displays"]:
        topic = TOPICS[f"/{display['Topic']['Value']}"]
        assert topic.type_name == RVIZ_TYPES[display["Class"]]
        assert display["Topic"]["Durability Policy"] == ("Transient Local" if topic.latched else "Volatile")
    shown = {marker.ns for marker in messages["/string/markers"].markers}
    assert set(manager["Displays"][0]["Namespaces"]) == shown
    assert {marker.header.frame_id for marker in messages["/string/markers"].markers} == {FRAME_ID}


def _panels(node):
    """Panels that a Foxglove layout arranges."""
    return [node] if isinstance(node, str) else _panels(node["first"]) + _panels(node["second"])


def test_every_path_of_the_foxglove_layout_leads_to_a_number(messages):
    layout = json.loads((VIEWS / "foxglove.json").read_text("utf-8"))
    assert sorted(_panels(layout["layout"])) == sorted(layout["configById"])
    assert set(layout["configById"]["3D!string"]["topics"]) <= set(TOPICS)
    assert layout["configById"]["3D!string"]["followTf"] == FRAME_ID
    paths = [
        (path["value"], path["label"]) for panel in layout["configById"].values() for path in panel.get("paths", [])
    ]
    assert len(paths) >= 10
    for value, label in paths:
        found = FOXGLOVE_PATH.fullmatch(value)
        message = messages[found["topic"]]
        assert isinstance(getattr(message, found["field"])[int(found["index"])], float), value
        joint = message.name[int(found["index"])]
        what = label.partition(" [")[0]
        # "mark_2 radius" is the joint mark_2/orbit_radius, "weight on bit" the joint bit
        assert all(word in joint for word in what.split() if word.startswith("mark_")), value
        assert what.split()[-1].split("-")[0] in joint or found["topic"] == "/rig/state", value
    rig = {label.partition(" [")[0]: messages["/rig/state"].name[int(re.search(r"\[(\d)\]", value)[1])]
           for value, label in paths if "/rig/state" in value}  # fmt: skip
    assert rig == {"weight on bit": "bit", "top-drive torque": "top_drive", "top-drive speed": "top_drive"}
    for panel in layout["configById"].values():
        for key in ("topicPath", "topicToRender"):
            if key in panel:
                assert FOXGLOVE_PATH.fullmatch(panel[key])["topic"] in TOPICS


def test_every_curve_of_the_plotjuggler_layout_is_a_joint_of_a_message(messages):
    tree = ET.parse(VIEWS / "plotjuggler.xml")  # noqa: S314 - our own file
    curves = [curve.get("name") for curve in tree.iter("curve")]
    assert len(curves) >= 10
    series = {
        f"{topic}/{joint}/{field}"
        for topic, message in messages.items()
        if TOPICS[topic].type_name == JOINT_STATE
        for field in ("position", "velocity", "effort")
        for joint, _ in zip(message.name, getattr(message, field), strict=False)
    }
    assert set(curves) <= series
