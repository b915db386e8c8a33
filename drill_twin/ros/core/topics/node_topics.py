# SPDX-License-Identifier: Apache-2.0
"""Publishers and subscriptions of a node, by topic of the contract; messages are CDR bytes, decoded by their row."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.readers import reader_of
from drill_twin.io.messages.topics import DIAGNOSTICS, RPS_COMMAND, TOPICS, TWIN_SCENE, WOB_COMMAND
from drill_twin.ros.core.topics.qos_check import UNKNOWN_NODE_NAME, full_name, incompatible_publisher
from drill_twin.ros.core.topics.qos_overrides import OVERRIDABLE, readable_overrides
from drill_twin.ros.core.topics.raw_subscriptions import ManualCallbackGroup, RawSubscriptions, Received
from drill_twin.ros.core.topics.rclpy_topics import message_class, quality, relative
from drill_twin.ros.core.topics.scene_gate import SceneGate

_SEVERAL_PUBLISHERS = (DIAGNOSTICS, WOB_COMMAND, RPS_COMMAND)  # their sequence numbers cannot be told apart


NOT_NAMED_YET = f"_NODE_NAMESPACE_UNKNOWN_/{UNKNOWN_NODE_NAME}"
"""Full name of a node whose publisher has been discovered and whose name has not."""


class NodeTopics:
    """Topics of the contract that a node publishes and subscribes to."""

    def __init__(self, node: Node, subscriptions: RawSubscriptions, unreadable: Callable[[str], object]) -> None:
        """Connect the topics to their node.

        Args:
            node: The node.
            subscriptions: Takes its messages.
            unreadable: Called with the topic of a message that could not be decoded or used.
        """
        self.publishers: dict[str, Publisher] = {}
        """Publishers by topic of the contract."""
        self.prefix = ""
        """Namespace of the topics that are advertised from now on, as "/rig2"; empty: the node's."""
        self._node = node
        self._subscriptions = subscriptions
        self._unreadable = unreadable
        self._scenes: list[SceneGate] = []
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

    def subscribe(
        self,
        topic: str,
        received: Callable[[Any], object],
        *,
        depth: int = 0,
        latched: bool | None = None,
        malformed: Callable[[str], object] | None = None,
    ) -> Subscription:
        """Create the subscription to a topic.

        Args:
            topic: The topic.
            received: Called with each message, decoded as the topic's row says; may raise MessageError as well.
            depth: Messages that wait; 0: those of the contract.
            latched: Whether earlier messages are asked for; None: as the contract says.
            malformed: Called with the reason why a message could not be used, in place of counting it.
        """
        read = reader_of(topic)

        def decoded(raw: bytes, _: Mapping[str, Any]) -> None:
            try:
                received(read(bytes(raw)))
            except MessageError as error:
                self._unreadable(topic) if malformed is None else malformed(str(error))

        return self.subscribe_raw(topic, decoded, depth=depth, latched=latched)

    def subscribe_scenes(self, received: Callable[[bytes], None]) -> Subscription:
        """Create the subscription to `/twin/scene`; the callback receives the bytes when the gate lets them pass."""
        gate = SceneGate(received)
        self._scenes.append(gate)
        return self.subscribe_raw(TWIN_SCENE, lambda raw, _: gate.take(bytes(raw)), depth=1)

    def pass_on_scenes(self) -> None:
        """Pass on the scenes that wait, if their turn has come."""
        for gate in self._scenes:
            gate.work()

    @property
    def scenes_put_off(self) -> int:
        """Number of scenes that were replaced by a newer one before their turn."""
        return sum(gate.put_off for gate in self._scenes)

    def subscribe_raw(
        self, topic: str, received: Received, *, depth: int = 0, latched: bool | None = None
    ) -> Subscription:
        """Create the subscription to a topic; the callback receives bytes, and the times of sending and receiving."""
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
        return sorted(map(full_name, found))

    def incompatible_publisher(self) -> str:
        """First publisher that no subscription of this node can be connected to; empty when there is none."""
        return incompatible_publisher(self._node, self._inputs)


def _not_called(raw: bytes) -> None:
    """Callback that rclpy demands; messages are taken by `RawSubscriptions` instead."""
    raise AssertionError(f"an executor took {len(raw)} bytes of a subscription that `RawSubscriptions` reads")
