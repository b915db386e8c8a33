# SPDX-License-Identifier: Apache-2.0
"""The examples of the rig guide do what it says they do, and the commands of the guides are those of the code."""

import math
import re
import shutil
import signal
import sys
from ast import literal_eval
from pathlib import Path

import pytest
from std_msgs.msg import Float64

from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TOPICS, WHIRL_STATE
from drill_twin.ros.core.topics import NodeTopics
from drill_twin.ros.entry_points import load
from drill_twin.whirl import MotionCode

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
PAGES = ("rig.md", "howto/connect_a_rig.md", "howto/replay_a_bag.md", "tutorial/ros.md")
GUIDE = "\n".join((ROOT / "docs" / page).read_text("utf-8") for page in PAGES)


def test_an_own_driver_and_an_own_analyzer_take_part(bench, joints):
    states, marks, largest = bench.collect(RIG_STATE), bench.collect(MARKS_STATE), []
    bench.node.create_subscription(Float64, "/own/largest_offset", largest.append, 1000)
    simulator = bench.start("simulator", pace="lockstep", duration=3.0)
    bench.until_ready("simulator")
    analyzer = bench.command("own_analyzer", [sys.executable, str(EXAMPLES / "own_analyzer.py")])
    bench.until(lambda: bench.node.count_publishers("/own/largest_offset") == 1, what="the analyzer")
    bench.until(lambda: bench.node.count_subscribers(MARKS_STATE) == 2)
    driver = bench.command("own_driver", [sys.executable, str(EXAMPLES / "own_driver.py")])
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, bench.logs()
    bench.drain()
    for sample in joints(states):
        share = min(sample.stamp * 1e-9 / 2.0, 1.0)
        assert sample.effort[sample.index("bit_axial")] == pytest.approx(40.0 * share)
        assert sample.velocity[sample.index("top_drive")] == pytest.approx(4.0 * math.pi * share)
    assert len(states) == 300
    wanted = [
        max(math.hypot(*sample.position.reshape(-1, 4)[k, :2]) for k in range(len(sample.names) // 4))
        for sample in joints(marks)
    ]
    bench.until(lambda: len(largest) > 0 and largest[-1].data == pytest.approx(wanted[-1]))
    assert analyzer.end() == 0, analyzer.text
    assert driver.end() == 0, driver.text
    assert "mark_1 " in analyzer.text
    assert "Traceback" not in analyzer.text + driver.text


@pytest.mark.parametrize("order", [("driver", "simulator"), ("simulator", "driver"), ("simulator", "stop", "driver")])
def test_an_own_driver_and_the_simulator_meet_in_any_order(bench, order):
    """Also where the simulator hears nothing while the driver starts: the first command may reach no reader."""
    begun = {}
    for one in order:
        if one == "stop":
            bench.until_ready("simulator")
            begun["simulator"].send(signal.SIGSTOP)
        elif one == "simulator":
            begun[one] = bench.start("simulator", pace="lockstep", duration=1.0)
        else:
            begun[one] = bench.command("own_driver", [sys.executable, str(EXAMPLES / "own_driver.py")])
            bench.until(lambda: bench.node.count_publishers("/rig/command") == 1, what="the driver")
    begun["simulator"].send(signal.SIGCONT)
    bench.until(lambda: begun["simulator"].code is not None, what="the run to end")
    assert begun["simulator"].code == 0, bench.logs()
    assert begun["driver"].end() == 0, begun["driver"].text


def test_a_listener_of_a_stranger_learns_onset_whirl_rates_loads_and_driver_in_a_line_each(bench):
    text = (EXAMPLES / "listener.py").read_text("utf-8")
    assert "drill_twin" not in text
    listener = bench.command("listener", [sys.executable, str(EXAMPLES / "listener.py")])
    hard = "rig.weight_on_bit.value=100 N; rig.weight_on_bit.duration=1 s; rig.rotation.duration=0.5 s"
    analyzer, simulator = bench.start("analyzer"), bench.start("simulator", overrides=hard)
    driver = bench.start("rig_driver", wait_for="simulator analyzer", overrides=hard)

    def said():
        lines = [line for line in listener.text.splitlines() if line.startswith("{")]
        return literal_eval(lines[-1]) if lines else {}

    bench.until(lambda: said().get("onset", 0.0) > 0.0, what="the onset")
    found = said()
    assert set(found) == {"onset", "motion", "rate", "torque", "weight", "driver"}
    assert found["driver"] == "/rig_driver"
    assert found["weight"] == 100.0
    assert found["rate"] == 0.0  # this bit does not drill
    assert found["motion"] in set(MotionCode)
    assert driver.end() == analyzer.end() == simulator.end() == listener.end() == 0


def test_the_table_shows_the_depth_that_publishers_offer(bench):
    page = (ROOT / "docs/reference/topics.md").read_text("utf-8")
    table = page.partition("<!-- printed: topics_quality -->")[2].splitlines()
    topics = NodeTopics(bench.node, lambda _: None, lambda call: call())
    for name in TOPICS:
        row = next(line for line in table if line.startswith(f"| `{name}` |"))
        assert f"keep last {topics.advertise(name).qos_profile.depth}" in row


def test_topics_types_and_services_that_the_guide_names_exist():
    for topic, kind in re.findall(r"ros2 topic pub (?:-\S+ (?:\d+ )?)*(/\S+) (\S+)", GUIDE):
        assert TOPICS[topic].type_name == kind
    for topic in re.findall(r"ros2 topic (?:echo|hz) (/[\w/]+)", GUIDE):
        assert topic in TOPICS
    services = set(re.findall(r"ros2 service call /simulator/(\w+) std_srvs/srv/Trigger", GUIDE))
    assert services >= {"pause", "resume", "step", "reset", "save_checkpoint", "load_checkpoint"}
    assert {f"~/{name}" for name in services} <= set(load("simulator").RIGHTS.services)
    live = {
        (make.NAME, parameter.name)
        for make in map(load, ("rig_driver", "simulator", "replayer"))
        for parameter in make.PARAMETERS
        if parameter.live
    }
    said = set(re.findall(r"ros2 param set /(\w+) (\w+)", GUIDE))
    assert said
    assert said <= live


@pytest.mark.long
def test_nodes_on_several_machines_find_each_other_by_a_discovery_server(bench):
    """Here on one machine, with discovery of its own switched off: without the server they do not meet."""
    server = shutil.which("fast-discovery-server", path=f"{Path(sys.executable).parent}:/opt/ros/jazzy/bin")
    if server is None:
        pytest.skip("fast-discovery-server is in neither the virtual environment nor /opt/ros/jazzy")
    port = 20000 + bench.domain
    process = bench.command("server", [server, "-i", "0", "-l", "127.0.0.1", "-p", str(port)])
    bench.environment |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    lonely = bench.start("analyzer")
    bench.spin(1.0)
    bench.environment |= {"ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}"}
    del bench.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    recorded = bench.folder / "bag_0"
    simulator = bench.start("simulator", duration=2.0, pace="lockstep")
    recorder, analyzer = bench.start("recorder", bag=str(recorded)), bench.start("analyzer")
    driver = bench.start("rig_driver", wait_for="simulator analyzer recorder")
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, bench.logs()
    for node in (driver, analyzer, recorder):
        assert node.end() == 0, bench.logs()
    assert "analysing" in analyzer.text
    assert "analysing" not in lonely.text
    from drill_twin.io.bag.reader import Bag

    assert Bag(recorded).topics[WHIRL_STATE].count == 200
    lonely.kill()
    process.kill()
