# SPDX-License-Identifier: Apache-2.0
"""Example of a listener: onset, motion of a mark, rate of penetration, torque, weight and driver, once a second."""

from contextlib import suppress

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("listener")
listen, seen = node.create_subscription, {}
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
listen(TimeReference, "whirl/onset", lambda m: seen.update(onset=m.time_ref.sec + 1e-9 * m.time_ref.nanosec), latched)
listen(JointState, "whirl/state", lambda m: seen.update(motion=int(m.position[m.name.index("mark_2/motion")])), 10)
listen(JointState, "rig/state", lambda m: seen.update(rate=m.velocity[m.name.index("bit_axial")]), 10)
listen(JointState, "rig/state", lambda m: seen.update(torque=m.effort[m.name.index("bit")]), 10)
listen(JointState, "rig/state", lambda m: seen.update(weight=m.effort[m.name.index("bit_axial")]), 10)
listen(String, "rig/commander", lambda m: seen.update(driver=m.data), latched)
node.create_timer(1.0, lambda: print(seen, flush=True))
with suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    rclpy.spin(node)
