# SPDX-License-Identifier: Apache-2.0
"""Live parameters take effect at once; an invalid value is refused and changes nothing."""

import itertools
import math

import pytest
from rcl_interfaces.srv import DescribeParameters

from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE
from drill_twin.ros.rig_driver.plan import transition
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command, Schedule


def _applied(joints, raws):
    return [
        (state.effort[state.index("bit_axial")], state.velocity[state.index("top_drive")]) for state in joints(raws)
    ]


def test_a_changeover_begins_flat_ends_flat_and_does_not_jump():
    plan = transition(Command(40.0, 12.0), lambda time: Command(60.0 + time, 6.0), 10.0, 2.0)
    assert plan(9.0) == plan(10.0) == Command(40.0, 12.0)
    assert plan(11.0) == Command(pytest.approx(55.5), pytest.approx(9.0))
    assert plan(12.0) == Command(72.0, 6.0)
    path = [plan(10.0 + 0.01 * k).weight_on_bit for k in range(201)]
    assert max(b - a for a, b in itertools.pairwise(path)) < 0.3
    assert path[1] - path[0] < 0.01
    assert transition(Command(1.0, 1.0), lambda _: Command(2.0, 2.0), 5.0, 0.0)(5.0) == Command(2.0, 2.0)


def test_set_points_of_the_driver_are_live(bench, joints):
    simulator = bench.start("simulator", pace="realtime")
    states = bench.collect(RIG_STATE)
    steady = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
    driver = bench.start("rig_driver", wait_for="simulator test", overrides=steady, change_time=2.0)
    bench.until(lambda: _applied(joints, states[-1:]) == [(40.0, pytest.approx(4.0 * math.pi))])
    assert bench.set_parameter("rig_driver", "wob", 55.0).successful
    assert bench.set_parameter("rig_driver", "rpm", "60 rpm").successful
    bench.until(lambda: _applied(joints, states[-1:]) == [(55.0, pytest.approx(2.0 * math.pi))])
    weights = [weight for weight, _ in _applied(joints, states)]
    late = weights[weights.index(40.0) :]
    between = {weight for weight in late if 40.0 < weight < 55.0}
    assert between, late  # a change, no jump; a late driver skips most of its way
    for name, value, words in (("wob", "55 rpm", "wob: expected a force"), ("rpm", 60.0, "found 60.0 without a unit")):
        refused = bench.set_parameter("rig_driver", name, value)
        assert not refused.successful
        assert words in refused.reason
    assert not bench.set_parameter("rig_driver", "scene", "ufrj_rig").successful
    assert _applied(joints, states[-1:])[0][0] == 55.0
    for process in (driver, simulator):
        assert process.end() == 0, process.text


def test_a_reset_after_a_live_change_is_a_launch_with_these_set_points(bench, joints):
    """Also where the change was still under way: time goes back, and with it what belongs to the run before."""
    simulator = bench.start("simulator", pace="lockstep")
    states = bench.collect(RIG_STATE)
    driver = bench.start("rig_driver", wait_for="simulator test", change_time=1000.0)
    bench.until(lambda: states and joints(states[-1:])[0].stamp > 9 * 10**9, what="the end of the ramps")
    assert bench.set_parameter("rig_driver", "wob", "60 N").successful
    bench.until_status("rig_driver", lambda status: float(status.values["weight_on_bit"]) > 40.0)
    states.clear()
    bench.call("/simulator/reset")
    bench.until(lambda: any(state.stamp == 2 * 10**9 for state in joints(states)), what="two seconds of the new run")
    for process in (driver, simulator):
        assert process.end() == 0, process.text
    begun = next(number for number, state in enumerate(joints(states)) if state.stamp < 10**8)
    plan = Schedule.from_scene(load_scene("pa6_bench", overrides={"wob": "60 N"}))
    late = [plan.at(state.stamp * 1e-9).weight_on_bit - weight for state, (weight, _) in zip(
        joints(states[begun:]), _applied(joints, states[begun:]), strict=True) if state.stamp <= 2 * 10**9]  # fmt: skip
    assert max(map(abs, late)) < 1e-9


def test_limits_of_the_simulator_are_live_and_described(bench):
    process = bench.start("simulator", command_timeout=3600.0)
    bench.until_ready("simulator")
    command, encoder = bench.publisher(RIG_COMMAND), CommandEncoder()
    assert bench.set_parameter("simulator", "max_weight_on_bit", "0.05 kN").successful
    assert bench.set_parameter("simulator", "max_speed", "120 rpm").successful
    command.publish(encoder.command(0, Command(60.0, 6.0)))
    bench.until_status("simulator", lambda status: status.values["commands_refused"] == "1")
    assert bench.set_parameter("simulator", "max_weight_on_bit", 70.0).successful
    command.publish(encoder.command(0, Command(60.0, 6.0)))
    bench.until_status("simulator", lambda status: status.values["weight_on_bit"] == "60")
    for name, value in (("command_timeout", -1.0), ("on_silence", "explode"), ("pace", "fast"), ("step_frames", 0),
                        ("max_speed", 12.0), ("max_speed", "700 rev/s"), ("safe_weight_on_bit", "80 N"),
                        ("safe_speed", "130 rpm")):  # fmt: skip
        assert not bench.set_parameter("simulator", name, value).successful, name
    # Silence counts by the new limit, and the ramp ends at the new safe set-point.
    for name, value in (("safe_ramp_time", 0.2), ("on_silence", "ramp"), ("command_timeout", "300 ms")):
        assert bench.set_parameter("simulator", name, value).successful, name
    bench.until_status("simulator", lambda status: "ramping to the safe set-point" in status.text)
    request = DescribeParameters.Request(names=["command_timeout", "scene"])
    live, fixed = bench.call("/simulator/describe_parameters", request, DescribeParameters).descriptors
    assert not live.read_only
    assert "[s]" in live.description
    assert fixed.read_only
    assert process.end() == 0, process.text


@pytest.mark.long
def test_quality_of_service_comes_from_a_parameter_file(bench, tmp_path):
    file = tmp_path / "quality.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    qos_overrides:\n      /rig/state:\n        publisher:\n"
        "          reliability: best_effort\n      /rig/command:\n        subscription:\n          depth: 3\n",
        "utf-8",
    )
    process = bench.start("simulator", "--params-file", str(file))
    bench.until(lambda: bench.node.get_publishers_info_by_topic(RIG_STATE) != [], what="the simulator")
    offered = bench.node.get_publishers_info_by_topic(RIG_STATE)[0].qos_profile
    assert offered.reliability.name == "BEST_EFFORT"
    assert process.end() == 0, process.text
    for name, value, words in (
        ("/rig/state.publisher.reliability", "perhaps", "reliable or best_effort"),
        ("/rig/stat.publisher.depth", 3, "did you mean qos_overrides./rig/state.publisher.depth"),
    ):
        process = bench.start("simulator", **{f"qos_overrides.{name}": value})
        assert process.wait() == 2, process.text
        assert words in process.text
        assert "Traceback" not in process.text
