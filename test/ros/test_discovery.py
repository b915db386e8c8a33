# SPDX-License-Identifier: Apache-2.0
"""Nodes find each other on this host, quickly, and only in their own domain; two demos never share one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.topics import RIG_STATE, TWIN_SCENE
from drill_twin.ros import deployment as discovery


def test_a_domain_is_claimed_once_and_free_again_afterwards():
    first = discovery.DomainClaim()
    assert 1 <= first.domain <= discovery.HIGHEST_DOMAIN
    with pytest.raises(DrillTwinError, match="in use by another drill_twin"):
        discovery.DomainClaim(first.domain)
    second = discovery.DomainClaim(start=first.domain - 1)
    assert second.domain != first.domain
    first.release()
    discovery.DomainClaim(first.domain).release()
    second.release()


def test_a_claim_ends_with_its_process(tmp_path):
    hold = (
        "import time; from drill_twin.ros.deployment import DomainClaim; "
        "claim = DomainClaim(); print(claim.domain, flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", hold], stdout=subprocess.PIPE, text=True)
    domain = int(process.stdout.readline())
    with pytest.raises(DrillTwinError):
        discovery.DomainClaim(domain)
    process.kill()
    process.wait()
    discovery.DomainClaim(domain).release()


def test_what_the_user_has_set_stays(monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", "/mine.xml")
    discovery.prepare()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] == "/mine.xml"


def test_by_default_discovery_stays_on_this_host(monkeypatch):
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    monkeypatch.delenv("FASTRTPS_DEFAULT_PROFILES_FILE", raising=False)
    discovery.prepare()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    profile = Path(os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text("utf-8")
    assert "leaseAnnouncement" in profile


def _join(bench):
    """A newcomer finds a topic of a node that is there already."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=bench.domain, signal_handler_options=SignalHandlerOptions.NO)
    node = Node("newcomer", context=context)
    try:
        bench.until(lambda: node.count_publishers(RIG_STATE) > 0)
    finally:
        node.destroy_node()
        context.try_shutdown()


def test_who_joins_late_is_connected_and_gets_what_is_latched(make_bench):
    bench = make_bench()
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until_ready("simulator")
    bench.spin(1.0)  # the announcements that follow a start are over
    for _ in range(3):
        _join(bench)
    states, scenes = bench.collect(RIG_STATE), bench.collect(TWIN_SCENE, latched=True)
    bench.until(lambda: bool(states) and bool(scenes), what="the first message")
    other = make_bench()
    assert other.domain != bench.domain
    heard = other.collect(RIG_STATE)
    other.spin(1.0)
    assert not heard
    assert other.node.count_publishers(RIG_STATE) == 0
    assert simulator.end() == 0
