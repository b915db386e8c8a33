# SPDX-License-Identifier: Apache-2.0
"""Two twins in one domain, and remapped topics: no node receives the messages of another twin."""

import math

import pytest
from sensor_msgs.msg import JointState

from drill_twin.io.messages.decode import JointStateReader


def _received(bench, topic):
    raws = []
    bench.node.create_subscription(JointState, topic, raws.append, 1000, raw=True)
    return raws


def _applied(raws):
    state = JointStateReader().read(bytes(raws[-1]))
    return state.effort[state.index("bit")], state.velocity[state.index("top_drive")]


@pytest.mark.long
def test_two_twins_run_side_by_side(bench):
    steady = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
    wanted = {"left": ("20 N", "1 rev/s"), "right": ("50 N", "3 rev/s")}
    states, whirls, processes = {}, {}, []
    for name, (weight, speed) in wanted.items():
        space = ("-r", f"__ns:=/{name}")
        states[name], whirls[name] = _received(bench, f"/{name}/rig/state"), _received(bench, f"/{name}/whirl/state")
        given = {"weight_on_bit": weight, "rotation": speed, "overrides": steady}
        processes += [bench.start("simulator", *space), bench.start("analyzer", *space)]
        processes.append(bench.start("rig_driver", *space, wait_for="simulator analyzer", **given))
    for name, (weight, speed) in {"left": (20.0, 1.0), "right": (50.0, 3.0)}.items():
        there = (pytest.approx(weight), pytest.approx(speed * 2.0 * math.pi))
        bench.until(lambda name=name, there=there: bool(states[name]) and _applied(states[name]) == there)
        bench.until(lambda name=name: bool(whirls[name]), what=f"the analyzer of {name}")
        status = bench.until_status(f"{name}/simulator", lambda status: status.values["frames"] != "0")
        assert status.values["command_sources"] == f"/{name}/rig_driver"
        assert status.hardware_id == f"drill_twin/{name}"
    assert bench.node.count_publishers("/rig/state") == 0
    for process in processes:
        assert process.end() == 0, process.text


def test_a_topic_goes_by_the_name_it_is_given(bench):
    simulator = bench.start("simulator", "-r", "rig/command:=/auto_driller/set_points", "-r", "rig/state:=/measured")
    driver = bench.start("rig_driver", "-r", "rig/command:=/auto_driller/set_points")
    measured = _received(bench, "/measured")
    bench.until(lambda: len(measured) > 20, what="the state under its new name")
    status = bench.until_status("simulator", lambda status: status.values["frames"] != "0")
    assert status.values["command_sources"] == "/rig_driver"
    assert bench.node.count_publishers("/rig/command") == bench.node.count_publishers("/rig/state") == 0
    for process in (driver, simulator):
        assert process.end() == 0, process.text
