# SPDX-License-Identifier: Apache-2.0
"""Commanders of another hand: their clocks, parts of a command, and a first command that nobody could read yet."""

import math
import time
from itertools import pairwise

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from drill_twin.io.messages.decode import read_clock, read_string
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.topics import CLOCK_TOPIC, COMMANDER, RIG_STATE

FRAME = 10_000_000  # ns


class Commander:
    """A node's publisher of `/rig/command`, which sends 20 times a second."""

    def __init__(self, bench, name="", stamp=time.time_ns, weight=20.0, speed=6.0):
        self.publisher = bench.node.create_publisher(JointState, "rig/command", 10)
        self.name, self.stamp, self.weight, self.speed = name, stamp, weight, speed
        self.timer = bench.node.create_timer(0.05, self.send)

    def send(self):
        joints = {"bit_axial": (math.nan, self.weight), "top_drive": (self.speed, math.nan)}
        given = {name: pair for name, pair in joints.items() if not all(map(math.isnan, pair))}
        message = JointState(name=[*given])
        message.velocity, message.effort = ([pair[k] for pair in given.values()] for k in (0, 1))
        message.header.frame_id = self.name
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self.stamp(), 10**9)
        self.publisher.publish(message)


def number(status, name):
    return float(status.values.get(name, 0))


def until_applied(bench, weight, turns):
    """Wait until these set-points are applied."""
    return bench.until_status(
        "simulator",
        lambda status: number(status, "weight_on_bit") == weight and status.values["speed_rev_s"] == f"{turns:g}",
    )


@pytest.mark.parametrize("action", ["reset", "load_checkpoint"])
def test_a_commander_with_the_wall_clock_commands_on_after_time_went_back(bench, action):
    simulator = bench.start("simulator", saved_checkpoint=str(bench.folder / "kept.npz"))
    commander = Commander(bench, "/integrator", speed=2.0 * math.tau)
    until_applied(bench, 20.0, 2.0)
    assert bench.call("/simulator/save_checkpoint").success
    bench.until_status("simulator", lambda status: number(status, "simulated_time") > 2.0)
    assert bench.call(f"/simulator/{action}").success
    commander.weight = commander.speed = 0.0  # a stop
    bench.until_status("simulator", lambda status: status.values["commander"] == "/integrator")
    until_applied(bench, 0.0, 0.0)
    assert simulator.end() == 0, simulator.text


def wall(seconds):
    return lambda: time.time_ns() + round(seconds * 1e9)


@pytest.mark.parametrize(
    ("stamp", "kind", "told"),
    [
        (lambda: 10**9, "stamp_behind", "s behind; stamp by /clock"),
        (lambda: 2_000_000_000 * 10**9, "stamp_ahead", "s ahead; synchronise the clocks, or stamp zero"),
        (wall(2.1), "stamp_ahead", "another clock, 2.1 s ahead; synchronise the clocks, or stamp zero"),
        (wall(-3600.0), "stamp_behind", "another clock, 3600 s behind; synchronise the clocks, or stamp zero"),
    ],
)
def test_a_stamp_of_no_clock_does_not_command_in_real_time(bench, stamp, kind, told):
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until_status("simulator", lambda status: number(status, "simulated_time") > 2.0)
    Commander(bench, stamp=stamp, weight=77.0)
    status = bench.until_status(
        "simulator", lambda status: number(status, f"commands_refused_{kind}") > 5 and told in status.text
    )
    assert status.level == Level.WARN
    assert "stamp: expected simulated time (" in status.text
    assert (status.values["commands_accepted"], status.values["weight_on_bit"]) == ("0", "0")
    assert simulator.end() == 0, simulator.text


def test_a_publisher_keeps_to_the_clock_of_its_first_stamp(bench):
    """Zero is no clock: who uses simulated time sends it before the first `/clock`."""
    simulator = bench.start("simulator")
    now = [0]
    bench.node.create_subscription(Clock, "clock", lambda message: now.append(
        message.clock.sec * 10**9 + message.clock.nanosec), 10)  # fmt: skip
    commander = Commander(bench, stamp=lambda: now[-1] if len(now) > 100 else 0)
    bench.until(lambda: len(now) > 200, what="time to run")
    commander.stamp = time.time_ns
    status = bench.until_status("simulator", lambda status: number(status, "commands_refused_stamp_other_clock") > 2)
    assert "expected simulated time, as this source began with, found the wall clock" in status.values["last_refusal"]
    assert simulator.end() == 0, simulator.text


@pytest.mark.parametrize("pace", ["fast", "lockstep"])
def test_the_wall_clock_says_nothing_at_other_paces(bench, pace):
    simulator = bench.start("simulator", pace=pace)
    Commander(bench)
    status = bench.until_status("simulator", lambda status: number(status, "commands_refused_stamp_wall_clock") > 2)
    assert "found a wall clock; stamp by /clock" in status.text
    assert status.values["frames"] == "0"
    assert simulator.end() == 0, simulator.text


def test_a_command_under_way_from_before_a_reset_does_not_begin_the_new_run(bench):
    simulator = bench.start("simulator", pace="lockstep")
    bench.until_ready("simulator")
    stamp = [FRAME]
    commander = Commander(bench, "/own", stamp=lambda: stamp[0])
    for frame in range(1, 31):
        stamp[0] = frame * FRAME
        commander.send()
    bench.until_status("simulator", lambda status: status.values["frames"] == "30")
    assert bench.call("/simulator/reset").success
    stamp[0] = 31 * FRAME
    status = bench.until_status("simulator", lambda status: number(status, "commands_refused_before_reset") > 2)
    assert status.values["frames"] == "0"
    stamp[0] = FRAME
    bench.until_status("simulator", lambda status: status.values["frames"] == "1")
    assert simulator.end() == 0, simulator.text


def test_a_commander_may_change_to_the_wall_clock_when_time_goes_back(bench):
    clocks = bench.collect(CLOCK_TOPIC)
    simulator = bench.start("simulator")
    stamp = [lambda: read_clock(clocks[-1]) + FRAME if clocks else FRAME]
    commander = Commander(bench, "/own", stamp=lambda: stamp[0]())  # noqa: PLW0108 - it changes
    until_applied(bench, 20.0, 6.0 / math.tau)
    bench.until_status("simulator", lambda status: number(status, "simulated_time") > 2.0)
    stamp[0] = time.time_ns
    assert bench.call("/simulator/reset").success
    commander.weight = 10.0
    status = until_applied(bench, 10.0, 6.0 / math.tau)
    assert number(status, "simulated_time") < 2.0  # no need to pass the time of before
    assert simulator.end() == 0, simulator.text


def test_a_driller_and_a_top_drive_own_a_quantity_each_and_lose_it_by_silence(bench, joints):
    told, states = bench.collect(COMMANDER, latched=True), bench.collect(RIG_STATE)
    simulator = bench.start("simulator", command_timeout=0.8, safe_ramp_time=1.0)
    bench.until_ready("simulator")
    driller = Commander(bench, "/auto_driller", weight=40.0, speed=math.nan)
    drive = Commander(bench, "/top_drive", weight=math.nan, speed=2.0 * math.tau)
    status = until_applied(bench, 40.0, 2.0)
    both = "/auto_driller (weight on bit), /top_drive (top-drive speed)"
    assert status.values["commander"] == both
    assert status.values["commands_refused"] == "0"
    assert (status.values["commander_weight_on_bit"], status.values["commander_rotation"]) == (driller.name, drive.name)
    bench.until(lambda: both in map(read_string, told), what="both on /rig/commander")
    bench.node.destroy_timer(driller.timer)
    status = until_applied(bench, 0.0, 2.0)
    assert status.values["commander"] == "/top_drive"
    assert "no valid weight on bit of /auto_driller for" in status.text
    assert status.text.endswith("s; ramping to the safe set-point")
    states.clear()
    Commander(bench, "/another", weight=30.0, speed=math.nan)
    until_applied(bench, 30.0, 2.0)
    weights = [state.effort[state.index("bit_axial")] for state in joints(states)]
    steps = [later - before for before, later in pairwise(weights)]
    assert 0.0 < max(steps) < 1.0, max(steps)  # 30 N within a second, 0.3 N a frame
    assert simulator.end() == 0, simulator.text


def test_lockstep_says_whose_command_it_waits_for(bench):
    simulator = bench.start("simulator", pace="lockstep", command_timeout=0.5)
    bench.until_ready("simulator")
    stamp = [FRAME]
    driller = Commander(bench, "/auto_driller", stamp=lambda: stamp[0], speed=math.nan)
    bench.until_status("simulator", lambda status: status.values["frames"] == "1")
    Commander(bench, "/top_drive", stamp=lambda: 50 * FRAME, weight=math.nan)
    waits = "no valid weight on bit of /auto_driller for"
    status = bench.until_status("simulator", lambda status: status.text.startswith(waits))
    told = (
        "the lockstep waits for a /rig/command with the stamp of the next frame, after t = 0.01 s, the last is stamped "
        "0.01 s"
    )
    assert told in status.text
    stamp[0] = 2 * FRAME
    driller.send()
    bench.until_status("simulator", lambda status: status.values["frames"] == "2")
    assert simulator.end() == 0, simulator.text


def test_a_first_command_that_nobody_could_read_is_asked_for_again(bench):
    """A driver that answers each `/clock`, and whose publisher was not connected when it answered the first."""
    simulator = bench.start("simulator", pace="lockstep", duration=0.2)
    bench.until_ready("simulator")
    sent = []

    def answer(message):
        if not sent:
            sent.append(bench.node.create_publisher(JointState, "rig/command", 10))
        command = JointState(name=["bit_axial", "top_drive"], velocity=[math.nan, 6.0], effort=[20.0, math.nan])
        after = message.clock.sec * 10**9 + message.clock.nanosec + FRAME
        command.header.stamp.sec, command.header.stamp.nanosec = divmod(after, 10**9)
        sent[0].publish(command)

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    bench.node.create_subscription(Clock, "clock", answer, latched)
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, simulator.text
