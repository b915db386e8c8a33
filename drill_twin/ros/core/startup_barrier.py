# SPDX-License-Identifier: Apache-2.0
"""Start-up barrier: a service that reports the readiness of a node, and the wait for those of other nodes.

Two nodes that a third one waits for may both be running and not be connected to each other yet. A ready node therefore
answers with the number of readers of each of its topics. The waiting node has discovered all readers of every node
whose `~/ready` service it sees, because that service is created last; it compares the two numbers.

A node that compiles offers the service meanwhile too, before its topics. Its answer then begins with `COMPILING`: the
waiting node takes it for absent, and waits as long as it compiles.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable

from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from rclpy.service import Service
from std_srvs.srv import Trigger

from drill_twin.errors import RunError
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics.node_topics import NodeTopics

COMPILING = "compiling"
"""First word of the reason of a node that is not ready because it compiles."""
_POLL = 0.05  # s
_ANSWER_TIME = 1.0  # s
_NO_ANSWER = "it did not answer"


class StartupBarrier:
    """Readiness of a node, and its wait for the readiness of others."""

    def __init__(
        self, node: Node, topics: NodeTopics, spin_once: Callable[[float], None], not_ready: Callable[[], str]
    ) -> None:
        """Connect the barrier to its node.

        Args:
            node: The node.
            topics: Its topics.
            spin_once: Called with a time [s] to process messages and service calls meanwhile.
            not_ready: Called for the reason why the node is not ready, empty when it is.
        """
        self._node = node
        self._topics = topics
        self._spin_once = spin_once
        self._not_ready = not_ready
        self._service: Service | None = None

    def create_service(self) -> None:
        """Create the service `~/ready`, after all topics of this node."""
        if self._service is None:
            self._service = self._node.create_service(Trigger, "~/ready", self._answer)

    def destroy_service(self) -> None:
        """Destroy the service `~/ready`."""
        if self._service is not None:
            self._node.destroy_service(self._service)
        self._service = None

    def _answer(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        reason = self._not_ready() or self.unmatched_readers()
        counts = {
            publisher.topic_name: publisher.get_subscription_count() for publisher in self._topics.publishers.values()
        }
        response.success = not reason
        response.message = reason or json.dumps(counts)
        return response

    def unmatched_readers(self) -> str:
        """Topics of this node with a reader that is not connected yet, in a sentence; empty when all are."""
        late = [
            topic
            for topic, publisher in self._topics.publishers.items()
            if publisher.get_subscription_count() < readers_of(self._node, publisher.topic_name)
        ]
        return f"not yet connected to the readers of {', '.join(late)}" if late else ""

    def wait_for(self, names: str, seconds: float, stop: StopRequest) -> None:
        """Wait until other nodes are ready and the readers of this node are connected.

        Args:
            names: Node names in this namespace, separated by spaces.
            seconds: Longest wait [s]; it begins again while a node answers that it compiles.
            stop: Ends the wait early.

        Raises:
            RunError: A node was not ready in time.
        """
        clients = {name: self._node.create_client(Trigger, f"{name}/ready") for name in names.split()}
        deadline = time.monotonic() + seconds
        # All must be present before the first is asked: its answer is compared with the readers of all the others.
        for missing, reached in ((self._absence, "there"), (self._unreadiness, "ready")):
            for client in clients.values():
                logged = ""
                while not stop and (reason := missing(client)):
                    if reason.startswith(COMPILING):
                        deadline = time.monotonic() + seconds
                        reason = COMPILING  # its progress is in the log of that node
                    if reason != logged:
                        self._node.get_logger().info(f"waiting for {_node_of(client)}: {reason}")
                        logged = reason
                    if time.monotonic() > deadline:
                        raise RunError(
                            f"waited {seconds:g} s for the node {_node_of(client)}: {reason}; start it in the same "
                            "ROS_DOMAIN_ID and namespace, or take its name out of the parameter wait_for"
                        )
                    self._spin_once(_POLL)
                if logged:
                    self._node.get_logger().info(f"{_node_of(client)} is {reached}")
        for client in clients.values():
            self._node.destroy_client(client)
        while not stop and self.unmatched_readers() and time.monotonic() < deadline:
            self._spin_once(_POLL)

    def _absence(self, client: Client) -> str:
        if not client.service_is_ready():
            return "it is not there yet"
        answer = self._ask(client)
        if answer is None:
            return _NO_ANSWER
        return answer.message if answer.message.startswith(COMPILING) else ""

    def _unreadiness(self, client: Client) -> str:
        answer = self._ask(client)
        if answer is None:
            return _NO_ANSWER
        message: str = answer.message
        return missing_readers(self._node, message) if answer.success else message

    def _ask(self, client: Client) -> Trigger.Response | None:
        """Answer of `~/ready`; None without one in time."""
        answer = client.call_async(Trigger.Request())
        deadline = time.monotonic() + _ANSWER_TIME
        while not answer.done():
            if time.monotonic() > deadline:
                client.remove_pending_request(answer)
                return None
            self._spin_once(_POLL)
        return answer.result()


def _node_of(client: Client) -> str:
    """Full name of the node that a client of `~/ready` asks."""
    return str(client.service_name).removesuffix("/ready")


def missing_readers(node: Node, answer: str) -> str:
    """Topics of a ready node that readers known to this node are not connected to; empty when there are none.

    Args:
        node: The node that asked.
        answer: Message of the ready node; one that is not from this package may hold any text, and counts as ready.
    """
    try:
        counts = json.loads(answer)
    except json.JSONDecodeError:
        return ""
    if not isinstance(counts, dict):
        return ""
    late = [topic for topic, count in counts.items() if isinstance(count, int) and count < readers_of(node, topic)]
    return f"not yet connected to the readers of {', '.join(late)}" if late else ""


def readers_of(node: Node, topic: str) -> int:
    """Number of readers of a topic, by its full name, that its publishers can be connected to.

    A reader that requests latched messages where none are offered is never connected, so it does not count.
    """
    latched = any(
        offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        for offer in node.get_publishers_info_by_topic(topic)
    )
    readers = node.get_subscriptions_info_by_topic(topic)
    return sum(latched or reader.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL for reader in readers)
