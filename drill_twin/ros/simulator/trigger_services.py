# SPDX-License-Identifier: Apache-2.0
"""Services that hold a run in hand: pause, resume, step, reset, and its checkpoint.

All are `std_srvs/Trigger`, so any tool calls them. ROS has no service with a number among its common types; how many
frames a step takes is therefore the parameter `step_frames`, which shows its value and its range.
"""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from rclpy.service import Service
from std_srvs.srv import Trigger

from drill_twin.core.errors import DrillTwinError


def offer(node: Node, actions: dict[str, Callable[[], str]]) -> list[Service]:
    """One service for each action; an action says in a sentence what it did, or raises why it did not."""
    return [node.create_service(Trigger, f"~/{name}", _answering(node, action)) for name, action in actions.items()]


def _answering(
    node: Node, action: Callable[[], str]
) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
    def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        try:
            response.message = action()
            response.success = True
            node.get_logger().info(response.message)
        except DrillTwinError as error:
            response.message = str(error)
            response.success = False
            node.get_logger().warning(response.message)
        return response

    return answer
