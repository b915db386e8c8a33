# SPDX-License-Identifier: Apache-2.0
"""Layouts for RViz, Foxglove and PlotJuggler, held against messages: topics, types, joints and fields must be there."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import yaml

from drill_twin.io.messages.topic_row import JOINT_STATE, MARKER_ARRAY, POSE_ARRAY
from drill_twin.io.messages.topics import FRAME_ID, TOPICS

VIEWS = Path(__file__).resolve().parents[1] / "config" / "views"
# What RViz of Jazzy reads: classes of its plugins, the type a display subscribes to, and the names of its properties.
RVIZ_DISPLAYS = {
    "rviz_default_plugins/MarkerArray": (MARKER_ARRAY, {"Namespaces", "Topic"}),
    "rviz_default_plugins/PoseArray": (POSE_ARRAY, {"Topic", "Shape", "Axes Length", "Axes Radius"}),
    "rviz_default_plugins/TF": (
        None,
        {"Frame Timeout", "Marker Scale", "Show Arrows", "Show Axes", "Show Names"},
    ),
}
RVIZ_OF_EACH_DISPLAY = {"Class", "Name", "Enabled", "Value"}
RVIZ_TOPIC = {"Value", "Depth", "Durability Policy", "History Policy", "Reliability Policy"}
RVIZ_OTHERS = {
    "Panels": {"rviz_common/Displays", "rviz_common/Views"},
    "Tools": {f"rviz_default_plugins/{name}" for name in ("MoveCamera", "FocusCamera", "Measure")},
}
RVIZ_ORBIT = {"Class", "Name", "Value", "Distance", "Focal Point", "Near Clip Distance", "Pitch", "Yaw", "Target Frame"}
FOXGLOVE_PATH = re.compile(r"(?P<topic>/\w+(?:/\w+)*)\.joints\[:\]\{name==\"(?P<joint>[\w/]+)\"\}\.(?P<field>\w+)")
TYPES = re.compile(r'^(?:import|type) .*$|: Input<"[^"]+">|\): Output', re.MULTILINE)
"""What TypeScript has and JavaScript has not, in the scripts of the layout."""
FIELDS = ("position", "velocity", "effort")


def check_rviz(messages):
    """Displays, tools and properties are RViz's; topics are the twin's, with its quality, in a frame that is on tf."""
    layout = yaml.safe_load((VIEWS / "twin.rviz").read_text("utf-8"))
    manager = layout["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == FRAME_ID
    assert {panel["Class"] for panel in layout["Panels"]} == RVIZ_OTHERS["Panels"]
    assert {tool["Class"] for tool in manager["Tools"]} == RVIZ_OTHERS["Tools"]
    view = manager["Views"]["Current"]
    assert view["Class"] == "rviz_default_plugins/Orbit"
    assert view.keys() <= RVIZ_ORBIT
    assert view["Target Frame"] == "<Fixed Frame>"  # that of the launch argument frame_prefix too
    assert manager["Displays"][0]["Enabled"]
    for display in manager["Displays"]:
        type_name, properties = RVIZ_DISPLAYS[display["Class"]]
        assert display.keys() == RVIZ_OF_EACH_DISPLAY | properties
        assert display["Enabled"] == display["Value"]
        if type_name is None:
            continue
        asked = display["Topic"]
        assert asked.keys() == RVIZ_TOPIC
        assert not asked["Value"].startswith("/")  # follows the namespace of the launch
        topic = TOPICS[f"/{asked['Value']}"]
        assert topic.type_name == type_name
        assert asked["Durability Policy"] == ("Transient Local" if topic.latched else "Volatile")
        assert (asked["Reliability Policy"], asked["History Policy"]) == ("Reliable", "Keep Last")
    shown = {marker.ns for marker in messages["/string/markers"].markers}
    assert set(manager["Displays"][0]["Namespaces"]) == shown
    assert {marker.header.frame_id for marker in messages["/string/markers"].markers} == {FRAME_ID}


def _panels(node):
    """Panels that a Foxglove layout arranges."""
    return [node] if isinstance(node, str) else _panels(node["first"]) + _panels(node["second"])


def check_foxglove(messages):
    """Every path leads to a number by the name of its joint, and to the number that its label names."""
    layout = json.loads((VIEWS / "foxglove.json").read_text("utf-8"))
    assert sorted(_panels(layout["layout"])) == sorted(layout["configById"])
    assert set(layout["configById"]["3D!string"]["topics"]) <= set(TOPICS)
    assert layout["configById"]["3D!string"]["followTf"] == FRAME_ID
    paths = [
        (path["value"], path["label"]) for panel in layout["configById"].values() for path in panel.get("paths", [])
    ]
    assert len(paths) >= 10
    if shutil.which("node") is None:
        pytest.skip("needs node")
    scripts = [node["sourceCode"] for node in layout["userNodes"].values()]
    made = dict(_made_by_script(source, messages) for source in scripts)
    shown = {}
    for value, label in paths:
        found = FOXGLOVE_PATH.fullmatch(value)
        (joint,) = (joint for joint in made[found["topic"]]["joints"] if joint["name"] == found["joint"])
        assert isinstance(joint[found["field"]], float), value
        shown[label.partition(" [")[0]] = (found["joint"], found["field"])
    for label, (joint, field) in shown.items():
        if label.startswith("mark_"):  # "mark_2 radius" is the joint mark_2/orbit_radius
            mark, what = label.split()
            assert joint.startswith(f"{mark}/"), label
            assert (joint.endswith(what), field) == (True, "position"), label
    assert {label: place for label, place in shown.items() if not label.startswith("mark_")} == {
        "weight on bit": ("bit_axial", "effort"),
        "top-drive torque": ("top_drive", "effort"),
        "top-drive speed": ("top_drive", "velocity"),
    }
    for panel in layout["configById"].values():
        for key in ("topicPath", "topicToRender"):
            if key in panel:
                assert panel[key].partition(".")[0] in TOPICS


def _made_by_script(source, messages):
    """Topic and message that a script makes: run by node from the last message of its topic, with the joints turned."""
    (topic,) = json.loads(re.search(r"inputs = (.*);", source)[1])
    output = json.loads(re.search(r"output = (.*);", source)[1])
    message = messages[topic]
    fields = {name: np.nan_to_num(getattr(message, name), nan=0.5).tolist()[::-1] for name in FIELDS}
    fields["name"] = list(message.name)[::-1]
    given = json.dumps({"message": {"header": {"stamp": {"sec": 1, "nsec": 2}}, **fields}})
    code = TYPES.sub(lambda found: ")" if found[0].startswith(")") else "", source).replace("export default ", "")
    code = code.replace("export ", "") + f"\nconsole.log(JSON.stringify(script({given})));"
    done = subprocess.run(["node", "--eval", code], capture_output=True, text=True, timeout=60, check=False)  # noqa: S607
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["header"] == {"stamp": {"sec": 1, "nsec": 2}}
    values = {joint["name"]: joint for joint in result["joints"]}
    assert list(values) == fields["name"]
    for field in FIELDS:
        for name, value in zip(fields["name"], fields[field], strict=bool(fields[field])):
            assert values[name][field] == value, name
            values[name][field] = float(values[name][field])
    return output, result


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
