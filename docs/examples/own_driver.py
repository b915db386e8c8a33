# SPDX-License-Identifier: Apache-2.0
"""Example of a rig driver: for each message on /clock, send the set-points of the next frame."""

import math
from contextlib import suppress

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

FRAME = 10_000_000  # ns, at the scene's 100 frames a second


def on_clock(message: Clock) -> None:
    """Ramp to 40 N and 2 rev/s within two seconds."""
    ahead = message.clock.sec * 10**9 + message.clock.nanosec + FRAME
    share = min(ahead * 1e-9 / 2.0, 1.0)
    command = JointState(name=["bit_axial", "top_drive"])
    command.header.frame_id = node.get_fully_qualified_name()  # who commands
    command.header.stamp.sec, command.header.stamp.nanosec = divmod(ahead, 10**9)
    command.effort = [40.0 * share, math.nan]  # weight on bit [N]
    command.velocity = [math.nan, 4.0 * math.pi * share]  # top drive [rad/s]
    commands.publish(command)


rclpy.init()
node = rclpy.create_node("own_driver")
commands = node.create_publisher(JointState, "rig/command", 10)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(Clock, "clock", on_clock, latched)
with suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    rclpy.spin(node)
