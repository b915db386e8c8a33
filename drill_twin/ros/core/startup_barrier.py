# SPDX-License-Identifier: Apache-2.0
"""What a node that is ready says: how many readers each of its topics is connected to.

Two nodes that a third one waits for may both be well and not have met each other yet. Who asks has seen all their
readers, because a node's `~/ready` service is the last thing it creates; so it can compare.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy


def connected_readers(publishers: Iterable[Publisher]) -> str:
    """The message of a node that is ready: readers by topic, as JSON."""
    return json.dumps({publisher.topic_name: publisher.get_subscription_count() for publisher in publishers})


def missing_readers(node: Node, said: str) -> str:
    """Which readers a ready node is not connected to yet, of those that the asker sees; empty when it is to all.

    Args:
        node: The asker.
        said: The message of the ready node; one that is not ours may say anything, and is believed.
    """
    try:
        counts = json.loads(said)
    except json.JSONDecodeError:
        return ""
    if not isinstance(counts, dict):
        return ""
    late = [topic for topic, count in counts.items() if isinstance(count, int) and count < readers_of(node, topic)]
    return f"not yet connected to the readers of {', '.join(late)}" if late else ""


def readers_of(node: Node, topic: str) -> int:
    """Readers of a topic, by its full name, that its publishers can be connected to.

    A reader that asks for latched messages where none are offered is never connected; it must hold up nobody.
    """
    latched = any(
        offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        for offer in node.get_publishers_info_by_topic(topic)
    )
    readers = node.get_subscriptions_info_by_topic(topic)
    return sum(latched or reader.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL for reader in readers)
