# SPDX-License-Identifier: Apache-2.0
"""Publishers and subscriptions of a node, by topic of the contract; messages are CDR bytes, never Python objects."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from drill_twin.io.messages.topics import DIAGNOSTICS, RPS_COMMAND, TOPICS, WOB_COMMAND
from drill_twin.ros.core.topics.qos_check import UNKNOWN_NODE_NAME, incompatible_publisher
from drill_twin.ros.core.topics.qos_overrides import OVERRIDABLE, readable_overrides
from drill_twin.ros.core.topics.raw_subscriptions import ManualCallbackGroup, RawSubscriptions, Received
from drill_twin.ros.core.topics.rclpy_topics import message_class, quality, relative

_SEVERAL_PUBLISHERS = (DIAGNOSTICS, WOB_COMMAND, RPS_COMMAND)  # their sequence numbers cannot be told apart


NOT_NAMED_YET = f"_NODE_NAMESPACE_UNKNOWN_/{UNKNOWN_NODE_NAME}"
"""Full name of a node whose publisher has been discovered and whose name has not."""


class NodeTopics:
    """Topics of the contract that a node publishes and subscribes to."""

    def __init__(self, node: Node, subscriptions: RawSubscriptions) -> None:
        self.publishers: dict[str, Publisher] = {}
        """Publishers by topic of the contract."""
        self.prefix = ""
        """Namespace of the topics that are advertised from now on, as "/rig2"; empty: the node's."""
        self._node = node
        self._subscriptions = subscriptions
        self._group = ManualCallbackGroup()
        self._inputs: dict[str, tuple[str, QoSProfile]] = {}

    def advertise(self, topic: str, *, latched: bool | None = None) -> Publisher:
        """Create the publisher of a topic; it is given bytes."""
        row = TOPICS[topic]
        offered = quality(row, depth=row.publisher_depth, latched=latched)
        with readable_overrides(topic):
            publisher = self._node.create_publisher(
                message_class(row), relative(topic, self.prefix), offered, qos_overriding_options=OVERRIDABLE
            )
        self.publishers[topic] = publisher
        return publisher

    def publish(self, topic: str, raw: bytes) -> None:
        """Publish a message on an advertised topic."""
        self.publishers[topic].publish(raw)

    def withdraw(self, topic: str) -> None:
        """Destroy the publisher of a topic."""
        self._node.destroy_publisher(self.publishers.pop(topic))

    def subscribe(self, topic: str, received: Received, *, depth: int = 0, latched: bool | None = None) -> Subscription:
        """Create the subscription to a topic; the callback receives bytes."""
        row = TOPICS[topic]
        with readable_overrides(topic):
            subscription = self._node.create_subscription(
                message_class(row),
                relative(topic),
                _not_called,
                quality(row, depth=depth, latched=latched),
                callback_group=self._group,
                qos_overriding_options=OVERRIDABLE,
                raw=True,
            )
        self._inputs[subscription.topic_name] = (row.type_name, subscription.qos_profile)
        counted = topic not in _SEVERAL_PUBLISHERS and depth != 1 and not row.latched
        self._subscriptions.add(subscription, received, topic if counted else "")
        return subscription

    def destroy_all_but(self, kept: str) -> None:
        """Destroy all subscriptions, and all publishers but that of one topic."""
        self._subscriptions.close()
        self._inputs.clear()
        for topic in set(self.publishers) - {kept}:
            self.withdraw(topic)

    def flush(self, seconds: float = 5.0) -> None:
        """Wait until every reader has acknowledged all that was published, at most this long [s]."""
        deadline = time.monotonic() + seconds
        for publisher in self.publishers.values():
            left = max(deadline - time.monotonic(), 0.0)
            publisher.wait_for_all_acked(Duration(seconds=left))

    @property
    def dropped(self) -> Mapping[str, int]:
        """Messages that were dropped unread from a full queue, by topic, as of the last `queue_report`."""
        return self._subscriptions.drops.dropped

    def queue_report(self) -> dict[str, str]:
        """Fill and drops of the queues since the last report, for the diagnostics."""
        return self._subscriptions.queue_report()

    def publisher_nodes(self, topic: str) -> list[str]:
        """Full names of the nodes that publish a topic, one entry a publisher."""
        found = self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(relative(topic)))
        return sorted(f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in found)

    def incompatible_publisher(self) -> str:
        """First publisher that no subscription of this node can be connected to; empty when there is none."""
        return incompatible_publisher(self._node, self._inputs)


def _not_called(raw: bytes) -> None:
    """Callback that rclpy demands; messages are taken by `RawSubscriptions` instead."""
    raise AssertionError(f"an executor took {len(raw)} bytes of a subscription that `RawSubscriptions` reads")
