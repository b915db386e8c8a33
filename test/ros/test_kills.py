# SPDX-License-Identifier: Apache-2.0
"""kill -9 of each node at random times while recording: bags stay readable, and the node that comes back is in step.

`make kills` kills each node 50 times and prints a table; on a quiet machine it checks the times too.
"""

import os
import random
import time
from statistics import median

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE, WHIRL_STATE
from drill_twin.report.recording import read_recording

KILLS = int(os.environ.get("DRILL_TWIN_KILLS", "0"))
BACK, LOST = 5.0, 0.25  # s, on a quiet machine
FRAME = 10_000_000  # ns
SIGN_OF_LIFE = {"simulator": RIG_STATE, "analyzer": WHIRL_STATE, "rig_driver": RIG_COMMAND}


@pytest.mark.parametrize("under_way", [True, False])
def test_a_driver_joins_a_run_whose_simulator_does_not_answer(bench, under_way):
    """After a kill the answers of services may be lost for long, while all topics are connected."""
    server = Context()
    rclpy.init(args=[], context=server, domain_id=bench.domain, signal_handler_options=SignalHandlerOptions.NO)
    mute = Node("simulator", context=server)  # not spun, so its service is there and does not answer
    mute.create_service(Trigger, "~/ready", lambda _, response: response)
    clock = mute.create_publisher(Clock, "/clock", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    mute.create_subscription(JointState, "/rig/command", lambda _: None, 10)
    clock.publish(Clock(clock=Time(seconds=5 if under_way else 0).to_msg()))
    commands = bench.collect(RIG_COMMAND)
    try:
        driver = bench.start("rig_driver", wait_timeout=1000.0 if under_way else 3.0)
        bench.until(lambda: bool(commands) or driver.code is not None, what="a command, or the end of the wait")
    finally:
        mute.destroy_node()
        server.try_shutdown()
    if under_way:
        assert JointStateReader().read(bytes(commands[0])).stamp == 5 * 10**9 + FRAME
        assert "did not answer; its run is under way" in driver.text
    else:
        assert (driver.code, len(commands)) == (1, 0)
        assert "waited 3 s for the node /simulator: it did not answer" in driver.text


class Rig:
    """All nodes, recording, each of which can be killed and started again."""

    def __init__(self, bench):
        self.bench, self.bags, self.processes = bench, [], {}
        self.seen = {node: bench.collect(topic) for node, topic in SIGN_OF_LIFE.items()}
        for node in ("simulator", "analyzer", "recorder", "rig_driver"):
            self.start(node)
        bench.until(lambda: all(self.seen.values()), what="all nodes to be in step")

    def start(self, node):
        given = {
            "simulator": {"checkpoint": str(self.bench.folder / "run.npz"), "checkpoint_period": 0.5},
            "recorder": {"bag": str(self.bench.folder / f"bag{len(self.bags)}_0")},
        }.get(node, {})
        if node == "recorder":
            self.bags.append(given["bag"])
        self.processes[node] = self.bench.start(node, **given)

    def kill(self, node):
        """Kill a node; returns the wall time [ns] at which it was gone."""
        self.processes[node].kill()
        return time.time_ns()

    def wait_for(self, node):
        """Seconds until a node that was started again does its work."""
        began = time.monotonic()
        for raws in self.seen.values():
            raws.clear()
        self.bench.until(lambda: self.works(node), what=f"{node} to be back")
        return time.monotonic() - began

    def works(self, node):
        if node != "recorder":
            return bool(self.seen[node])
        try:
            return Bag(self.bags[-1]).topics[RIG_STATE].count > 0
        except BagError:  # not yet begun
            return False


@pytest.mark.long
@pytest.mark.fault(
    "each node killed (-9) at random times while recording", "bags are readable, the node is back in step"
)
def test_each_node_is_killed_at_random_and_comes_back(bench):
    chance, rig = random.Random(5), Rig(bench)
    nodes = [node for node in rig.processes for _ in range(max(KILLS, 1))]
    chance.shuffle(nodes)
    back, lost = {node: [] for node in rig.processes}, []
    for node in nodes:
        bench.spin(chance.uniform(0.5, 2.0))
        gone = rig.kill(node)
        if node == "recorder":
            bag = Bag(rig.bags[-1])
            last = max(stamp for _, stamp, _ in bag.messages((RIG_STATE,)))
            lost.append((gone - last) * 1e-9)
            assert read_recording(rig.bags[-1]).duration > 0.0
        rig.start(node)
        back[node].append(rig.wait_for(node))
    for node in ("rig_driver", "simulator", "analyzer", "recorder"):
        assert rig.processes[node].end() == 0, rig.processes[node].text
    assert not Bag(rig.bags[-1]).truncated
    print(f"\n{'node':<12}{'kills':>6}{'back after, median':>20}{'longest':>9}")
    for node, times in back.items():
        print(f"{node:<12}{len(times):>6}{median(times):>18.2f} s{max(times):>7.2f} s")
    print(f"lost of a bag: median {median(lost):.3f} s, most {max(lost):.3f} s")
    if KILLS:
        assert max(max(times) for times in back.values()) <= BACK
        assert max(lost) <= LOST
