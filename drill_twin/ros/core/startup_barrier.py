# SPDX-License-Identifier: Apache-2.0
"""Start-up barrier: the service `~/ready` of a node, and the wait of a sending node until its readers can receive.

Two nodes that a third node waits for may both run and not be connected to each other yet. A ready node therefore
answers with the number of readers of each of its topics. The waiting node has discovered all readers of every node
that answers, because `~/ready` is created last; it compares the two numbers. A node that compiles offers the service
too, and answers that it compiles; the waiting node then goes on waiting.

Of a connection between two others ROS tells nothing: `get_subscription_count` of rclpy knows the readers of a node's
own publishers, and the state `active` of the life cycle comes before any is connected. Where the simulator was
stopped while a recorder came, it called itself connected, and was not, in 2 of 6 starts.

Latched frame topics do not replace the barrier. In lockstep, at 5 times real time, a recorder that came a second late
missed the first 11 s although a publisher kept 1000 frames; and readers that ask for latched messages are not
connected to publishers of the usual, volatile kind.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING

from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from drill_twin.core.errors import RunError
from drill_twin.ros.core.graph import readers_of

if TYPE_CHECKING:
    from drill_twin.ros.core.node import TwinNode

COMPILING = "compiling"
"""First word of the reason of a node that is not ready because it compiles."""
_POLL = 0.05  # s
_ANSWER_TIME = 1.0  # s; an answer is lost as long as DDS has not connected the server to the client
_RENEW_AFTER = 5  # requests without an answer, as where an earlier process was killed
_GO_ON_AFTER = 2  # requests without an answer, where the run is under way


class StartupBarrier:
    """Wait for other nodes to be ready, and for the readers of this node to be connected."""

    def __init__(
        self, node: TwinNode, names: str, seconds: float, under_way: Callable[[], bool] = lambda: False
    ) -> None:
        """Begin to wait.

        Args:
            node: The node that waits.
            names: Node names in its namespace, or full ones, separated by spaces.
            seconds: Longest wait [s]; it begins again while a node answers that it compiles.
            under_way: Returns True where this node is connected to a run that has begun; a node that is there and does
                not answer is then not waited for.
        """
        self._node, self._seconds, self._under_way = node, seconds, under_way
        self._clients = {name: node.create_client(Trigger, f"{name}/ready") for name in names.split()}
        self._answers: dict[str, Future] = {}
        self._unanswered: Counter[str] = Counter()
        self._told: dict[str, str] = {}
        self._asked = 0.0
        self._deadline = time.monotonic() + seconds

    def passed(self) -> bool:
        """Return True once the wait is over; called at each turn of the loop of the node.

        Raises:
            RunError: A node was not ready in time.
        """
        now = time.monotonic()
        if self._clients and not self._answers:
            if now < self._asked + _POLL:
                return False
            self._asked = now
            there = [name for name, client in self._clients.items() if client.service_is_ready()]
            self._answers = {name: self._clients[name].call_async(Trigger.Request()) for name in there}
        if not all(answer.done() for answer in self._answers.values()) and now < self._asked + _ANSWER_TIME:
            return False
        reasons = {name: reason for name in tuple(self._clients) if (reason := self._reason(name))}
        self._answers = {}
        for name, reason in reasons.items():
            if self._told.get(name) != reason:
                self._told[name] = reason
                self._node.get_logger().info(f"waiting for {self._full_name(name)}: {reason}")
        if now > self._deadline and reasons:
            name, reason = next(iter(reasons.items()))
            raise RunError(
                f"waited {self._seconds:g} s for the node {self._full_name(name)}: {reason}; start the "
                "node in this ROS_DOMAIN_ID and namespace, or take the name out of the parameter wait_for"
            )
        if reasons or (unmatched_readers(self._node) and now < self._deadline):
            return False
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._clients = {}
        return True

    def _full_name(self, name: str) -> str:
        return str(self._clients[name].service_name).removesuffix("/ready")

    def _reason(self, name: str) -> str:
        """Reason to go on waiting for a node; empty where there is none."""
        answer, client = self._answers.get(name), self._clients[name]
        if answer is None:
            return "it is not there yet"
        if answer.done():
            self._unanswered[name] = 0
            said = answer.result()
            if said.success:
                return missing_readers(self._node, said.message)
            if str(said.message).startswith(COMPILING):
                self._deadline = time.monotonic() + self._seconds
                return COMPILING  # its progress is in the log of that node
            return str(said.message)
        client.remove_pending_request(answer)
        self._unanswered[name] += 1
        if self._unanswered[name] >= _GO_ON_AFTER and self._under_way():
            self._node.get_logger().warning(
                f"{self._full_name(name)} did not answer; its run is under way, so this node joins it"
            )
            self._node.destroy_client(self._clients.pop(name))
            return ""
        if self._unanswered[name] % _RENEW_AFTER == 0:
            self._node.destroy_client(client)
            self._clients[name] = self._node.create_client(Trigger, f"{name}/ready")
        return "it did not answer"


def answer_ready(node: TwinNode, response: Trigger.Response) -> Trigger.Response:
    """Answer of `~/ready`: the reason why a node is not ready, else how many readers of each topic it has."""
    reason = node.not_ready() or ("" if node.active else "it is not active") or unmatched_readers(node)
    counts = (f"{count} of {topic}" for topic, count in _connected(node).items())
    response.success, response.message = not reason, reason or f"connected readers: {', '.join(counts)}"
    return response


def unmatched_readers(node: TwinNode) -> str:
    """Topics of a node with a reader that is not connected yet, in a sentence; empty when all are."""
    return _late(node, _connected(node))


def missing_readers(node: Node, answer: str) -> str:
    """Topics of a ready node that readers known to this node are not connected to; empty when there are none.

    Args:
        node: The node that asked.
        answer: Message of the ready node; a node of another package may send any text, and counts as ready.
    """
    known = dict(node.get_topic_names_and_types())
    counts = {topic: int(count) for count, topic in re.findall(r"(\d{1,9}) of (/\w[\w/]*)", answer)}
    return _late(node, {topic: count for topic, count in counts.items() if topic in known})


def _connected(node: TwinNode) -> dict[str, int]:
    """Readers that each topic of a node is connected to."""
    return {one.topic_name: one.get_subscription_count() for one in node.topics.publishers.values()}


def _late(node: Node, counts: dict[str, int]) -> str:
    late = [topic for topic, count in counts.items() if count < readers_of(node, topic)]
    return f"not yet connected to the readers of {', '.join(late)}" if late else ""
