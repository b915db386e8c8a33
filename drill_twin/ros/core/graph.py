# SPDX-License-Identifier: Apache-2.0
"""Graph of publishers and readers: who is connected with whom, and why not where the topic's name is right.

The incompatible-QoS callback of rclpy names a policy, and neither the other node nor what it offers; another type is
reported by no event (Fast DDS of the wheels). Both are told here, with a remedy, to a node's diagnostics and by
`drill-twin ros doctor`.
"""

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from drill_twin.io.messages.topics import TOPICS

UNKNOWN_NAME = "_NODE_NAME_UNKNOWN_"
"""Name of a node whose publisher has been discovered and whose name has not."""
_WANTED = (  # policy, requested, not sufficient
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
)


def unmet(wanted: QoSProfile, offered: QoSProfile) -> tuple[str, str, str] | None:
    """Policy for which DDS does not connect a reader with a publisher, the wanted and the offered value; else None."""
    for policy, want, lacks in _WANTED:
        if getattr(wanted, policy) == want and getattr(offered, policy) == lacks:
            return policy, want.name.lower(), lacks.name.lower()
    return None


def unlisted(node: Node) -> list[str]:
    """Topics of subs and frames in the namespace of a node, which the contract finds by name and does not list."""
    prefix, listed = node.get_namespace().rstrip("/"), tuple(TOPICS)
    found = {name.removeprefix(prefix): types for name, types in node.get_topic_names_and_types()
             if name.startswith(f"{prefix}/")}  # fmt: skip
    return [name for name in found if name not in listed and name in TOPICS and TOPICS[name].type_name in found[name]]


def full_name(info: TopicEndpointInfo) -> str:
    """Full name of the node of a publisher or a reader."""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


def readers_of(node: Node, topic: str) -> int:
    """Number of readers of a topic, by its full name, that its publishers can be connected to.

    A reader that requests latched messages where none are offered is never connected, so it does not count.
    """
    latched = any(
        offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        for offer in node.get_publishers_info_by_topic(topic)
    )
    return sum(
        latched or reader.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL
        for reader in node.get_subscriptions_info_by_topic(topic)
    )
