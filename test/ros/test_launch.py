# SPDX-License-Identifier: Apache-2.0
"""The launch files, run by ROS's own launch where it is installed; the wheels have none.

`test_packaging.py` reads the files where there is no launch.
"""

import os
import re
import signal
import sys
import time
from pathlib import Path

import pytest
import yaml
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python

from drill_twin.io.bag.reader import Bag
from drill_twin.ros.core.stop_request import END_WITH_PARENT

pytest.importorskip("launch_ros", reason="needs launch and launch_ros, which are in ROS 2 but not in the wheels")
pytest.importorskip("ros2launch", reason="needs ros2launch, which is in ROS 2 but not in the wheels")

from launch import LaunchContext  # noqa: E402
from launch.launch_description_sources import get_launch_description_from_python_launch_file  # noqa: E402
from launch_ros.actions import LifecycleNode, Node  # noqa: E402

from drill_twin.ros.entry_points import TWIN  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
ROS2 = [sys.executable, "-c", "import sys; from ros2cli.cli import main; sys.exit(main())"]
FLAGS = {node: row.flag for node, row in TWIN.items()} | {"rviz2": "rviz"}
ALONE = dict.fromkeys(FLAGS.values(), "false")


@pytest.fixture(autouse=True)
def prefix(tmp_path, monkeypatch):
    """The package as it is installed: its share folder, the ament index, its executables."""
    share, library = tmp_path / "prefix" / "share", tmp_path / "prefix" / "lib" / "drill_twin"
    index = share / "ament_index" / "resource_index" / "packages"
    for folder in (index, library):
        folder.mkdir(parents=True)
    for folder in (ROOT, *ROOT.glob("companions/*")):
        package = "drill_twin" if folder == ROOT else folder.name
        (index / package).touch()
        for file in (folder / "config").glob("*/*.*"):
            place = share / package / file.relative_to(folder / "config")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.symlink_to(file)
    (share / "drill_twin" / "package.xml").symlink_to(ROOT / "package.xml")
    for file in (ROOT / "resource" / "executables").iterdir():
        (library / file.name).symlink_to(file)
    command = library / "drill-twin"
    command.write_text(f"#!{sys.executable}\nfrom drill_twin.cli import main\nmain()\n")
    command.chmod(0o755)
    found = os.pathsep.join([str(tmp_path / "prefix"), *filter(None, [os.environ.get("AMENT_PREFIX_PATH")])])
    monkeypatch.setenv("AMENT_PREFIX_PATH", found)


def _started(name, **given):
    """Actions of the nodes that a launch file starts with these arguments."""
    description = get_launch_description_from_python_launch_file(str(ROOT / "config" / "launch" / f"{name}.launch.py"))
    context = LaunchContext()
    context.launch_configurations.update(given)
    made = [action for entity in description.entities for action in entity.execute(context) or ()]
    return {action._Node__node_executable: action for action in made if isinstance(action, Node)}


@pytest.mark.parametrize(("node", "flag"), FLAGS.items())
def test_each_node_is_started_by_its_flag_alone(node, flag):
    assert _started("twin", **ALONE) == {}
    alone = _started("twin", **{**ALONE, flag: "true"})
    assert set(alone) == {node}
    assert isinstance(alone[node], LifecycleNode) is (node != "rviz2")


def test_without_flags_the_twin_runs():
    assert set(_started("twin")) == {"simulator", "rig_driver", "analyzer"}
    assert set(_started("replay", bag="x")) == {"replayer", "analyzer"}
    assert set(_started("replay", bag="x", analyze="false")) == {"replayer"}


def test_a_launch_records_a_run_and_ends_with_it(bench):
    bag = bench.folder / "bag_0"
    given = {"namespace": "rig2", "frame_prefix": "rig2/", "record": "true", "bag": bag, "watch": "true",
             "watch_port": "0", "pace": "lockstep", "duration": "0.5"}  # fmt: skip
    launch = _launch(bench, "twin", given)
    assert launch.wait() == 0, launch.text
    assert "http://127.0.0.1:" in launch.text
    assert "Traceback" not in launch.text
    recorded = Bag(bag)
    assert recorded.topics["/rig/state"].count == 50
    assert {name for file in recorded._files for name in file.topics} >= {"/rig2/rig/state", "/rig2/whirl/state"}


def test_any_subset_runs_in_launches_of_its_own(bench):
    """Simulator and analyzer in one, the rig driver in another, which comes later."""
    first = _launch(bench, "twin", {"drive": "false", "duration": "0.5", "pace": "fast"})
    bench.until(lambda: {"simulator", "analyzer"} <= set(bench.node.get_node_names()), what="the first launch")
    assert "rig_driver" not in bench.node.get_node_names()
    second = _launch(bench, "twin", {"simulate": "false", "analyze": "false"})
    assert first.wait() == 0, first.text
    assert second.code is None, second.text
    assert second.end() == 0, second.text


def test_a_launch_ends_with_an_error_when_a_node_does(bench):
    launch = _launch(bench, "twin", {"scene": "no_such_scene"})
    assert launch.wait() == 1, launch.text
    assert "no_such_scene" in launch.text
    end = time.monotonic() + 30.0
    while bench.node.get_node_names() != ["test"] and time.monotonic() < end:
        bench.spin(0.1)
    assert bench.node.get_node_names() == ["test"]


def test_a_node_that_is_not_required_may_fail_and_comes_back(bench):
    """The rig's loop goes on without the recorder; without the simulator there is no loop, so the launch ends."""
    given = {"drive": "false", "analyze": "false", "record": "true", "respawn": "true", "required": "simulator"}
    launch = _launch(bench, "twin", given)
    bench.until_ready("simulator", "recorder")
    _kill(launch, "recorder")
    bench.until(lambda: len(_pids(launch, "recorder")) == 2, what="the second recorder")
    bench.until_ready("simulator", "recorder")
    assert launch.code is None, launch.text
    _kill(launch, "simulator")
    assert launch.wait() == 1, launch.text
    assert "ended with exit code -9, so the launch ends" in launch.text
    bench.until(lambda: not any(map(_runs, _pids(launch, "recorder"))), what="the end of the recorder")


def test_a_killed_launch_leaves_no_node_behind_that_came_back(bench):
    launch = _launch(bench, "twin", {"drive": "false", "analyze": "false", "record": "true", "respawn": "true"})
    bench.until_ready("simulator", "recorder")
    _kill(launch, "recorder")
    bench.until(lambda: len(_pids(launch, "recorder")) == 2, what="the second recorder")
    launch.kill()
    nodes = [*_pids(launch, "recorder"), *_pids(launch, "simulator")]
    bench.until(lambda: not any(map(_runs, nodes)), what="the end of the nodes")


def test_a_node_that_would_be_refused_again_does_not_come_back(bench):
    """A recorder begins no second bag of the same name; the simulator goes on."""
    bag = bench.folder / "bag_0"
    given = {"drive": "false", "analyze": "false", "record": "true", "respawn": "true", "bag": bag}
    launch = _launch(bench, "twin", given)
    bench.until_ready("simulator", "recorder")
    _kill(launch, "recorder")
    bench.until(lambda: "exit code 2" in launch.text, what="the refusal")
    bench.spin(5.0)
    assert len(_pids(launch, "recorder")) == 2
    bench.until_ready("simulator")
    assert launch.end() == 0, launch.text
    refused = _launch(bench, "twin", given)  # at its first start, what the user gave is wrong
    assert refused.wait() == 1, refused.text


def test_an_argument_that_is_given_goes_before_the_file_and_a_default_does_not(bench):
    file = bench.folder / "given.yaml"
    blocks = {"/simulator": {"pace": "fast", "command_timeout": 7.0}, "/rig_driver": {"wob": "20 N"},
              "/**": {"scene": "two_mass", "overrides": "rig.rotation.value=1 rev/s"}}  # fmt: skip
    file.write_text(yaml.safe_dump({name: {"ros__parameters": values} for name, values in blocks.items()}))
    launch = _launch(bench, "twin", {"params_file": file, "wob": "60 N", "analyze": "false", "scene": "pa6_bench"})
    bench.until_ready("simulator")
    found = {**_parameters(bench, "simulator", "pace", "command_timeout", "scene", "overrides"),
             **_parameters(bench, "rig_driver", "wob")}  # fmt: skip
    assert found == {"pace": "fast", "command_timeout": 7.0, "wob": "60 N", "scene": "pa6_bench",
                     "overrides": "rig.rotation.value=1 rev/s"}  # fmt: skip
    assert launch.end() == 0, launch.text


def test_a_replay_that_is_launched_analyses_every_frame(bench, small_bag):
    found = bench.collect("/whirl/state")
    launch = _launch(bench, "replay", {"bag": small_bag, "rate": "0.0"})
    assert launch.wait() == 0, launch.text
    bench.drain()
    assert len(found) == Bag(small_bag).topics["/whirl/state"].count


def test_required_names_nodes(bench):
    launch = _launch(bench, "twin", {"required": "simulator camera"})
    assert launch.wait() == 1
    assert "required: expected some of simulator, rig_driver, analyzer" in launch.text
    assert "found camera" in launch.text


def _pids(launch, node):
    return [int(pid) for pid in re.findall(rf"\[{node}-\d+\]: process started with pid \[(\d+)\]", launch.text)]


def _kill(launch, node):
    os.kill(_pids(launch, node)[-1], signal.SIGKILL)


def _runs(pid):
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text("utf-8")
    except FileNotFoundError:
        return False


def _parameters(bench, node, *names):
    answer = bench.call(f"/{node}/get_parameters", GetParameters.Request(names=list(names)), GetParameters)
    return {name: parameter_value_to_python(value) for name, value in zip(names, answer.values, strict=True)}


def _launch(bench, name, given):
    words = [f"{key}:={value}" for key, value in given.items()]
    path = os.environ["AMENT_PREFIX_PATH"]
    return bench.command(f"launch_{name}", [*ROS2, "launch", "drill_twin", f"{name}.launch.py", *words],
                         AMENT_PREFIX_PATH=path, **{END_WITH_PARENT: ""})  # fmt: skip
