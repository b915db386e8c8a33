# SPDX-License-Identifier: Apache-2.0
"""Start-up barrier: a service that reports the readiness of a node, and the wait for those of other nodes.

Two nodes that a third one waits for may both be running and not be connected to each other yet. A ready node therefore
answers with the number of readers of each of its topics. The waiting node has discovered all readers of every node
whose `~/ready` service it sees, because that service is created last; it compares the two numbers.

The answer of a service is lost as long as DDS has not connected the server to the client, which sees the server
already: mostly for a second, rarely for long, where an earlier process was killed. An unanswered client is made anew
after some seconds, and where the run is under way the wait ends without an answer.

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

from drill_twin.core.errors import RunError
from drill_twin.core.files.json_reader import JsonError, read_json
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics.node_topics import NodeTopics

COMPILING = "compiling"
"""First word of the reason of a node that is not ready because it compiles."""
_POLL = 0.05  # s
_ANSWER_TIME = 1.0  # s
_NO_ANSWER = "it did not answer"
_RENEW_AFTER = 5  # requests without an answer
_GO_ON_AFTER = 2  # requests without an answer, where the run is under way


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
        self._clients: dict[str, Client] = {}
        self._deadline = 0.0

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

    def wait_for(
        self, names: str, seconds: float, stop: StopRequest, under_way: Callable[[], bool] = lambda: False
    ) -> None:
        """Wait until other nodes are ready and the readers of this node are connected.

        Args:
            names: Node names in this namespace, or full ones, separated by spaces.
            seconds: Longest wait [s]; it begins again while a node answers that it compiles.
            stop: Ends the wait early.
            under_way: Whether this node is connected to a run that has begun: it then does not wait for a node that is
                there and does not answer.

        Raises:
            RunError: A node was not ready in time.
        """
        self._clients = {name: self._client(name) for name in names.split()}
        self._deadline = time.monotonic() + seconds
        # All must be present before the first is asked: its answer is compared with the readers of all the others.
        for missing, reached in ((self._absence, "there"), (self._unreadiness, "ready")):
            for name in self._clients:
                if logged := self._wait_while(missing, name, seconds, stop, under_way):
                    self._node.get_logger().info(f"{logged} is {reached}")
        for client in self._clients.values():
            self._node.destroy_client(client)
        while not stop and self.unmatched_readers() and time.monotonic() < self._deadline:
            self._spin_once(_POLL)

    def _wait_while(
        self,
        missing: Callable[[Client], str],
        name: str,
        seconds: float,
        stop: StopRequest,
        under_way: Callable[[], bool],
    ) -> str:
        """Wait as long as something is missing; returns the full name of the node if the log says so and it came."""
        logged, unanswered = "", 0
        while not stop and (reason := missing(self._clients[name])):
            node = _node_of(self._clients[name])
            unanswered = unanswered + 1 if reason == _NO_ANSWER else 0
            if unanswered >= _GO_ON_AFTER and under_way():
                self._node.get_logger().warning(f"{node} did not answer; its run is under way, so this node joins it")
                return ""
            if unanswered and unanswered % _RENEW_AFTER == 0:
                self._node.destroy_client(self._clients[name])
                self._clients[name] = self._client(name)
            if reason.startswith(COMPILING):
                self._deadline = time.monotonic() + seconds
                reason = COMPILING  # its progress is in the log of that node
            if reason != logged:
                self._node.get_logger().info(f"waiting for {node}: {reason}")
                logged = reason
            if time.monotonic() > self._deadline:
                raise RunError(
                    f"waited {seconds:g} s for the node {node}: {reason}; start it in the same "
                    "ROS_DOMAIN_ID and namespace, or take its name out of the parameter wait_for"
                )
            self._spin_once(_POLL)
        return _node_of(self._clients[name]) if logged else ""

    def _client(self, name: str) -> Client:
        return self._node.create_client(Trigger, f"{name}/ready")

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
        counts = read_json(answer)
    except JsonError:
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
