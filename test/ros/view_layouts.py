# SPDX-License-Identifier: Apache-2.0
"""Layouts for RViz, Foxglove and PlotJuggler, held against messages: topics, types, joints and fields must be there."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import yaml

from drill_twin.io.messages.topics import FRAME_ID, JOINT_STATE, MARKER_ARRAY, POSE_ARRAY, TOPICS

VIEWS = Path(__file__).resolve().parents[2] / "config" / "views"
RVIZ_TYPES = {"rviz_default_plugins/MarkerArray": MARKER_ARRAY, "rviz_default_plugins/PoseArray": POSE_ARRAY}
FOXGLOVE_PATH = re.compile(r"(?P<topic>/\w+(?:/\w+)*)(?:\.(?P<field>\w+)\[(?P<index>\d+|:)\])?")


def check_rviz(messages):
    """Displays show topics of the twin, in its frame, with the durability of their publisher."""
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


def check_foxglove(messages):
    """Every path leads to a number, and to the one that its label names."""
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


def check_plotjuggler(messages):
    """Every curve is a joint of a message."""
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


def layout_topics():
    """Topics that a layout names."""
    texts = (path.read_text("utf-8") for path in VIEWS.iterdir())
    words = {word for text in texts for word in re.findall(r"/?\w+(?:/\w+)+", text)}
    return {f"/{word.strip('/')}" for word in words} & set(TOPICS)
