# SPDX-License-Identifier: Apache-2.0
"""All nodes in one process make the same run as one process each."""

import yaml

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    REALTIME_FACTOR,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    TOPICS,
    TWIN_SCENE,
    WOB_COMMAND,
)
from drill_twin.scene.set_points.command import Command

COMMANDS = (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND)


def test_one_process_makes_the_same_run(bench, small_bag, payloads):
    folder = bench.folder / "bag_0"
    process = bench.start("twin", pace="lockstep", duration=0.5, record=True, bag=str(folder))
    bench.until(lambda: process.code is not None, what="the run to end")
    assert process.code == 0, process.text
    assert "Traceback" not in process.text
    for topic in set(TOPICS) - {DIAGNOSTICS, TWIN_SCENE, REALTIME_FACTOR}:
        one, several = payloads(folder, topic), payloads(small_bag, topic)
        if topic in COMMANDS and len(one) == len(several) - 1:
            several.pop()  # for the frame after the last: the driver of one process may be stopped before it sends it
        assert one == several, topic


def test_the_whole_process_ends_when_one_of_its_nodes_cannot_start(bench):
    (bench.folder / "bag_0").mkdir()
    process = bench.start("twin", record=True, bag=str(bench.folder / "bag_0"))
    bench.until(lambda: process.code is not None, what="the process to end")
    assert process.code == 2, process.text
    assert "exists" in process.text
    assert "Traceback" not in process.text


def test_what_the_user_gives_stands_before_what_the_process_sets(bench):
    process = bench.start("twin", wait_for="nobody", wait_timeout=1.0)
    bench.until(lambda: process.code is not None, what="the end of the wait")
    assert "waited 1 s for the node /nobody" in process.text


NAMES = {"rig_driver": "drive", "analyzer": "analyze", "recorder": "record", "advisor": "advise",
         "estimator": "estimate", "gateway": "gateway"}  # fmt: skip
FREE_PORT = 24840


def test_every_node_has_a_flag_a_name_and_the_namespace(bench):
    """All of them at once, in a namespace, from a parameter file that addresses single nodes too."""
    folder = bench.folder / "bag_0"
    given = {
        "/**": {"ros__parameters": {**dict.fromkeys(NAMES.values(), True), "bag": str(folder)}},
        "/rig2/gateway": {"ros__parameters": {"port": FREE_PORT + bench.domain, "rate": 5.0}},
        "/rig2/estimator": {"ros__parameters": {"members": 4}},
        "/rig2/advisor": {"ros__parameters": {"runs": 4}},
    }
    file = bench.folder / "twin.yaml"
    file.write_text(yaml.safe_dump(given))
    process = bench.start("twin", "-r", "__ns:=/rig2", "--params-file", str(file), duration=5.0)
    wanted = {("simulator", "/rig2"), *((name, "/rig2") for name in NAMES)}
    bench.until(lambda: wanted <= set(bench.node.get_node_names_and_namespaces()), what="all nodes")
    bench.until(lambda: bench.node.count_publishers("/rig2/whirl/state") > 0, what="the topics")
    listed = [*bench.node.get_topic_names_and_types(), *bench.node.get_service_names_and_types()]
    outside = {name for name, _ in listed if not name.startswith(("/rig2/", "/test/"))}
    assert outside == {DIAGNOSTICS, "/rosout", "/parameter_events"}
    bench.until(lambda: process.code is not None, what="the run to end")
    assert process.code == 0, process.text
    assert "Traceback" not in process.text
    assert f"127.0.0.1:{FREE_PORT + bench.domain}" in process.text
    assert Bag(folder).topics[RIG_STATE].count == 500
    assert {name for part in Bag(folder)._files for name in part.topics} >= {"/rig2/rig/state", "/rig2/whirl/state"}


def test_nodes_can_be_left_out(bench):
    """The simulator alone waits for the commands of others; a parameter of a node that does not run is refused."""
    process = bench.start("twin", drive=False, analyze=False, duration=0.5, pace="fast")
    command = bench.publisher(WOB_COMMAND)
    assert {"rig_driver", "analyzer"}.isdisjoint(bench.node.get_node_names())
    command.publish(bytes(CommandEncoder().wob_command(Command(10.0, 0.0))))
    bench.until(lambda: process.code is not None, what="the run to end")
    assert process.code == 0, process.text
    refused = bench.start("twin", members=4)
    assert refused.wait() == 2
    assert "parameter members: this node has none of that name" in refused.text
