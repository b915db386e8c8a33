# SPDX-License-Identifier: Apache-2.0
"""Topics of the contract in rclpy's terms: message classes, relative names, quality of service."""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from drill_twin.io.messages.topics import DIAGNOSTICS, Topic


def relative(topic: str, namespace: str = "") -> str:
    """Topic name relative to the node's namespace, so that two twins can share a domain; `/diagnostics` is global.

    A namespace given as "/rig2" stands in place of the node's.
    """
    if topic == DIAGNOSTICS:
        return topic
    return namespace + topic if namespace else topic.lstrip("/")


def message_class(topic: Topic) -> Any:
    """Message class of a topic in rclpy, which has no common base class."""
    package, _, name = topic.type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def quality(topic: Topic, *, depth: int = 0, latched: bool | None = None) -> QoSProfile:
    """Quality of service of a topic; depth 0 and latched None stand for those of the contract."""
    keep = topic.latched if latched is None else latched
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        history=HistoryPolicy.KEEP_LAST,
        depth=depth or topic.depth,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if keep else DurabilityPolicy.VOLATILE,
    )
