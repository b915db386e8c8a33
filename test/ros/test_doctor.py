# SPDX-License-Identifier: Apache-2.0
"""`drill-twin ros doctor`: a healthy twin has no problem, and each fault put in is found with its remedy."""

import json
import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.ros.doctor.graph import CLOCKS, Observed, graph_checks, observe
from drill_twin.ros.doctor.installation import Verdict, ros_installation


def _doctor(bench, *arguments, **environment):
    """Exit code, and the checks by section and name."""
    process = bench.command(
        "doctor", [sys.executable, "-m", "drill_twin.cli", "ros", "doctor", "--json", *arguments], **environment
    )
    bench.until(lambda: process.code is not None, what="the doctor")
    text = process.text
    found = json.loads(text[text.index("{") :])
    assert found["ok"] == (process.code == 0), text
    return process.code, {(check["section"], check["name"]): check for check in found["checks"]}


def test_a_running_twin_is_described_and_faults_are_named(bench):
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until_status("simulator", lambda status: status.values.get("frames", "0") != "0")
    for _ in range(5):  # a machine that is busy may keep the twin from real time, and the doctor then tells so
        code, checks = _doctor(bench, "--duration", "4")
        if code == 0:
            break
    assert code == 0, [check for check in checks.values() if check["verdict"] == "problem"]
    assert checks["nodes", "/simulator"]["found"].startswith("drill_twin 0.")
    assert checks["topics", "/rig/state"]["found"].startswith("/simulator (reliable)")
    assert "x real time" in checks["clocks", "/clock"]["found"]

    weak = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node = bench.node
    ends = [
        node.create_publisher(JointState, "/rig/command", weak),
        node.create_publisher(Float64, "/rig/state", 10),
        node.create_subscription(JointState, "/marks/state", lambda _: None, latched),
    ]
    code, checks = _doctor(bench, "--duration", "4")
    assert code == 1
    assert "asks for reliable, /test offers best effort" in checks["topics", "/rig/command"]["found"]
    assert "std_msgs/msg/Float64 of /test" in checks["topics", "/rig/state"]["found"]
    assert "/test asks for latched, /simulator offers not latched" in checks["topics", "/marks/state"]["found"]
    assert all(check["remedy"] for check in checks.values() if check["verdict"] == "problem")
    assert ends
    assert simulator.end() == 0


def test_a_clock_is_timed_by_when_it_was_sent(bench):
    """A doctor that comes late to its messages, on a busy machine, takes no faster clock for it."""
    quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    clock, stopped, delays = bench.node.create_publisher(Clock, "/clock", quality), threading.Event(), [1.5]

    def tell():
        while not stopped.wait(0.01):
            clock.publish(Clock(clock=Time(nanoseconds=time.time_ns()).to_msg()))

    def spin_late(seconds):
        if delays:
            time.sleep(delays.pop())
        bench.spin(seconds)

    bench.until(lambda: bench.node.count_publishers("/clock") == 1)
    sender = threading.Thread(target=tell)
    sender.start()
    try:
        seen = observe(bench.node, spin_late, 4.0)
    finally:
        stopped.set()
        sender.join()
    (check,) = [check for check in graph_checks(replace(seen, nodes=["/test"])) if check.section == CLOCKS]
    assert check.found.endswith("1.00 x real time"), check


@pytest.mark.parametrize(("tools", "advice"), [("", "drill-twin ros node twin"), ("ros2", "ros2 launch drill_twin")])
def test_the_way_to_start_a_twin_is_one_that_is_installed(tmp_path, monkeypatch, tools, advice):
    for tool in filter(None, [tools]):
        (tmp_path / tool).touch(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    (check,) = graph_checks(Observed([], {}, {}, {}, {}))
    assert check.remedy.startswith(advice)


CLOCK_END = SimpleNamespace(
    node_name="simulator", node_namespace="/", topic_type="rosgraph_msgs/msg/Clock", qos_profile=QoSProfile(depth=1)
)
SENDS_A_CLOCK = ({"/clock": [CLOCK_END]}, {"/clock": []})
"""Publishers and readers of a domain with a clock."""


def test_nodes_that_wait_after_the_end_of_a_run_are_no_problem(bench):
    """The doctor called each node that waits for the next run a problem, and sent the user to its log."""
    bench.start("analyzer")
    simulator = bench.start("simulator", pace="fast", duration=1.0, wait_for_command=False)
    bench.until(lambda: simulator.code is not None, what="the end of the run")
    assert simulator.code == 0
    bench.until_status("analyzer", lambda status: status.level == Level.STALE)
    code, checks = _doctor(bench, "--duration", "4")
    assert code == 0, checks
    assert checks["nodes", "/analyzer"]["found"].startswith("waits: no good sample of /marks/state")
    assert "the run has ended" in checks["nodes", "simulator"]["found"]
    assert checks["nodes", "simulator"]["remedy"].startswith("start a simulator or a replay")


def test_a_clock_of_another_namespace_starts_no_node():
    silent = Status("rig2/analyzer", Level.STALE, "no good sample of /rig2/marks/state for 8.0 s", {}, "drill_twin")
    for clock, verdict in (("/rig1/clock", Verdict.NOTE), ("/rig2/clock", Verdict.PROBLEM)):
        seen = Observed(["/rig2/analyzer"], {clock: [CLOCK_END]}, {clock: []}, {"/rig2/analyzer": silent}, {})
        assert {check.name: check for check in graph_checks(seen)}["/rig2/analyzer"].verdict is verdict


def test_nodes_that_wait_in_a_pause_of_their_simulator_are_no_problem():
    silent = Status("analyzer", Level.STALE, "no good sample of /marks/state for 8.0 s", {}, "drill_twin")
    for state, verdict in (("paused", Verdict.OK), ("running", Verdict.PROBLEM)):
        simulator = Status("simulator", Level.OK, f"{state} at t = 20 s", {"state": state}, "drill_twin")
        statuses = {"/analyzer": silent, "/simulator": simulator}
        seen = Observed(list(statuses), *SENDS_A_CLOCK, statuses, {})
        found = {check.name: check for check in graph_checks(seen)}
        assert found["/analyzer"].verdict is verdict
        assert ("the simulator is paused" in found["/analyzer"].found) == (state == "paused")


def test_a_domain_that_is_none_and_a_missing_profile_are_problems(bench, tmp_path):
    missing = str(tmp_path / "missing.xml")
    code, checks = _doctor(bench, ROS_DOMAIN_ID="900", FASTRTPS_DEFAULT_PROFILES_FILE=missing)
    assert code == 1
    assert "found '900'" in checks["ROS 2", "domain"]["found"]
    assert missing in checks["ROS 2", "DDS profile"]["found"]
    assert not any(section == "nodes" for section, _ in checks)


@pytest.mark.parametrize(("variable", "value"), [("ROS_DISTRO", "kilted"), ("RMW_IMPLEMENTATION", "rmw_none_cpp")])
def test_another_distribution_or_a_missing_middleware_is_a_problem(variable, value):
    code = (
        "from drill_twin.ros.doctor.installation import ros_installation\n"
        "print([check.found for check in ros_installation() if check.verdict == 'problem'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ, **{variable: value}),
    )
    assert value in done.stdout, done.stdout + done.stderr


def test_without_ros_it_says_so_and_nothing_is_wrong(monkeypatch):
    monkeypatch.setattr("drill_twin.ros.doctor.installation.ros_present", lambda: False)
    (check,) = ros_installation()
    assert check.verdict == "note"
    assert "not installed" in check.found
    assert "make setup" in check.remedy
