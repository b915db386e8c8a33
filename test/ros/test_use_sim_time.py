# SPDX-License-Identifier: Apache-2.0
"""`use_sim_time`: other nodes follow the simulator's /clock, our own run as ever, foreign clocks are ignored."""

from itertools import pairwise

import numpy as np
import pytest
from rclpy.clock import ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from drill_twin.io.messages.cdr import ClockTemplate
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    TOPICS,
    WHIRL_STATE,
)
from drill_twin.ros.core.topics import message_class

FRAME = 10_000_000  # ns, of pa6_bench


def test_a_foreign_node_follows_the_clock_of_the_simulator(bench):
    """Its clock is simulated time, and a timer of 0.1 s fires each tenth of a simulated second."""
    listener = Node("listener", context=bench.node.context, cli_args=["--ros-args", "-p", "use_sim_time:=true"])
    ticks = []
    listener.create_timer(0.1, lambda: ticks.append(listener.get_clock().now().nanoseconds))
    bench._executor.add_node(listener)
    assert listener.get_clock().clock_type == ClockType.ROS_TIME
    bench.spin(0.3)
    assert listener.get_clock().now().nanoseconds == 0  # no clock yet, so time stands still
    states = bench.collect(RIG_STATE)
    simulator = bench.start("simulator", wait_for_command=False, duration=2.0)
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, simulator.text
    bench.until(lambda: listener.get_clock().now().nanoseconds == 2 * 10**9, what="the last /clock")
    bench._executor.remove_node(listener)
    listener.destroy_node()
    assert states
    assert 5 <= len(ticks) <= 21, ticks  # the first ones are missed until the clock is discovered
    assert all(later > before for before, later in pairwise(ticks))


def test_a_foreign_clock_beyond_the_range_of_a_stamp_ends_no_node(bench):
    analyzer = bench.start("analyzer", use_sim_time=True)
    bench.until_status("analyzer", bool)
    clock = bench.node.create_publisher(Clock, CLOCK_TOPIC, 1)
    latest = Clock()
    latest.clock.sec, latest.clock.nanosec = 2**31 - 1, 2**32 - 1
    stamps = []

    def stamped():
        clock.publish(latest)  # the first is lost where the reader has not found the writer yet
        return 2**31 * 10**9 - 1 in stamps

    bench.subscribe(DIAGNOSTICS, lambda raw: stamps.append(decode_diagnostics(bytes(raw))[0]))
    bench.until(stamped, what="diagnostics with the last stamp that there is")
    assert analyzer.end() == 0, analyzer.text


@pytest.mark.long
def test_nodes_with_use_sim_time_make_the_same_run(bench, small_bag, payloads):
    """In lockstep, byte for byte; their diagnostics are stamped with simulated time."""
    given = {"use_sim_time": True}
    folder = bench.folder / "bag_0"
    simulator = bench.start("simulator", pace="lockstep", duration=0.5, **given)
    others = [bench.start("analyzer", **given), bench.start("recorder", bag=str(folder), **given)]
    driver = bench.start("rig_driver", wait_for="simulator analyzer recorder", **given)
    stamps = []
    bench.subscribe(DIAGNOSTICS, lambda raw: stamps.append(decode_diagnostics(bytes(raw))[0]))
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, bench.logs()
    for process in (driver, *others):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
    for topic in (RIG_COMMAND, RIG_STATE, MARKS_STATE, WHIRL_STATE):
        assert payloads(folder, topic) == payloads(small_bag, topic), topic
    assert stamps
    assert max(stamps) <= 0.5e9


def test_a_foreign_clock_that_jumps_does_not_upset_the_simulator(bench, joints):
    """It neither reads /clock for its time nor for its pace, with `use_sim_time` too."""
    states = bench.collect(RIG_STATE)
    clock = bench.node.create_publisher(message_class(TOPICS[CLOCK_TOPIC]), CLOCK_TOPIC, 10)
    simulator = bench.start("simulator", wait_for_command=False, duration=2.0, use_sim_time=True)
    for seconds in (1000.0, 2.0, 1.0e5, 0.0, 3.0, 2.0e9):
        wanted = len(states) + 20
        bench.until(lambda wanted=wanted: len(states) >= wanted, what="the simulator to go on")
        clock.publish(bytes(ClockTemplate().fill(round(seconds * 1e9))))
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, simulator.text
    assert "Traceback" not in simulator.text
    bench.until(lambda: len(states) == 200, what="the last state")
    assert np.array_equal([state.stamp for state in joints(states)], FRAME * np.arange(1, 201))
