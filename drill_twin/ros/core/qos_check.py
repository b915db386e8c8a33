# SPDX-License-Identifier: Apache-2.0
"""Publishers that a node cannot hear although the name of the topic is right: another type, or too little promised.

DDS connects neither and says nothing to the node (of the type) or one line of its own (of the quality).
"""

from __future__ import annotations

from collections.abc import Mapping

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

_NOT_NAMED_YET = "_NODE_NAME_UNKNOWN_"
_WANTED = (  # policy, what we want, what does not do, in words
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT, "reliable", "best_effort"),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE, "transient_local", "volatile"),
)


def unheard(node: Node, inputs: Mapping[str, tuple[str, QoSProfile]]) -> str:
    """The first publisher that a node does not hear, with the reason and what to do; empty when there is none.

    Args:
        node: Who listens.
        inputs: Type and quality of service of its subscriptions, by resolved topic.
    """
    for topic, (kind, wanted) in inputs.items():
        for info in node.get_publishers_info_by_topic(topic):
            if info.node_name == _NOT_NAMED_YET:
                continue
            who = f"{info.node_namespace.rstrip('/')}/{info.node_name}"
            if info.topic_type != kind:
                return f"{topic}: expected {kind}, found {info.topic_type} of {who}, which is not heard; publish {kind}"
            for policy, want, lacks, expected, found in _WANTED:
                if getattr(wanted, policy) == want and getattr(info.qos_profile, policy) == lacks:
                    override = f"qos_overrides.{topic}.subscription.{policy}:={found}"
                    return (
                        f"{topic}: expected a {expected} publisher, found {who} as {found}, which is not heard; "
                        f"publish {expected}, or start this node with {override}"
                    )
    return ""
