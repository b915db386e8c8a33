# SPDX-License-Identifier: Apache-2.0
"""tf of a running twin, where tf2_msgs is installed; the wheels have none, a ROS 2 does."""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from drill_twin.dynamics.twin.frame import Frame
from drill_twin.io.messages.drawing.geometry import StringGeometry
from drill_twin.io.messages.drawing.transforms import StringTransforms, TransformsTemplate, hole_transform
from drill_twin.io.messages.stamps import stamp_ns

_DEPTH = 100


def tf_message() -> Any:
    """The class tf2_msgs/TFMessage; None where the package is not installed."""
    try:
        return importlib.import_module("tf2_msgs.msg").TFMessage
    except ImportError:
        return None


class TfPublisher:
    """Publishes `tf` at the rate of the markers, and `tf_static` once."""

    def __init__(self, node: Node, kind: Any, geometry: StringGeometry, inclination: float) -> None:
        """Create both publishers.

        Args:
            node: The simulator.
            kind: `tf_message()`.
            geometry: Of the string.
            inclination: Of the hole at the top clamp [rad].
        """
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node = node
        self._moving = node.create_publisher(kind, "tf", _DEPTH)
        self._fixed = node.create_publisher(kind, "tf_static", latched)
        self._transforms = StringTransforms(geometry)
        self._template: TransformsTemplate | None = None
        hole = hole_transform(inclination, geometry.frame_prefix)
        self._fixed.publish(TransformsTemplate([hole[:2]]).fill(0, [hole]))

    def publish(self, frame: Frame) -> None:
        """Publish the frames of bit and marks."""
        transforms = self._transforms.at(frame)
        if self._template is None:
            self._template = TransformsTemplate([one[:2] for one in transforms])
        self._moving.publish(self._template.fill(stamp_ns(frame.time), transforms))

    def destroy(self) -> None:
        """Destroy both publishers."""
        for publisher in (self._moving, self._fixed):
            self._node.destroy_publisher(publisher)
