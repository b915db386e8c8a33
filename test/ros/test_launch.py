# SPDX-License-Identifier: Apache-2.0
"""The launch files, run by ROS's own launch where it is installed; the wheels have none.

`test_packaging.py` reads the files where there is no launch.
"""

import os
import sys
import time
from pathlib import Path

import pytest

from drill_twin.io.bag.reader import Bag
from drill_twin.ros.core.stop_request import END_WITH_PARENT

pytest.importorskip("launch_ros", reason="needs launch and launch_ros, which are in ROS 2 but not in the wheels")
pytest.importorskip("ros2launch", reason="needs ros2launch, which is in ROS 2 but not in the wheels")

from launch import LaunchContext  # noqa: E402
from launch.actions import DeclareLaunchArgument  # noqa: E402
from launch.launch_description_sources import get_launch_description_from_python_launch_file  # noqa: E402
from launch.utilities import perform_substitutions  # noqa: E402
from launch_ros.actions import Node  # noqa: E402
from test_packaging import FLAGS  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
ROS2 = [sys.executable, "-c", "import sys; from ros2cli.cli import main; sys.exit(main())"]
ALONE = dict.fromkeys(FLAGS["twin"].values(), "false")


@pytest.fixture(autouse=True)
def prefix(tmp_path, monkeypatch):
    """The package as it is installed: its share folder, the ament index, its executables."""
    share, library = tmp_path / "prefix" / "share", tmp_path / "prefix" / "lib" / "drill_twin"
    index = share / "ament_index" / "resource_index" / "packages"
    for folder in (index, library):
        folder.mkdir(parents=True)
    (index / "drill_twin").touch()
    for file in (ROOT / "config").glob("*/*.*"):
        place = share / "drill_twin" / file.relative_to(ROOT / "config")
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
    """Executables that a launch file starts with these arguments."""
    description = get_launch_description_from_python_launch_file(str(ROOT / "config" / "launch" / f"{name}.launch.py"))
    context = LaunchContext()
    for action in description.entities:
        if isinstance(action, DeclareLaunchArgument) and action.default_value is not None:
            context.launch_configurations[action.name] = perform_substitutions(context, action.default_value)
    context.launch_configurations.update(given)
    nodes = [action for action in description.entities if isinstance(action, Node)]
    wanted = [node for node in nodes if node.condition is None or node.condition.evaluate(context)]
    return {perform_substitutions(context, node.node_executable) if isinstance(node.node_executable, list)
            else node.node_executable for node in wanted}  # fmt: skip


@pytest.mark.parametrize(("node", "flag"), FLAGS["twin"].items())
def test_each_node_is_started_by_its_flag_alone(node, flag):
    assert _started("twin", **ALONE) == set()
    assert _started("twin", **{**ALONE, flag: "true"}) == {node}


def test_without_flags_the_twin_runs():
    assert _started("twin") == {"simulator", "rig_driver", "analyzer"}
    assert _started("replay", bag="x") == {"replayer", "analyzer"}
    assert _started("replay", bag="x", analyze="false") == {"replayer"}


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


def _launch(bench, name, given):
    words = [f"{key}:={value}" for key, value in given.items()]
    path = os.environ["AMENT_PREFIX_PATH"]
    return bench.command(f"launch_{name}", [*ROS2, "launch", "drill_twin", f"{name}.launch.py", *words],
                         AMENT_PREFIX_PATH=path, **{END_WITH_PARENT: ""})  # fmt: skip
