# SPDX-License-Identifier: Apache-2.0
"""Refusal of invalid transitions, which rclpy's lifecycle nodes lack."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.service import Service


def answer_any_transition(node: Node, service: Service) -> None:
    """Answer the request of a transition that the present state does not have with a failure.

    rclpy (7.1) raises in the requested node, so that a mistyped `ros2 lifecycle set` would end it.
    """
    callback = service.callback

    def answer(request: Any, response: Any) -> Any:
        try:
            return callback(request, response)
        except RuntimeError as error:  # rclpy's RCLError is one
            wanted = request.transition.label or request.transition.id
            node.get_logger().warning(f"transition {wanted}: {str(error).partition(', at ')[0]}")
            response.success = False
            return response

    service.callback = answer
