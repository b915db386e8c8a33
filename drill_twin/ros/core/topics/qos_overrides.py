# SPDX-License-Identifier: Apache-2.0
"""Quality of service from a parameter file, as every ROS 2 node takes it: `qos_overrides./topic.publisher.depth`."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from contextlib import contextmanager

from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.qos import QoSPolicyKind
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions

from drill_twin.ros.core.parameters import ParameterError, given_parameters

_PREFIX = "qos_overrides."
OVERRIDABLE = QoSOverridingOptions(
    (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
)
"""Policies that can be set for each topic: history, depth, reliability, durability."""


@contextmanager
def readable_overrides(topic: str) -> Iterator[None]:
    """Turn rclpy's errors about an override into one line.

    Raises:
        ParameterError: The value is not one of that policy.
    """
    try:
        yield
    except (InvalidQosOverridesError, InvalidParameterTypeException, RuntimeError, ValueError) as error:
        raise ParameterError(
            f"qos_overrides of {topic}: expected history keep_last or keep_all, a depth, reliability reliable or "
            f"best_effort, durability volatile or transient_local; found {error}"
        ) from error


def refuse_unused(node: Node) -> None:
    """Refuse overrides of topics that this node does not have: rclpy ignores misspelled ones silently.

    Raises:
        ParameterError: An override names no topic of this node.
    """
    known = [f"{_PREFIX}{name}" for name in node.get_parameters_by_prefix(_PREFIX.removesuffix("."))]
    for name in given_parameters(node):
        if name.startswith(_PREFIX) and name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else "ros2 param list shows them"
            raise ParameterError(f"parameter {name}: this node has none of that name; {hint}")
