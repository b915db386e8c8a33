# SPDX-License-Identifier: Apache-2.0
"""Start-up barrier: a service that reports the readiness of a node, and the wait for those of other nodes.

Two nodes that a third one waits for may both be running and not be connected to each other yet. A ready node therefore
answers with the number of readers of each of its topics. The waiting node has discovered all readers of every node
whose `~/ready` service it sees, because that service is created last; it compares the two numbers.

The answer of a service is lost as long as DDS has not connected the server to the client, which sees the server
already: mostly for a second, rarely for long, where an earlier process was killed. An unanswered client is made anew
after some seconds, and where the run is under way the wait ends without an answer.

Latched frame topics do not replace this. In lockstep, at 5 times real time, a recorder that came a second late missed
the first 11 s although a publisher keeps 1000 frames; and readers that ask for latched messages are not connected to
publishers of the usual, volatile kind.

A node that compiles offers the service meanwhile too, before its topics. Its answer then begins with `COMPILING`: the
waiting node takes it for absent, and waits as long as it compiles.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from rclpy.service import Service
from std_srvs.srv import Trigger

from drill_twin.core.errors import RunError
from drill_twin.core.files.json_files import JsonError, read_json
from drill_twin.ros.core.stop_request import StopRequest

if TYPE_CHECKING:
    from drill_twin.ros.core.node import TwinNode

COMPILING = "compiling"
"""First word of the reason of a node that is not ready because it compiles."""
_POLL = 0.05  # s
_ANSWER_TIME = 1.0  # s
_NO_ANSWER = "it did not answer"
_RENEW_AFTER = 5  # requests without an answer
_GO_ON_AFTER = 2  # requests without an answer, where the run is under way


class StartupBarrier:
    """Readiness of a node, and its wait for the readiness of others."""

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._service: Service | None = None
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

    def _answer(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        reason = self._node.not_ready() or self.unmatched_readers()
        publishers = self._node.topics.publishers.values()
        counts = {publisher.topic_name: publisher.get_subscription_count() for publisher in publishers}
        response.success = not reason
        response.message = reason or json.dumps(counts)
        return response

    def unmatched_readers(self) -> str:
        """Topics of this node with a reader that is not connected yet, in a sentence; empty when all are."""
        late = [
            topic
            for topic, publisher in self._node.topics.publishers.items()
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
        others = [_Other(self._node, name) for name in names.split()]
        self._deadline = time.monotonic() + seconds
        # All must be there before the first is asked: its answer is compared with the readers of all the others.
        for ready in (False, True):
            for other in others:
                self._wait(other, seconds, stop, under_way, ready=ready)
        for other in others:
            other.close()
        while not stop and self.unmatched_readers() and time.monotonic() < self._deadline:
            self._node.spin_once(_POLL)

    def _wait(
        self, other: _Other, seconds: float, stop: StopRequest, under_way: Callable[[], bool], *, ready: bool
    ) -> None:
        """Wait until a node is there, or ready; the log says so where it takes a while."""
        console, logged, unanswered = self._node.get_logger(), "", 0
        while not stop and (reason := other.lacks(ready=ready)):
            unanswered = unanswered + 1 if reason == _NO_ANSWER else 0
            if unanswered >= _GO_ON_AFTER and under_way():
                console.warning(f"{other.name} did not answer; its run is under way, so this node joins it")
                return
            if unanswered and unanswered % _RENEW_AFTER == 0:
                other.renew()
            if reason.startswith(COMPILING):
                self._deadline = time.monotonic() + seconds
                reason = COMPILING  # its progress is in the log of that node
            if reason != logged:
                console.info(f"waiting for {other.name}: {reason}")
                logged = reason
            if time.monotonic() > self._deadline:
                raise RunError(
                    f"waited {seconds:g} s for the node {other.name}: {reason}; start it in the same "
                    "ROS_DOMAIN_ID and namespace, or take its name out of the parameter wait_for"
                )
            self._node.spin_once(_POLL)
        if logged:
            console.info(f"{other.name} is {'ready' if ready else 'there'}")


class _Other:
    """Node that is waited for."""

    def __init__(self, node: TwinNode, name: str) -> None:
        self._node, self._service = node, f"{name}/ready"
        self._client = node.create_client(Trigger, self._service)

    @property
    def name(self) -> str:
        """Full name of the node."""
        return str(self._client.service_name).removesuffix("/ready")

    def renew(self) -> None:
        """Make the client anew."""
        self.close()
        self._client = self._node.create_client(Trigger, self._service)

    def close(self) -> None:
        """Destroy the client."""
        self._node.destroy_client(self._client)

    def lacks(self, *, ready: bool) -> str:
        """Reason why the node is not there, or not `ready`; empty when it is."""
        if not self._client.service_is_ready():
            return "it is not there yet"
        answer = self._client.call_async(Trigger.Request())
        deadline = time.monotonic() + _ANSWER_TIME
        while not answer.done():
            if time.monotonic() > deadline:
                self._client.remove_pending_request(answer)
                return _NO_ANSWER
            self._node.spin_once(_POLL)
        said = answer.result()
        message = str(said.message)
        if ready:
            return missing_readers(self._node, message) if said.success else message
        return message if message.startswith(COMPILING) else ""


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
