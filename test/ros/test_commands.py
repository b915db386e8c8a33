# SPDX-License-Identifier: Apache-2.0
"""Commands over DDS to a running simulator: good, bad, too few, and from more than one hand."""

import math
import re

import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float32, Float64

from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.rig_messages import COMMAND_JOINTS, DRIVER, CommandEncoder
from drill_twin.io.messages.topics import COMMANDER, RIG_COMMAND, RIG_STATE, RPS_COMMAND, WOB_COMMAND
from drill_twin.scene.set_points import Command
from drill_twin_evidence.verify.statics.block import rig

TURN = 2.0 * math.pi


@pytest.fixture
def simulator(bench):
    process = bench.start("simulator", command_timeout=0.8)
    bench.until_ready("simulator")
    yield process
    assert process.end() == 0, process.text
    assert "Traceback" not in process.text


def unchecked(weight_on_bit, rotation):
    """A `/rig/command` as our encoder would refuse to write it."""
    unset = math.nan
    velocity, effort = (rotation, unset, unset), (unset, weight_on_bit, unset)
    return JointStateTemplate(COMMAND_JOINTS, frame_id=DRIVER).fill(0, (unset,) * 3, velocity, effort)


def _set_points(status):
    return float(status.values["weight_on_bit"]), float(status.values["speed_rev_s"])


def test_time_stands_still_until_the_first_good_command(bench, simulator):
    status = bench.until_status("simulator", bool)
    assert status.values["simulated_time"] == "0.000000"
    assert status.text == "waiting for the first command"
    command = bench.publisher(RIG_COMMAND)
    command.publish(unchecked(math.nan, math.nan))
    status = bench.until_status("simulator", lambda status: status.values["commands_refused"] == "1")
    assert status.values["simulated_time"] == "0.000000"
    command.publish(CommandEncoder().command(0, Command(40.0, 1.0)))
    bench.until_status("simulator", lambda status: float(status.values["simulated_time"]) > 0.5)


@pytest.mark.fault("commands that are not finite or out of range", "refused and counted; the last good one holds")
def test_bad_commands_are_refused_counted_and_change_nothing(bench, simulator, joints):
    command, weight, speed = (bench.publisher(topic) for topic in (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND))
    encoder = CommandEncoder()
    command.publish(encoder.command(0, Command(40.0, 2.0 * TURN)))
    bench.until_status("simulator", lambda status: _set_points(status) == (40.0, 2.0))
    bad = [
        (math.nan, math.nan),
        (40.0, math.inf),
        (-math.inf, 0.0),
        (-5.0, 12.0),
        (40.0, -12.0),
        (1e12, 12.0),
        (40.0, 1e6),
    ]
    for weight_on_bit, rotation in bad:
        command.publish(unchecked(weight_on_bit, rotation))
    state = bench.collect("/rig/state")
    status = bench.until_status("simulator", lambda status: int(status.values["commands_refused"]) == len(bad))
    assert _set_points(status) == (40.0, 2.0)
    assert status.values["commands_refused_not_finite"] == "3"
    assert status.values["commands_refused_out_of_range"] == "4"
    assert "refused" in status.text
    bench.until(lambda: len(state) > 50)
    for sample in joints(state):
        assert sample.effort[sample.index("bit_axial")] == 40.0
        assert math.isfinite(sample.position.sum() + sample.velocity.sum() + sample.effort.sum())
    # The single values are judged in the same way, once ours on /rig/command has been silent for long enough.
    bench.node.destroy_publisher(command)
    age = float(status.values["command_age"])
    bench.until_status("simulator", lambda status: float(status.values["command_age"]) > age + 1.0)
    for value in (math.nan, -3.0, 1e9):
        weight.publish(Float64(data=value))
        speed.publish(Float64(data=value))
    status = bench.until_status("simulator", lambda status: int(status.values["commands_refused"]) == len(bad) + 6)
    assert _set_points(status) == (40.0, 2.0)
    weight.publish(Float64(data=30.0))
    speed.publish(Float64(data=1.0))
    bench.until_status("simulator", lambda status: _set_points(status) == (30.0, 1.0))


def test_a_refused_command_is_reported_with_its_reason(bench, simulator):
    assert "time stands still until a command comes on /rig/command" in simulator.text
    bench.publisher(WOB_COMMAND).publish(Float64(data=1e9))
    told = "waiting for the first good command; the last one was refused: weight on bit: expected 0 to 400 N"
    bench.until_status("simulator", lambda status: status.text.startswith(told))
    bench.until(lambda: told in simulator.text, what="the console to say so too")


def test_a_single_value_leaves_no_warning_and_its_refusal_is_not_hidden(bench, simulator):
    """As `ros2 topic pub --once`: a person who has sent one value is not a driver that has fallen silent."""
    weight = bench.publisher(WOB_COMMAND)
    weight.publish(Float64(data=30.0))
    status = bench.until_status("simulator", lambda status: 2.0 < float(status.values["command_age"]) < 1e9)
    assert "command" not in status.text
    weight.publish(Float64(data=1e9))
    status = bench.until_status("simulator", lambda status: status.values["commands_refused"] == "1")
    assert status.level == 1
    assert status.text == "commands were refused; the last: weight on bit: expected 0 to 400 N, found 1e+09 N"
    status = bench.until_status("simulator", lambda status: "refused" not in status.text)
    assert "command" not in status.text
    assert status.values["commands_refused"] == "1"
    assert status.hardware_id == "drill_twin"


@pytest.mark.parametrize(
    ("kind", "quality", "told"),
    [
        (Float32, 10, "expected std_msgs/msg/Float64, found std_msgs/msg/Float32 of /test"),
        (Float64, qos_profile_sensor_data, "expected a reliable publisher, found /test as best_effort"),
    ],
)
def test_an_incompatible_publisher_is_reported(bench, simulator, kind, quality, told):
    bench.node.create_publisher(kind, WOB_COMMAND, quality)
    status = bench.until_status("simulator", lambda status: told in status.text)
    assert status.level == 1
    assert "not received; publish " in status.text


@pytest.mark.fault("messages that hold no command", "refused, counted and told; time stands still")
def test_messages_that_hold_no_command_are_counted_and_told(bench, simulator):
    """An unknown joint, none, arrays that are too short, and the joint that carried the weight before the release."""
    command, both = bench.publisher(RIG_COMMAND), ["top_drive", "bit_axial"]
    odd = [
        JointState(name=["elbow"], position=[1.0]), JointState(), b"\0\1\0\0 none",
        JointState(name=both, velocity=[12.0], effort=[40.0]),
        JointState(name=["bit", "top_drive"], velocity=[math.nan, 12.0], effort=[40.0, math.nan]),
    ]  # fmt: skip
    for message in odd:
        command.publish(message)
    wanted = str(len(odd))
    status = bench.until_status("simulator", lambda status: status.values.get("commands_refused_malformed") == wanted)
    assert status.values["simulated_time"] == "0.000000"
    assert "expected the weight on bit as effort of the joint 'bit_axial'" in status.text


def test_silence_is_reported_and_the_last_set_point_held(bench, simulator):
    command = bench.publisher(RIG_COMMAND)
    command.publish(CommandEncoder().command(0, Command(40.0, 12.0)))
    status = bench.until_status("simulator", lambda status: "no valid command" in status.text)
    assert status.level == 1
    assert float(status.values["command_age"]) > 0.8
    assert float(status.values["weight_on_bit"]) == 40.0


@pytest.mark.fault("commands stop", "after the age limit a ramp to the safe set-point, or the last one is held")
def test_silence_ramps_to_the_safe_set_point_when_asked(bench, joints):
    process = bench.start(
        "simulator", command_timeout=0.3, on_silence="ramp", safe_ramp_time=0.5, safe_weight_on_bit=5.0
    )
    state = bench.collect("/rig/state")
    bench.until_ready("simulator")
    command = bench.publisher(RIG_COMMAND)
    command.publish(CommandEncoder().command(0, Command(40.0, 12.0)))
    bench.until(lambda: len(state) > 150)
    samples = joints(state)
    drive, bit = samples[0].index("top_drive"), samples[0].index("bit_axial")
    assert max(sample.effort[bit] for sample in samples) == 40.0
    assert samples[-1].effort[bit] == pytest.approx(5.0)
    assert samples[-1].velocity[drive] == pytest.approx(0.0, abs=1e-9)
    assert _set_points(bench.until_status("simulator", bool)) == (5.0, 0.0)
    assert process.end() == 0


@pytest.mark.fault("driver killed (-9) while the twin goes on", "after the age limit a ramp to the safe set-point")
def test_the_set_point_of_a_driver_that_was_killed_does_not_stay(bench, joints):
    process = bench.start("simulator", command_timeout=0.3, safe_ramp_time=0.5, safe_weight_on_bit=5.0)
    state = bench.collect(RIG_STATE)
    driver = bench.start("rig_driver", wait_for="simulator test", overrides="rig.weight_on_bit.duration=0.1 s")
    bench.until(lambda: state and joints(state[-1:])[0].effort[3] == 40.0, what="the weight of the driver")
    assert bench.call("/simulator/pause").success  # a pause is no silence
    bench.spin(0.6)
    assert bench.call("/simulator/resume").success
    count = len(state)
    bench.until(lambda: len(state) > count + 100)
    assert {sample.effort[sample.index("bit_axial")] for sample in joints(state[count:])} == {40.0}
    driver.kill()
    status = bench.until_status("simulator", lambda status: _set_points(status) == (5.0, 0.0))
    assert status.level == Level.WARN
    assert re.fullmatch(r"no valid command of /rig_driver for [\d.]+ s; ramping to the safe set-point", status.text)
    assert "[simulator]: no valid command of /rig_driver for" in process.text
    driver = bench.start("rig_driver", overrides="rig.weight_on_bit.duration=0.1 s")
    bench.until_status("simulator", lambda status: _set_points(status)[0] == 40.0 and status.level == Level.OK)
    for one in (driver, process):
        assert one.end() == 0, one.text


def test_the_simulator_says_who_drives(bench, simulator):
    told = bench.collect(COMMANDER, latched=True)
    driver = bench.start("rig_driver")
    status = bench.until_status("simulator", lambda status: float(status.values["simulated_time"]) > 2.5)
    assert status.values["commander"] == "/rig_driver"
    assert status.values["dropped"] == "0"
    assert int(status.values["unread_most"]) >= 1
    assert status.level == 0
    assert driver.end() == 0
    said = lambda: [read_string(raw) for raw in told]  # noqa: E731
    bench.until(lambda: said()[-1] == "", what="nobody to drive")
    bench.publisher(WOB_COMMAND).publish(Float64(data=30.0))
    bench.until(lambda: said()[-1] == "by hand", what="a person to drive")
    assert said()[:2] == ["", "/rig_driver"]
    assert set(said()) == {"", "/rig_driver", "by hand"}  # a busy machine may be silent in between


@pytest.mark.fault("a person beside the driver", "single values are refused, counted, told; the driver keeps the rig")
def test_a_person_beside_the_driver_is_reported_and_not_followed(bench, simulator):
    driver = bench.start("rig_driver")
    bench.until_status("simulator", lambda status: float(status.values["simulated_time"]) > 0.3)
    weight = bench.publisher(WOB_COMMAND)
    weight.publish(Float64(data=123.0))
    status = bench.until_status("simulator", lambda status: status.values.get("commands_refused_other_source") == "1")
    assert "expected commands of /rig_driver alone" in status.text
    assert "found a single value; stop one of the two" in status.text
    assert float(status.values["weight_on_bit"]) < 40.0
    assert driver.end() == 0


@pytest.mark.fault("two drivers at once", "the first keeps the rig until it is silent, the other is refused and told")
def test_the_second_of_two_drivers_is_refused_while_both_send(bench, simulator):
    first = bench.start("rig_driver")
    bench.until_status("simulator", lambda status: status.values["commander"] == "/rig_driver")
    second = bench.start("rig_driver", "-r", "__node:=other_driver")
    status = bench.until_status("simulator", lambda status: "commands_refused_other_source" in status.values)
    assert status.level == Level.WARN
    named = (
        "commands were refused; the last: expected commands of /rig_driver alone, which has the rig until it is silent "
        "for 0.8 s, found a command of /other_driver; stop one of the two"
    )
    assert status.text == named
    assert status.values["commander"] == "/rig_driver"
    assert f"[WARN] [simulator]: {named}" in re.sub(r" \[[\d.]+\]", "", simulator.text)
    assert first.end() == 0
    bench.until_status("simulator", lambda status: status.values["commander"] == "/other_driver")
    assert second.end() == 0


def test_two_publishers_with_one_name_are_an_error(bench, simulator):
    drivers = [bench.start("rig_driver"), bench.start("rig_driver")]
    status = bench.until_status("simulator", lambda status: status.level == Level.ERROR)
    assert "expected one publisher of /rig/command as /rig_driver, found several" in status.text
    assert drivers[1].end() == 0
    bench.until_status("simulator", lambda status: status.level < Level.ERROR)
    assert drivers[0].end() == 0


def test_a_second_publisher_that_says_nothing_is_no_rival(bench, simulator):
    """And one publisher that was started anew, whose numbers go back once, is none either."""
    driver = bench.start("rig_driver")
    bench.publisher(RIG_COMMAND)
    status = bench.until_status("simulator", lambda status: status.values["commander"] == "/rig_driver")
    driver.kill()
    driver = bench.start("rig_driver")
    time = float(status.values["simulated_time"])
    bench.until_status("simulator", lambda status: float(status.values["simulated_time"]) > time + 2.0)
    assert all(status.level < Level.ERROR for status in bench.history if status.name == "simulator")
    assert driver.end() == 0


@pytest.mark.fault("driver killed (-9) and restarted in lockstep", "time waits for it; no frame is left out")
def test_a_driver_that_is_killed_and_comes_back_picks_up_in_lockstep(bench, joints):
    states = bench.collect(RIG_STATE)
    simulator = bench.start("simulator", pace="lockstep")
    bench.until_ready("simulator")
    driver = bench.start("rig_driver", wait_for="simulator test")
    bench.until(lambda: len(states) > 50, what="the string to move")
    driver.kill()
    bench.until_status("simulator", lambda status: "the lockstep waits" in status.text)
    bench.drain()
    before = len(states)
    driver = bench.start("rig_driver")
    bench.until(lambda: len(states) > before + 50, what="the string to move on")
    assert driver.end() == 0
    status = bench.until_status("simulator", lambda status: "the lockstep waits" in status.text)
    bench.drain()
    # A frame for each command, and none left out; a command that was not answered in time is sent again.
    stamps = [sample.stamp for sample in joints(states)]
    assert stamps == [k * 10_000_000 for k in range(1, len(stamps) + 1)]
    assert int(status.values["frames"]) == len(stamps)
    assert int(status.values["commands_accepted"]) >= len(stamps)
    assert status.values["commands_refused"] == "0"
    assert simulator.end() == 0


@pytest.mark.parametrize("joints_given", [("top_drive",), ("top_drive", "block")])
def test_a_scene_without_a_prescribed_weight_needs_no_bit(bench, tmp_path, joints_given, joints):
    (tmp_path / "block.yaml").write_text(rig({"weight_on_bit": {"at": "block"}, "block": {}}).to_yaml(), "utf-8")
    simulator = bench.start("simulator", scene=str(tmp_path / "block.yaml"))
    bench.until_ready("simulator")
    speeds = {"top_drive": 6.0, "block": -0.005}
    template = JointStateTemplate(joints_given)
    unset = [math.nan] * len(joints_given)
    raw = template.fill(0, unset, [speeds[name] for name in joints_given], unset)
    states, command = bench.collect(RIG_STATE), bench.publisher(RIG_COMMAND)
    command.publish(raw)
    status = bench.until_status("simulator", lambda status: float(status.values.get("speed_rev_s", 0.0)) > 0.5)
    assert status.values["commands_refused"] == "0"
    bench.until(lambda: len(states) > 5)
    block = joints(states)[-1]
    assert (block.velocity[block.index("block")] < -0.001) == ("block" in joints_given)
    assert simulator.end() == 0
