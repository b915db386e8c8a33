# SPDX-License-Identifier: Apache-2.0
"""SROS2 policies allow what running nodes do and nothing else; no node runs without the required security."""

import sys
from importlib.util import find_spec
from xml.etree import ElementTree as ET

import pytest

from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MEASURED_RIG_STATE,
    OF_EVERY_RUN,
    OF_SUBS,
    OF_TF,
    RIG_COMMAND,
    RIG_STATE,
    STRING_STRESS,
    SURFACE_STATE,
    TOPICS,
)
from drill_twin.ros.bag import player_control
from drill_twin.ros.core.policy import policy_text
from drill_twin.ros.entry_points import load, node_names, start
from drill_twin.ros.simulator.run_control import SERVICES

ALL_TOPICS = {*TOPICS, *OF_TF, *(row.name.replace("SUB", "*") for row in OF_SUBS)}
OF_ROS = {"/parameter_events", "/rosout", "/tf", "/tf_static"}
WHERE_INSTALLED = {
    "tf2_msgs": {"/tf", "/tf_static"},
    "simulation_interfaces": {f"/simulator/{name}" for name in SERVICES},
    "rosbag2_interfaces": {
        f"/replayer/{name}" for name in player_control.SERVICES.keys() - player_control.WITHOUT_NUMBERS
    },
}
"""Topics and services that nodes have if these packages are installed; the wheels have none of them."""


@pytest.mark.parametrize("node", node_names())
def test_a_policy_names_topics_of_the_contract_only(node):
    rights = _allowed(node)
    own = {name for name in rights["publish"] if name.startswith((f"/{node}/", "/estimate/"))}
    assert rights["publish"] - own <= ALL_TOPICS | OF_ROS
    assert rights["publish"] >= {DIAGNOSTICS, "/parameter_events", "/rosout", f"/{node}/transition_event"}
    assert rights["subscribe"] <= ALL_TOPICS
    if node == "recorder":
        assert rights["subscribe"] == ALL_TOPICS
    if node == "replayer":
        assert rights["publish"] >= ALL_TOPICS


def test_a_node_prints_its_policy(capsys):
    assert start("rig_driver", ["--policy"]) == 0
    assert capsys.readouterr().out == policy_text("rig_driver", load("rig_driver").RIGHTS)


def _allowed(node):
    """Topics and services of the policy that a node prints, by right, with full names."""
    enclave = ET.fromstring(policy_text(node, load(node).RIGHTS).encode()).find("enclaves/enclave")  # noqa: S314 - our own
    assert enclave.get("path") == f"/drill_twin/{node}"
    rights = {"publish": set(), "subscribe": set(), "reply": set(), "request": set()}
    for group in enclave.find("profiles/profile"):
        (right, verdict) = next(iter(group.attrib.items()))
        assert verdict == "ALLOW"
        rights[right] |= {"/" + name.text.replace("~", node) for name in group}
    return rights


@pytest.mark.long
@pytest.mark.parametrize("node", node_names())
def test_a_policy_allows_what_the_running_node_does_and_no_more(bench, small_bag, node):
    given = {"recorder": {"bag": str(bench.folder / "bag_0")}, "replayer": {"bag": str(small_bag), "rate": 0.001}}
    given["rig_driver"] = {"wait_for": "simulator analyzer recorder"}
    given["replayer"]["wait_for"] = "simulator analyzer recorder"
    process = bench.start(node, **given.get(node, {}))
    graph = bench.node

    def names(kind):
        found = getattr(graph, f"get_{kind}_names_and_types_by_node")(node, "/")
        return {name for name, _ in found}

    wanted = _allowed(node)
    for package, more in WHERE_INSTALLED.items():
        if find_spec(package) is None:
            wanted = {right: names - more for right, names in wanted.items()}

    def done():
        present = node in {name for name, _ in graph.get_node_names_and_namespaces()}
        return present and len(names("service")) == len(wanted["reply"])

    if node in {"rig_driver", "replayer"}:  # here they wait for ever
        bench.until(lambda: "waiting for /simulator" in process.text, what=node)
    bench.until(done, what=f"the services of {node}")
    # The gateway publishes commands while a client has control, and the measured state where there is a rig; the
    # replayer what the bag holds; the simulator measures where its scene has sensors, and
    # counts stress where it asks for fatigue.
    absent = {
        "gateway": {RIG_COMMAND, MEASURED_RIG_STATE},
        "replayer": {*TOPICS, *OF_TF} - set(OF_EVERY_RUN),
        "simulator": {STRING_STRESS, SURFACE_STATE},
    }
    followed = {RIG_STATE} if node == "estimator" else set()  # where its topic is mapped so, as by the launch file
    of_subs = {name for names in wanted.values() for name in names if "*" in name}
    assert names("publisher") == wanted["publish"] - absent.get(node, set()) - of_subs
    assert names("subscriber") == wanted["subscribe"] - followed - of_subs
    assert names("service") == wanted["reply"]
    assert names("client") == wanted["request"]
    assert process.end() == 0


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ({"ROS_SECURITY_STRATEGY": "Enforce"}, "would start unsecured"),
        ({"ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_ENABLE": "true"}, "ROS_SECURITY_KEYSTORE"),
    ],
)
def test_no_node_starts_without_the_security_that_was_asked_for(bench, environment, words):
    process = bench.command("analyzer", _analyzer(), **environment)
    assert process.wait() == 2, process.text
    assert words in process.text
    assert "Traceback" not in process.text


def test_a_dds_without_security_is_no_traceback(bench):
    """True of the wheels; a Fast DDS with the plugins complains of the empty keystore instead, as readably."""
    keys = bench.folder / "keys"
    (keys / "enclaves").mkdir(parents=True)
    secured = {"ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_KEYSTORE": str(keys)}
    process = bench.command("analyzer", _analyzer(), **secured)
    assert process.wait() == 2, process.text
    assert "analyzer: error: " in process.text
    assert "Traceback" not in process.text


def _analyzer():
    return [sys.executable, "-m", "drill_twin.ros", "analyzer"]
