# SPDX-License-Identifier: Apache-2.0
"""Parameter files as in any ROS 2 system: a block for all nodes, blocks for one node, and values with their units."""

import re
from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters

from drill_twin.io.messages.topics import STRING_POSES

PAGE = Path(__file__).parents[2] / "docs/rig.md"
DOCUMENTED = re.search(r"```yaml\n(/\*\*:\n.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
NODES = ("simulator", "rig_driver", "analyzer", "recorder")
SHARED = "    command_timeout: 2 s\n    use_sim_time: false\n    wob: 20 N\n    members: 8\n"


@pytest.fixture
def file(bench):
    def write(text):
        path = bench.folder / "given.yaml"
        path.write_text(text, "utf-8")
        return "--params-file", str(path)

    return write


@pytest.mark.parametrize("wildcard", ["/**", "/*"])
def test_a_block_for_all_nodes_starts_all_nodes_without_a_word(bench, file, wildcard):
    """The file of docs/rig.md, and names that one node has: also a node of a companion, which does not run here."""
    given = file(DOCUMENTED[1].replace("/**:", f'"{wildcard}":', 1) + SHARED)
    processes = [bench.start(node, *given, **({"bag": str(bench.folder / "bag_0")} if node == "recorder" else {}))
                 for node in NODES]  # fmt: skip
    for node in NODES:
        bench.until(lambda node=node: node in bench.node.get_node_names(), what=node)
    bench.until(lambda: bench.node.get_publishers_info_by_topic(STRING_POSES) != [], what="the simulator")
    offered = bench.node.get_publishers_info_by_topic(STRING_POSES)[0].qos_profile
    assert offered.durability.name == "TRANSIENT_LOCAL"
    request = GetParameters.Request(names=["command_timeout"])
    found = bench.call("/simulator/get_parameters", request, GetParameters).values[0]
    assert found.string_value == "2 s"
    for process in processes:
        assert process.code is None, process.text
        assert "parameter" not in process.text
        assert process.end() == 0, process.text


def test_a_name_that_no_node_has_is_a_warning_for_all_nodes_and_an_error_for_one(bench, file):
    misspelled = "    command_timout: 2.0\n    qos_overrides:\n      /string/posse:\n        publisher: {depth: 5}\n"
    process = bench.start("analyzer", *file(f"/**:\n  ros__parameters:\n{misspelled}"))
    for words in ("command_timout: no node of drill_twin has it; did you mean command_timeout?",
                  "did you mean qos_overrides./string/poses.publisher.depth?"):  # fmt: skip
        bench.until(lambda words=words: words in process.text, what=words)
    assert process.end() == 0, process.text
    shared = "/**:\n  ros__parameters:\n    command_timeout: 2.0\n"
    for own in ("analyzer:\n", "/analyzer:\n", "/**/analyzer:\n"):
        refused = bench.start("analyzer", *file(f"{shared}{own}  ros__parameters:\n    command_timeout: 2.0\n"))
        assert refused.wait() == 2, refused.text
        assert "parameter command_timeout: this node has none of that name; it has marks_scene" in refused.text
    refused = bench.start("analyzer", *file(shared), command_timeout=2.0)
    assert refused.wait() == 2, refused.text


def test_the_twin_in_one_process_takes_the_same_file(bench, file):
    given = file(f"{DOCUMENTED[1]}{SHARED}    command_timout: 2.0\n")
    process = bench.start("twin", *given, duration=0.2, pace="fast")
    assert process.wait() == 0, process.text
    assert process.text.count("command_timout: no node of drill_twin has it") == 1
