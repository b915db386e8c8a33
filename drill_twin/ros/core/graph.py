# SPDX-License-Identifier: Apache-2.0
"""Graph of publishers and readers: who is connected with whom, and why not where the topic's name is right.

The incompatible-QoS callback of rclpy names a policy, and neither the other node nor what it offers; another type is
reported by no event (Fast DDS of the wheels). Both are told here, with a remedy, to a node's diagnostics and by
`drill-twin ros doctor`.
"""

from __future__ import annotations

from collections.abc import Iterable

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

_UNKNOWN_NODE_NAME = "_NODE_NAME_UNKNOWN_"
NOT_NAMED_YET = f"_NODE_NAMESPACE_UNKNOWN_/{_UNKNOWN_NODE_NAME}"
"""Full name of a node whose publisher has been discovered and whose name has not."""
_WANTED = (  # policy, requested, not sufficient, the two in words
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT, "reliable", "best_effort"),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE, "transient_local", "volatile"),
)


def unmet(wanted: QoSProfile, offered: QoSProfile) -> tuple[str, str, str] | None:
    """Policy for which DDS does not connect a reader with a publisher, the wanted and the offered value; else None."""
    for policy, want, lacks, expected, found in _WANTED:
        if getattr(wanted, policy) == want and getattr(offered, policy) == lacks:
            return policy, expected, found
    return None


def full_name(info: TopicEndpointInfo) -> str:
    """Full name of the node of a publisher or a reader."""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


def incompatible_publisher(node: Node, inputs: Iterable[tuple[Subscription, str]]) -> str:
    """First publisher that a node is not connected to, with the reason and the remedy; empty when there is none.

    Args:
        node: The subscribing node.
        inputs: Its subscriptions and their types.
    """
    for subscription, kind in inputs:
        topic = subscription.topic_name
        for info in node.get_publishers_info_by_topic(topic):
            if info.node_name == _UNKNOWN_NODE_NAME:
                continue
            name = full_name(info)
            if info.topic_type != kind:
                return f"{topic}: expected {kind}, found {info.topic_type} of {name}, not received; publish {kind}"
            if mismatch := unmet(subscription.qos_profile, info.qos_profile):
                policy, expected, found = mismatch
                return (
                    f"{topic}: expected a {expected} publisher, found {name} as {found}, not received; publish "
                    f"{expected}, or start this node with qos_overrides.{topic}.subscription.{policy}:={found}"
                )
    return ""


def readers_of(node: Node, topic: str) -> int:
    """Number of readers of a topic, by its full name, that its publishers can be connected to.

    A reader that requests latched messages where none are offered is never connected, so it does not count.
    """
    latched = any(
        offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        for offer in node.get_publishers_info_by_topic(topic)
    )
    readers = node.get_subscriptions_info_by_topic(topic)
    return sum(latched or reader.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL for reader in readers)
