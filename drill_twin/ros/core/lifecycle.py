# SPDX-License-Identifier: Apache-2.0
"""What rclpy's lifecycle nodes lack."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.service import Service


def answer_any_transition(node: Node, service: Service) -> None:
    """Answer a transition that the present state does not have with "no".

    rclpy (7.1) raises in the node that was asked, so that a mistyped `ros2 lifecycle set` would end it.
    """
    answer = service.callback

    def answered(request: Any, response: Any) -> Any:
        try:
            return answer(request, response)
        except RuntimeError as error:  # rclpy's RCLError is one
            wanted = request.transition.label or request.transition.id
            node.get_logger().warning(f"transition {wanted}: {str(error).partition(', at ')[0]}")
            response.success = False
            return response

    service.callback = answered
