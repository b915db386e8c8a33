# SPDX-License-Identifier: Apache-2.0
"""Example of an analyzer: offset of each mark from the axis of the hole, and the largest one as a topic."""

import math
from contextlib import suppress

import rclpy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64


def on_marks(message: JointState) -> None:
    """Positions are named MARK/x, MARK/y, MARK/z [m] and MARK/spin [rad]."""
    place = dict(zip(message.name, message.position, strict=True))
    marks = sorted({name.partition("/")[0] for name in place})
    offset = {mark: math.hypot(place[f"{mark}/x"], place[f"{mark}/y"]) for mark in marks}
    largest.publish(Float64(data=max(offset.values())))
    time = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    node.get_logger().info(
        f"t = {time:.2f} s: " + ", ".join(f"{mark} {metres * 1e3:.1f} mm" for mark, metres in offset.items()),
        throttle_duration_sec=1.0,
    )


rclpy.init()
node = rclpy.create_node("own_analyzer")
largest = node.create_publisher(Float64, "own/largest_offset", 10)
node.create_subscription(JointState, "marks/state", on_marks, 1000)
with suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    rclpy.spin(node)
