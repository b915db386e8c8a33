# SPDX-License-Identifier: Apache-2.0
"""Diagnostics of a node: published on `/diagnostics`, and on the console when they report a problem."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import replace

from rclpy.node import Node

from drill_twin.core import __version__
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS
from drill_twin.ros.core.topics import NodeTopics

_REPEAT_AFTER = 60.0  # s without a problem until it is logged again


class DiagnosticsPublisher:
    """Publishes the status of a node, completed by what the node's topics report."""

    def __init__(self, node: Node, topics: NodeTopics) -> None:
        self._node = node
        self._topics = topics
        self._publisher = topics.advertise(DIAGNOSTICS)
        self._seen: dict[str, float] = {}

    def publish(self, health: Callable[[], Status], *, ended: bool = False) -> None:
        """Publish the status of the node; a publisher it cannot be connected to is a warning, a second clock an error.

        Args:
            health: Called for the status, once the dropped messages have been counted.
            ended: Whether the node ends in order, and these are its last.
        """
        queues, status = self._topics.queue_report(), health()
        queues |= {"ended": "true"} if ended else {}
        if status.level == Level.OK and (problem := self._topics.incompatible_publisher()):
            status = replace(status, level=Level.WARN, text=problem)
        if clocks := self._topics.several_clocks():
            status = replace(status, level=Level.ERROR, text=clocks)
        if status.level != Level.OK:
            self._log(status)
        name = self._node.get_fully_qualified_name().lstrip("/")
        twin = f"drill_twin{self._node.get_namespace().rstrip('/')}"
        named = replace(status, name=name, hardware_id=twin, values={**status.values, **queues, "version": __version__})
        self._publisher.publish(encode_diagnostics(self._node.get_clock().now().nanoseconds, [named]))

    def _log(self, status: Status) -> None:
        """Log a problem unless it was seen in the last minute, perhaps with other numbers."""
        now, kind = time.monotonic(), re.sub(r"[-+\d.]+", "", status.text)
        if now - self._seen.get(kind, -_REPEAT_AFTER) >= _REPEAT_AFTER:
            if status.level == Level.ERROR:  # rclpy refuses two severities from one line
                self._node.get_logger().error(status.text)
            else:
                self._node.get_logger().warning(status.text)
        self._seen[kind] = now
