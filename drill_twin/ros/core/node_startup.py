# SPDX-License-Identifier: Apache-2.0
"""Waiting until other nodes are there and miss nothing that is published from now on."""

from __future__ import annotations

import time
from typing import Any

from std_srvs.srv import Trigger

from drill_twin.errors import RunError
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.startup_barrier import missing_readers
from drill_twin.ros.entry_points import StopRequest


def wait_for_nodes(node: TwinNode, names: str, seconds: float, stop: StopRequest | None = None) -> None:
    """Wait until each of these nodes says that it is ready.

    Args:
        node: Who waits.
        names: Node names in this namespace, separated by spaces.
        seconds: Longest wait [s].
        stop: Ends the wait early.

    Raises:
        RunError: One did not become ready in time.
    """
    clients = {name: node.create_client(Trigger, f"{name}/ready") for name in names.split()}
    deadline = time.monotonic() + seconds
    # Twice: only who has seen all of them can tell whether each is connected to all the others.
    for ask in (_ask_present, _ask_ready):
        for name, client in clients.items():
            said = ""
            while not stop and (reason := ask(node, client)):
                if reason != said:
                    node.get_logger().info(f"waiting for {name}: {reason}")
                    said = reason
                if time.monotonic() > deadline:
                    raise RunError(
                        f"waited {seconds:g} s for the node {name}: {reason}; start it in the same ROS_DOMAIN_ID "
                        "and namespace, or take its name out of the parameter wait_for"
                    )
            if said:
                node.get_logger().info(f"{name} is {'there' if ask == _ask_present else 'ready'}")
    for client in clients.values():
        node.destroy_client(client)
    while not stop and node.readers_not_matched() and time.monotonic() < deadline:
        node.listen_for(0.05)


def _ask_present(node: TwinNode, client: Any) -> str:
    if client.service_is_ready():
        return ""
    node.listen_for(0.05)
    return "it is not there yet"


def _ask_ready(node: TwinNode, client: Any) -> str:
    answer = client.call_async(Trigger.Request())
    deadline = time.monotonic() + 1.0
    while not answer.done():
        if time.monotonic() > deadline:
            client.remove_pending_request(answer)
            return "it did not answer"
        node.listen_for(0.05)
    reason = answer.result().message
    if answer.result().success:
        reason = missing_readers(node, reason)
    if reason:
        node.listen_for(0.05)
    return reason
