# SPDX-License-Identifier: Apache-2.0
"""Row of the topic contract: ROS type, publisher, content, quality of service."""

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
WITH_HEADER = frozenset({JOINT_STATE, POSE_ARRAY, IMU})
"""Types that begin with a header, by whose stamps messages are selected."""


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
    """TRANSIENT_LOCAL: a late subscriber still receives the last message, and none from before."""
    keeps_last: bool = False
    """Its publishers offer the last message to a late subscriber that asks; readers of a bag or a page do not ask."""
    optional: bool = False
    """Of a node or an effect that a run need not have."""

    @property
    def depth(self) -> int:
        """Depth of the history (KEEP_LAST) of subscriptions and of bags; all topics are RELIABLE."""
        return 1 if self.latched else 10

    @property
    def offered_latched(self) -> bool:
        """True where publishers keep one message for late subscribers."""
        return self.latched or self.keeps_last

    @property
    def publisher_depth(self) -> int:
        """Depth that the nodes offer: messages kept until every reader has them, 5 s at 200 Hz.

        With a single one none was lost at 2000 messages a second, in bursts of five, since DDS sends at once; in a
        flood a latched message waits until every reader has the last.
        """
        if self.latched and self.type_name == TF_TYPE:  # a bag may hold a message of each broadcaster
            return 100
        return 1 if self.offered_latched else 1000
