# SPDX-License-Identifier: Apache-2.0
"""Service requests that cannot be answered: an error in the answer or the log, and the node goes on.

rclpy (7.1) raises in the requested node, and so ends it, where a request cannot be decoded (text that is no UTF-8) or
where its own parameter services meet an unknown type of parameter, or another type for a parameter of rclpy itself
(`use_sim_time`).
"""

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.service import Service

from drill_twin.core.errors import shortened

Answer = Callable[[Any, Any], Any]


class Later:
    """Answer of a service that is sent after its callback has returned this."""

    send: Callable[[Any], object]
    """Sends the response; set once the callback has returned."""


def sending_later(service: Service) -> None:
    """Let the callback of a service return a `Later`: rclpy (7.1) awaits no coroutine of a service."""
    at_once = service.send_response

    def send(response: Any, header: Any) -> None:
        if isinstance(response, Later):
            response.send = lambda found: at_once(found, header)
        else:
            at_once(response, header)

    setattr(service, "send_response", send)  # noqa: B010 - which rclpy calls with what the callback returns


def guarded(node: Node, kind: Any, callback: Answer) -> Answer:
    """Callback of a service that answers a request on which `callback` raises with a refusal.

    Args:
        node: The node that is asked.
        kind: Type of the service.
        callback: Answers a request.
    """

    def answer(request: Any, response: Any) -> Any:
        try:
            return callback(request, response)
        except Exception as error:  # noqa: BLE001 - whatever a stranger sends must not end the node
            reason = log_refusal(node, kind.__name__, error)
        refused = SetParametersResult(successful=False, reason=reason)
        response = kind.Response()
        if kind is SetParameters:
            response.results = [refused] * len(request.parameters)
        elif kind is SetParametersAtomically:
            response.result = refused
        elif hasattr(response, "success"):
            response.success = False
        return response

    return answer


def log_refusal(node: Node, what: str, error: Exception) -> str:
    """Log that a request was refused; returns the reason."""
    reason = shortened(f"{type(error).__name__}: {error}")
    node.get_logger().error(f"a request ({what}) could not be answered: {reason}", throttle_duration_sec=1.0)
    return reason
