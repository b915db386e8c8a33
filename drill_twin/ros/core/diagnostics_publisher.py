# SPDX-License-Identifier: Apache-2.0
"""Diagnostics of a node: published on `/diagnostics`, and on the console when they report a problem.

A node that waits for inputs listens there too: whoever moves the time of a twin says in `state` that it stands still.
"""

import re
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import replace

from rclpy.node import Node

from drill_twin.core import __version__
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics
from drill_twin.io.messages.good_samples import GONE, GoodSamples
from drill_twin.io.messages.stamps import within_range
from drill_twin.io.messages.topics import DIAGNOSTICS, TOPICS
from drill_twin.ros.core.spinning import SpinningNode
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
        active = status.values.get("state") != "inactive"
        if active and status.level == Level.OK and (problem := self._topics.incompatible_publisher()):
            status = replace(status, level=Level.WARN, text=problem)
        if clocks := self._topics.several_clocks():
            status = replace(status, level=Level.ERROR, text=clocks)
        if status.level != Level.OK:
            self._log(status)
        name, twin = self._node.get_fully_qualified_name().lstrip("/"), hardware_id(self._node)
        named = replace(status, name=name, hardware_id=twin, values={**status.values, **queues, "version": __version__})
        stamp = within_range(self._node.get_clock().now().nanoseconds)  # a foreign /clock may hold more
        self._publisher.publish(encode_diagnostics(stamp, [named]))

    def _log(self, status: Status) -> None:
        """Log a problem unless it was seen in the last minute, perhaps with other numbers."""
        now, kind = time.monotonic(), re.sub(r"[-+\d.]+", "", status.text)
        if now - self._seen.get(kind, -_REPEAT_AFTER) >= _REPEAT_AFTER:
            if status.level == Level.ERROR:  # rclpy refuses two severities from one line
                self._node.get_logger().error(status.text)
            else:
                self._node.get_logger().warning(status.text)
        self._seen[kind] = now


def of_inactive(status: Status) -> Status:
    """Status of an inactive node, from its status as an active one: it takes no message, and lacks none."""
    told = replace(status, values={"state": "inactive", **status.values})
    return told if status.level in {Level.OK, Level.ERROR} else replace(told, level=Level.OK, text="inactive")


def hardware_id(node: Node) -> str:
    """Name of the twin of a node in its diagnostics."""
    return f"drill_twin{node.get_namespace().rstrip('/')}"


_HAS_STATE = b"\6\0\0\0state\0"
"""Key in the bytes of a DiagnosticArray: other ones need not be decoded, which takes 0.4 ms."""
STANDS_STILL = ("paused", "inactive", "waiting")
"""Values of `state` of a node that does not move the time of its twin, on purpose."""


class NodeInputs(GoodSamples):
    """Good and bad samples of the topics of a node; while its twin says that time stands still, silence is no fault."""

    def __init__(self, node: SpinningNode, on_change: Collection[str], timed_by: str) -> None:
        """Start without samples of a node; its `topics` that come on change only, and that moves the time of all."""
        super().__init__(on_change=on_change)
        self._node, self._timed_by = node, timed_by

    def expect(self, *names: str) -> None:
        """Begin to wait for a message on one of some topics, and to listen whether time stands still."""
        if not self._expected:
            self._node.topics.subscribe_raw(
                DIAGNOSTICS, lambda raw, _: self._listen(raw) if _HAS_STATE in raw else None
            )
        super().expect(*names)

    def advice(self, names: tuple[str, ...]) -> str:
        """Names of the publishers of the first topic, and what to look at, in a sentence."""
        found = ", ".join(self._node.topics.publisher_nodes(names[0]))
        if found and len(names) < 3:
            why = self._node.topics.incompatible_publisher()
            return why or f"{found} is there, and nothing that can be used has come"
        who = "twin" if len(names) > 2 else TOPICS[names[0]].publisher
        return f"is a {who} running in this namespace and domain?"

    def _listen(self, raw: bytes) -> None:
        with suppress(MessageError):  # of a program that is not ours: it says nothing of the twin
            for status in decode_diagnostics(raw)[1]:
                if status.values.get("state") in STANDS_STILL and self._moves_time(status):
                    self.rest(GONE)

    def _moves_time(self, status: Status) -> bool:
        """Return True for the node that moves the time of the inputs; for a simulator that compiles by its twin."""
        if movers := self._node.topics.publisher_nodes(self._timed_by):
            return f"/{status.name}" in movers
        return "compiling" in status.values and status.hardware_id == hardware_id(self._node)
