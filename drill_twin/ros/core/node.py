# SPDX-License-Identifier: Apache-2.0
"""What all nodes share: one loop, the topics of the contract as bytes, diagnostics, and being ready.

A node has a loop of its own instead of `rclpy.spin`: it waits, takes all that has arrived, works, and looks whether it
was asked to stop. Messages come and go as CDR bytes (`messages`), never as Python objects.
"""

from __future__ import annotations

import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import ClassVar

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.service import Service
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, RPS_COMMAND, TOPICS, WOB_COMMAND
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.parameters import Parameter, Value, declare
from drill_twin.ros.core.qos_check import unheard
from drill_twin.ros.core.qos_overrides import OVERRIDABLE, readable_overrides
from drill_twin.ros.core.raw_subscriptions import ManualCallbackGroup, RawSubscriptions, Received
from drill_twin.ros.core.startup_barrier import connected_readers, readers_of
from drill_twin.ros.core.topic_qos import message_class, quality, relative
from drill_twin.ros.entry_points import StopRequest

_AGAIN = 60.0  # s until a trouble that comes back is told on the console again
_SENT_DEPTH = 1000  # messages kept until every reader has them; 5 s at 200 Hz

NOT_NAMED_YET = "_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_"
"""Full name of a node whose publisher has been discovered and whose name has not."""


class TwinNode(Node):
    """A node of drill_twin.

    Raises:
        ParameterError: A parameter with which it cannot start.
    """

    NAME: ClassVar[str]
    PURPOSE: ClassVar[str]
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, also_known: Sequence[str] = ()
    ) -> None:
        super().__init__(self.NAME, context=context)
        self.settings: SimpleNamespace = declare(self, self.PARAMETERS, values=values, also_known=also_known)
        self._ears = RawSubscriptions(self, context)
        self._by_hand = ManualCallbackGroup()
        self._listened: dict[str, tuple[str, QoSProfile]] = {}
        self._told: dict[str, float] = {}
        self.outgoing: dict[str, Publisher] = {}
        self.services_while_configured: list[Service] = []
        self._readiness: Service | None = None
        self.shares_parameters = bool(also_known)
        self._diagnostics = self.advertise(DIAGNOSTICS)
        self._tick = Tick(1.0)

    # --- what a node fills in -------------------------------------------------------------------------------------

    def open(self) -> None:
        """Get ready to work; may take long, and a signal ends it at once."""

    def work(self) -> None:
        """One turn of the loop."""
        self.listen_for(0.05)

    def close(self) -> None:
        """Put in order what is open; called once, also after an error."""

    @property
    def finished(self) -> bool:
        """Whether the node has done what it was started for."""
        return False

    @property
    def comes_later(self) -> bool:
        """Whether topics are still to be offered; then nobody is told yet that this node is here."""
        return False

    def not_ready(self) -> str:
        """Why this node cannot take part yet; empty when it can."""
        return ""

    def health(self) -> Status:
        """Diagnostic status, asked for once a second."""
        return Status(self.NAME, Level.OK, "running")

    def judge_live(self, settings: SimpleNamespace) -> None:
        """Refuse settings with a live change in them, by raising a DrillTwinError."""

    def on_live(self) -> None:
        """A live parameter was changed; the settings hold the new value."""

    # --- the loop -------------------------------------------------------------------------------------------------

    def run(self, stop: StopRequest) -> None:
        """Work until finished or asked to stop."""
        self.offer_readiness()
        while not stop and not self.finished:
            self.work()
            if self._tick.due():
                self.report_health()

    def listen_for(self, seconds: float) -> None:
        """Wait for something to arrive, at most this long [s], and take it with all that came with it."""
        self._ears.listen_for(seconds)

    def take_all(self) -> int:
        """Hand everything that has arrived to its callback, without waiting; returns how many messages."""
        return self._ears.take_all()

    @property
    def dropped(self) -> Mapping[str, int]:
        """Messages that fell out of a full queue unread, by topic, as of the last report."""
        return self._ears.queues.dropped

    def settle(self, quiet: float, longest: float = 2.0) -> None:
        """Take what is still arriving, until nothing has come for `quiet` seconds of wall time."""
        now = time.monotonic()
        last, end = now, now + longest
        while now - last < quiet and now < end:
            if self.take_all():
                last = now
            time.sleep(0.01)
            now = time.monotonic()

    def report_health(self) -> None:
        """Publish the diagnostics of this node now."""
        queues = self._ears.settle_queues()
        status = self.health()
        if status.level == Level.OK and (trouble := unheard(self, self._listened)):
            status = replace(status, level=Level.WARN, text=trouble)
        self._tell(status)
        named = replace(status, name=self.get_fully_qualified_name().lstrip("/"), values={**status.values, **queues})
        self._diagnostics.publish(encode_diagnostics(self.get_clock().now().nanoseconds, [named]))

    def _tell(self, status: Status) -> None:
        """On the console too, what is not well: not everybody looks at the diagnostics. Numbers in it may change."""
        now, kind = time.monotonic(), re.sub(r"[-+\d.]+", "", status.text)
        if status.level != Level.OK and now - self._told.get(kind, -_AGAIN) >= _AGAIN:
            self.get_logger().warning(status.text)
        if status.level != Level.OK:
            self._told[kind] = now

    def offer_readiness(self) -> None:
        """Create the service `~/ready`, last of all: who sees it has seen all topics of this node."""
        if self._readiness is None and not self.comes_later:
            self._readiness = self.create_service(Trigger, "~/ready", self._answer_ready)

    def retire(self) -> None:
        """Take back all topics and services but the diagnostics, as if they had never been offered."""
        for service in (self._readiness, *self.services_while_configured):
            if service is not None:
                self.destroy_service(service)
        self._ears.close()
        self._listened.clear()
        for topic in set(self.outgoing) - {DIAGNOSTICS}:
            self.destroy_publisher(self.outgoing.pop(topic))
        self._readiness = None
        self.services_while_configured.clear()

    # --- topics ---------------------------------------------------------------------------------------------------

    def advertise(self, topic: str, *, latched: bool | None = None) -> Publisher:
        """Publisher of a topic of the contract; give it bytes."""
        row = TOPICS[topic]
        offered = quality(row, depth=0 if row.latched else _SENT_DEPTH, latched=latched)
        with readable_overrides(topic):
            publisher = self.create_publisher(
                message_class(row), relative(topic), offered, qos_overriding_options=OVERRIDABLE
            )
        self.outgoing[topic] = publisher
        return publisher

    def listen(self, topic: str, received: Received, *, depth: int = 0, latched: bool | None = None) -> Subscription:
        """Subscription to a topic of the contract; the callback receives bytes."""
        row = TOPICS[topic]
        with readable_overrides(topic):
            subscription = self.create_subscription(
                message_class(row),
                relative(topic),
                _taken_by_hand,
                quality(row, depth=depth, latched=latched),
                callback_group=self._by_hand,
                qos_overriding_options=OVERRIDABLE,
                raw=True,
            )
        self._listened[subscription.topic_name] = (row.type_name, subscription.qos_profile)
        several = topic in (DIAGNOSTICS, WOB_COMMAND, RPS_COMMAND)  # publishers, whose numbers cannot be told apart
        self._ears.add(subscription, received, "" if several or depth == 1 or row.latched else topic)
        return subscription

    def publishers_of(self, topic: str) -> list[str]:
        """Full names of the nodes that publish a topic, one entry a publisher."""
        found = self.get_publishers_info_by_topic(self.resolve_topic_name(relative(topic)))
        return sorted(f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in found)

    def readers_not_matched(self) -> str:
        """Topics of this node that a reader waits for but is not connected to yet; empty when all are."""
        late = [
            topic
            for topic, publisher in self.outgoing.items()
            if publisher.get_subscription_count() < readers_of(self, publisher.topic_name)
        ]
        return f"not yet connected to the readers of {', '.join(late)}" if late else ""

    def flush(self, seconds: float = 5.0) -> None:
        """Wait until every reader has received all that was published, at most this long [s]."""
        deadline = time.monotonic() + seconds
        for publisher in self.outgoing.values():
            left = max(deadline - time.monotonic(), 0.0)
            publisher.wait_for_all_acked(Duration(seconds=left))

    def _answer_ready(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        reason = self.not_ready() or self.readers_not_matched()
        response.success = not reason
        response.message = reason or connected_readers(self.outgoing.values())
        return response


def _taken_by_hand(raw: bytes) -> None:
    """Rclpy wants a callback; nothing calls this one."""
    raise AssertionError(f"an executor took {len(raw)} bytes that were to be taken by hand")
