# SPDX-License-Identifier: Apache-2.0
"""Two twins in one domain, and remapped topics: no node receives the messages of another twin."""

import math
import sys

import pytest
import yaml
from rclpy.node import Node
from sensor_msgs.msg import JointState

import drill_twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.decode import JointStateReader, read_joint_state
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE, TOPICS, WHIRL_STATE


def _received(bench, topic):
    raws = []
    bench.node.create_subscription(JointState, topic, raws.append, 1000, raw=True)
    return raws


def _applied(raws):
    state = JointStateReader().read(bytes(raws[-1]))
    return state.effort[state.index("bit_axial")], state.velocity[state.index("top_drive")]


@pytest.mark.long
def test_two_twins_run_side_by_side(bench):
    steady = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
    wanted = {"left": ("20 N", "1 rev/s"), "right": ("50 N", "3 rev/s")}
    states, whirls, processes = {}, {}, []
    for name, (weight, speed) in wanted.items():
        space = ("-r", f"__ns:=/{name}")
        processes.append(bench.start("recorder", *space, bag=str(bench.folder / f"{name}_0")))
        states[name], whirls[name] = _received(bench, f"/{name}/rig/state"), _received(bench, f"/{name}/whirl/state")
        given = {"wob": weight, "rpm": speed, "overrides": steady}
        processes += [bench.start("simulator", *space, frame_prefix=f"{name}/"), bench.start("analyzer", *space)]
        processes.append(bench.start("rig_driver", *space, wait_for="simulator analyzer recorder", **given))
    for name, (weight, speed) in {"left": (20.0, 1.0), "right": (50.0, 3.0)}.items():
        there = (pytest.approx(weight), pytest.approx(speed * 2.0 * math.pi))
        bench.until(lambda name=name, there=there: bool(states[name]) and _applied(states[name]) == there)
        bench.until(lambda name=name: bool(whirls[name]), what=f"the analyzer of {name}")
        status = bench.until_status(f"{name}/simulator", lambda status: status.values["frames"] != "0")
        assert status.values["commander"] == f"/{name}/rig_driver"
        assert status.hardware_id == f"drill_twin/{name}"
    assert bench.node.count_publishers("/rig/state") == bench.node.count_publishers("/clock") == 0
    for process in reversed(processes):
        assert process.end() == 0, process.text
    for name, (_, speed) in {"left": (20.0, 1.0), "right": (50.0, 3.0)}.items():
        _is_bag_of(bench.folder / f"{name}_0", name, speed)
    both = _both(bench.folder)
    _is_replayed(bench, both)


def _is_bag_of(folder, name, speed):
    """A bag has the names with the namespace, and only what its own twin said; its analysis equals the live one."""
    recorded = {topic for file in Bag(folder)._files for topic in file.topics}
    assert recorded == {topic if topic == DIAGNOSTICS else f"/{name}{topic}" for topic in TOPICS}
    assert yaml.safe_load((folder / "metadata.yaml").read_text("utf-8"))["rosbag2_bagfile_information"]["custom_data"][
        "namespace"
    ] == (f"/{name}")
    result = drill_twin.read_bag(folder)
    # The largest, not the last: once its driver has ended, the simulator ramps to the safe set-point.
    assert result.rig.top_drive_speed.max() == pytest.approx(speed * 2.0 * math.pi)
    assert result.recording.live.messages > 0
    assert result.recording.live.differing == 0
    assert {read_joint_state(raw).frame_id for _, _, raw in Bag(folder).messages((MARKS_STATE, WHIRL_STATE))} == {
        f"{name}/hole"
    }
    for _, _, raw in Bag(folder).messages((DIAGNOSTICS,)):
        assert {status.hardware_id for status in decode_diagnostics(raw)[1]} == {f"drill_twin/{name}"}


def _both(folder):
    """One bag of both twins, as `ros2 bag record --all` writes it."""
    files = [file for name in ("left", "right") for file in Bag(folder / f"{name}_0")._files]
    topics = {name: topic for file in files for name, topic in file.topics.items()}
    with BagWriter(folder / "both_0", topics=topics.values()) as writer:
        for name, stamp, raw in sorted(row for file in files for row in file.messages()):
            writer.write(name, stamp, raw)
    return folder / "both_0"


def _is_replayed(bench, both):
    """`replay` asks for the twin, publishes it under its recorded names; `use_sim_time` follows a renamed `/clock`."""
    refused = bench.command("asked", [sys.executable, "-m", "drill_twin.cli", "replay", str(both)])
    assert refused.wait() == 2
    assert "found twins of the namespaces /left, /right; choose with --namespace" in refused.text
    states = _received(bench, "/right/marks/state")
    listener = Node(
        "listener",
        context=bench.node.context,
        cli_args=["--ros-args", "-r", "/clock:=/right/clock", "-p", "use_sim_time:=true"],
    )
    bench._executor.add_node(listener)
    player = bench.command(
        "replay", [sys.executable, "-m", "drill_twin.cli", "replay", str(both), "--namespace", "/right", "--rate", "0"]
    )
    bench.until(lambda: player.code is not None, what="the end of the replay")
    assert player.code == 0, player.text
    bench.drain()
    wanted = [raw for _, _, raw in Bag(both, namespace="right").messages((MARKS_STATE,))]
    assert [bytes(raw)[: len(wanted[0])] for raw in states[-len(wanted) :]] == wanted
    assert 0 < listener.get_clock().now().nanoseconds <= read_joint_state(wanted[-1]).stamp
    bench._executor.remove_node(listener)
    listener.destroy_node()


def test_a_topic_goes_by_the_name_it_is_given(bench):
    simulator = bench.start("simulator", "-r", "rig/command:=/auto_driller/set_points", "-r", "rig/state:=/measured")
    driver = bench.start("rig_driver", "-r", "rig/command:=/auto_driller/set_points")
    measured = _received(bench, "/measured")
    bench.until(lambda: len(measured) > 20, what="the state under its new name")
    status = bench.until_status("simulator", lambda status: status.values["frames"] != "0")
    assert status.values["commander"] == "/rig_driver"
    assert bench.node.count_publishers("/rig/command") == bench.node.count_publishers("/rig/state") == 0
    for process in (driver, simulator):
        assert process.end() == 0, process.text
