# SPDX-License-Identifier: Apache-2.0
"""Row of the topic contract: ROS type, publisher, content, quality of service."""

from __future__ import annotations

from dataclasses import dataclass

JOINT_STATE = "sensor_msgs/msg/JointState"
IMU = "sensor_msgs/msg/Imu"
POSE_ARRAY = "geometry_msgs/msg/PoseArray"
MARKER_ARRAY = "visualization_msgs/msg/MarkerArray"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"
FLOAT64 = "std_msgs/msg/Float64"
STRING = "std_msgs/msg/String"
CLOCK = "rosgraph_msgs/msg/Clock"
TIME_REFERENCE = "sensor_msgs/msg/TimeReference"
TF_TYPE = "tf2_msgs/msg/TFMessage"


@dataclass(frozen=True)
class Topic:
    """Row of the contract."""

    name: str
    """Topic name, absolute."""
    type_name: str
    """ROS type, as `sensor_msgs/msg/JointState`."""
    publisher: str
    """Publishing node."""
    rate: str
    """Condition or rate of publication."""
    meaning: str
    """Content, with units."""
    latched: bool = False
    """TRANSIENT_LOCAL: a late subscriber still receives the last message."""
    depth: int = 10
    """Depth of the history (KEEP_LAST) of subscriptions and of bags; all topics are RELIABLE."""
    optional: bool = False
    """Of a node or an effect that a run need not have."""

    @property
    def publisher_depth(self) -> int:
        """Depth that the nodes offer: messages kept until every reader has them, 5 s at 200 Hz."""
        return self.depth if self.latched else 1000
