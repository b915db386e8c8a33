# SPDX-License-Identifier: Apache-2.0
"""A second publisher of `/clock`: an error in words at once, and the set-point holds."""

import math

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock

from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.topics import CLOCK_TOPIC, RIG_COMMAND


@pytest.mark.fault("a second publisher of /clock", "an error at once; the set-point holds until there is one again")
def test_a_second_clock_is_an_error_at_once_and_the_set_point_holds(bench, joints):
    raws = bench.collect(RIG_COMMAND)
    bench.start("simulator")
    bench.start("rig_driver", wait_for="simulator test")
    bench.until(lambda: len(raws) > 100, what="set-points")
    quality = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    clock = bench.node.create_publisher(Clock, CLOCK_TOPIC, quality)
    message = Clock()
    for second in (100_000, 0, 50, 100_001):  # its history, which a reader that comes is sent
        message.clock.sec = second
        clock.publish(message)
    for node in ("rig_driver", "simulator"):
        status = bench.until_status(node, lambda status: status.level == Level.ERROR)
        assert f"expected one publisher of {CLOCK_TOPIC}, found" in status.text
        assert "/test" in status.text
    message.clock.sec = 100_000
    clock.publish(message)
    bench.spin(0.3)
    raws.clear()
    for second in range(60):
        message.clock.sec = 100_000 * (second % 2)
        clock.publish(message)
        bench.spin(0.05)
    held = {read_command(state)[:2] for state in joints(raws)}
    assert len(held) == 1, held
    assert len(raws) > 30
    weight, speed = held.pop()
    assert 0.0 <= weight <= 40.0
    assert math.isfinite(speed)
    bench.node.destroy_publisher(clock)
    bench.until_status("rig_driver", lambda status: status.level == Level.OK)
    before = len(raws)
    bench.until(lambda: {read_command(state)[:2] for state in joints(raws[before:])} - {(weight, speed)},
                what="the schedule to go on")  # fmt: skip


def test_a_second_clock_that_is_silent_delays_no_set_point(bench, joints):
    """A replayer that waits publishes `/clock` without a message."""
    raws = bench.collect(RIG_COMMAND)
    bench.start("simulator")
    bench.start("rig_driver", wait_for="simulator test")
    bench.until(lambda: len(raws) > 100, what="set-points")
    clock = bench.node.create_publisher(Clock, CLOCK_TOPIC, 10)
    status = bench.until_status("rig_driver", lambda status: status.level == Level.ERROR)
    assert "expected one publisher of" in status.text
    raws.clear()
    bench.spin(3.0)
    stamps = [state.stamp for state in joints(raws)]
    assert len(set(stamps)) > 100, stamps
    bench.node.destroy_publisher(clock)
