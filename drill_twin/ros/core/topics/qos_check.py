# SPDX-License-Identifier: Apache-2.0
"""Publishers that a reader is not connected to although the topic's name is right: another type, or weaker QoS.

DDS reports a mismatch of the type not at all, and one of the quality of service with one line of its own.
"""

from __future__ import annotations

from collections.abc import Mapping

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

UNKNOWN_NODE_NAME = "_NODE_NAME_UNKNOWN_"
"""Name of a node whose publisher has been discovered and whose name has not."""
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


def incompatible_publisher(node: Node, inputs: Mapping[str, tuple[str, QoSProfile]]) -> str:
    """First publisher that a node is not connected to, with the reason and the remedy; empty when there is none.

    Args:
        node: The subscribing node.
        inputs: Type and quality of service of its subscriptions, by resolved topic.
    """
    for topic, (kind, wanted) in inputs.items():
        for info in node.get_publishers_info_by_topic(topic):
            if info.node_name == UNKNOWN_NODE_NAME:
                continue
            name = full_name(info)
            if info.topic_type != kind:
                return f"{topic}: expected {kind}, found {info.topic_type} of {name}, not received; publish {kind}"
            if mismatch := unmet(wanted, info.qos_profile):
                policy, expected, found = mismatch
                return (
                    f"{topic}: expected a {expected} publisher, found {name} as {found}, not received; publish "
                    f"{expected}, or start this node with qos_overrides.{topic}.subscription.{policy}:={found}"
                )
    return ""
