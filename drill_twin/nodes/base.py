# SPDX-License-Identifier: Apache-2.0
"""What all nodes share: start and end, the topics of the contract as bytes, diagnostics, and being ready.

A node has one loop of its own instead of `rclpy.spin`: it waits, takes all that has arrived, works, and looks
whether it was asked to stop. Messages come and go as CDR bytes (`messages`), never as Python objects.
"""

from __future__ import annotations

import importlib
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.service import Service
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

from drill_twin.errors import DrillTwinError, RunError
from drill_twin.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.messages.topics import DIAGNOSTICS, TOPICS, Topic
from drill_twin.nodes import discovery
from drill_twin.nodes.overrides import OVERRIDABLE, readable_overrides, refuse_unused
from drill_twin.nodes.parameters import Parameter, Value, declare, file_text, help_text
from drill_twin.nodes.readiness import connected_readers, missing_readers, readers_of
from drill_twin.nodes.security import readable_refusal
from drill_twin.nodes.start import StopRequest

_AT_ONCE = 200  # messages of one topic taken in one turn
_SENT_DEPTH = 1000  # messages kept until every reader has them; 5 s at 200 Hz

Received = Callable[[bytes, Mapping[str, Any]], None]
"""Callback of a subscription: the CDR bytes, and when they were sent and received."""


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
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self)
        self._incoming: list[tuple[Subscription, Received]] = []
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
        self._executor.spin_once(timeout_sec=seconds)
        self.take_all()

    def take_all(self) -> int:
        """Hand everything that has arrived to its callback, without waiting; returns how many messages."""
        count = 0
        for subscription, received in tuple(self._incoming):
            for _ in range(_AT_ONCE):  # not for ever: a flood must not keep the node from its work
                if (taken := _take(subscription)) is None:
                    break
                received(*taken)
                count += 1
        return count

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
        named = replace(self.health(), name=self.get_fully_qualified_name().lstrip("/"))
        self._diagnostics.publish(encode_diagnostics(self.get_clock().now().nanoseconds, [named]))

    def offer_readiness(self) -> None:
        """Create the service `~/ready`, last of all: who sees it has seen all topics of this node."""
        if self._readiness is None and not self.comes_later:
            self._readiness = self.create_service(Trigger, "~/ready", self._answer_ready)

    def retire(self) -> None:
        """Take back all topics and services but the diagnostics, as if they had never been offered."""
        for service in (self._readiness, *self.services_while_configured):
            if service is not None:
                self.destroy_service(service)
        for subscription, _ in self._incoming:
            self.destroy_subscription(subscription)
        for topic in set(self.outgoing) - {DIAGNOSTICS}:
            self.destroy_publisher(self.outgoing.pop(topic))
        self._readiness = None
        self.services_while_configured.clear()
        self._incoming.clear()

    # --- topics ---------------------------------------------------------------------------------------------------

    def advertise(self, topic: str, *, latched: bool | None = None) -> Publisher:
        """Publisher of a topic of the contract; give it bytes."""
        row = TOPICS[topic]
        depth = 0 if row.latched else _SENT_DEPTH
        quality = _quality(row, depth=depth, latched=latched)
        with readable_overrides(topic):
            publisher = self.create_publisher(
                message_class(row), _relative(topic), quality, qos_overriding_options=OVERRIDABLE
            )
        self.outgoing[topic] = publisher
        return publisher

    def listen(self, topic: str, received: Received, *, depth: int = 0, latched: bool | None = None) -> Subscription:
        """Subscription to a topic of the contract; the callback receives bytes."""
        row = TOPICS[topic]
        quality = _quality(row, depth=depth, latched=latched)

        def callback(raw: bytes, info: Mapping[str, Any]) -> None:
            received(raw, info)

        with readable_overrides(topic):
            subscription = self.create_subscription(
                message_class(row), _relative(topic), callback, quality, raw=True, qos_overriding_options=OVERRIDABLE
            )
        self._incoming.append((subscription, received))
        return subscription

    def publishers_of(self, topic: str) -> list[str]:
        """Full names of the nodes that publish a topic, one entry a publisher."""
        found = self.get_publishers_info_by_topic(self.resolve_topic_name(_relative(topic)))
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
            publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=left))

    # --- waiting for others ---------------------------------------------------------------------------------------

    def wait_for_nodes(self, names: str, seconds: float, stop: StopRequest | None = None) -> None:
        """Wait until each of these nodes says that it is ready.

        Args:
            names: Node names in this namespace, separated by spaces.
            seconds: Longest wait [s].
            stop: Ends the wait early.

        Raises:
            RunError: One did not become ready in time.
        """
        clients = {name: self.create_client(Trigger, f"{name}/ready") for name in names.split()}
        deadline = time.monotonic() + seconds
        # Twice: only who has seen all of them can tell whether each is connected to all the others.
        for ask in (self._ask_present, self._ask_ready):
            for name, client in clients.items():
                said = ""
                while not stop and (reason := ask(client)):
                    if reason != said:
                        self.get_logger().info(f"waiting for {name}: {reason}")
                        said = reason
                    if time.monotonic() > deadline:
                        raise RunError(
                            f"waited {seconds:g} s for the node {name}: {reason}; start it in the same ROS_DOMAIN_ID "
                            "and namespace, or take its name out of the parameter wait_for"
                        )
                if said:
                    self.get_logger().info(f"{name} is {'there' if ask == self._ask_present else 'ready'}")
        for client in clients.values():
            self.destroy_client(client)
        while not stop and self.readers_not_matched() and time.monotonic() < deadline:
            self.listen_for(0.05)

    def _ask_present(self, client: Any) -> str:
        if client.service_is_ready():
            return ""
        self.listen_for(0.05)
        return "it is not there yet"

    def _ask_ready(self, client: Any) -> str:
        answer = client.call_async(Trigger.Request())
        deadline = time.monotonic() + 1.0
        while not answer.done():
            if time.monotonic() > deadline:
                client.remove_pending_request(answer)
                return "it did not answer"
            self.listen_for(0.05)
        reason = answer.result().message
        if answer.result().success:
            reason = missing_readers(self, reason)
        if reason:
            self.listen_for(0.05)
        return reason

    def _answer_ready(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        reason = self.not_ready() or self.readers_not_matched()
        response.success = not reason
        response.message = reason or connected_readers(self.outgoing.values())
        return response


class Tick:
    """True once every `period` seconds of wall time."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._next = time.monotonic()

    def due(self) -> bool:
        """Whether the period has passed since it was last due."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = max(self._next + self._period, now)
        return True


def run_node(make: type[TwinNode], arguments: Sequence[str], stop: StopRequest) -> None:
    """Start one node, run it, and end it in order whatever happens.

    Raises:
        DrillTwinError: It refused to start or could not go on.
    """
    if asks_for_help(make.NAME, make.PURPOSE, make.PARAMETERS, arguments):
        return
    context = initialised(arguments, stop)
    try:
        with stop.at_once(), readable_refusal():
            node = make(context)
        run_in_order(node, stop)
    finally:
        context.try_shutdown()


def initialised(arguments: Sequence[str], stop: StopRequest) -> Context:
    """An rclpy context for these arguments, with our discovery defaults and without rclpy's signal handlers.

    Raises:
        DrillTwinError: The arguments are none that ROS knows.
    """
    discovery.prepare()
    context = Context()
    try:
        with stop.at_once():
            rclpy.init(args=list(arguments), context=context, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy raises several classes of its own here, and RuntimeError
        raise DrillTwinError(f"ROS arguments: {_first_line(error)}") from error
    if left := remove_ros_args(["", *arguments])[1:]:
        context.try_shutdown()
        raise DrillTwinError(f"expected only --help or --ros-args ..., found {' '.join(left)!r}")
    return context


def run_in_order(node: TwinNode, stop: StopRequest) -> None:
    """Open, run and close a node; destroys it."""
    try:
        with stop.at_once():
            node.open()
            if not node.comes_later and not node.shares_parameters:
                refuse_unused(node)
        node.run(stop)
    finally:
        try:
            node.close()
        finally:
            node.destroy_node()


def asks_for_help(name: str, purpose: str, table: Sequence[Parameter], arguments: Sequence[str]) -> bool:
    """Whether --help was given, or --parameters for the node's parameter file; prints it."""
    if {"-h", "--help"} & set(arguments):
        print(help_text(name, purpose, table))
    elif list(arguments) == ["--parameters"]:
        print(file_text(name, purpose, table), end="")
    else:
        return False
    return True


def _take(subscription: Subscription) -> tuple[bytes, Mapping[str, Any]] | None:
    with subscription.handle:
        return subscription.handle.take_message(subscription.msg_type, True)


def _relative(topic: str) -> str:
    """Topics follow the node's namespace, so that two twins can share a domain; diagnostics are one for all."""
    return topic if topic == DIAGNOSTICS else topic.lstrip("/")


def message_class(topic: Topic) -> Any:
    """The rclpy class of a topic's messages."""
    package, _, name = topic.type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def _quality(topic: Topic, *, depth: int = 0, latched: bool | None = None) -> QoSProfile:
    keep = topic.latched if latched is None else latched
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        history=HistoryPolicy.KEEP_LAST,
        depth=depth or topic.depth,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if keep else DurabilityPolicy.VOLATILE,
    )


def _first_line(error: BaseException) -> str:
    text = str(error).strip()
    line = text.splitlines()[0] if text else type(error).__name__
    return re.sub(r", at [^,\s]+:\d+", "", line).removeprefix("failed to initialize rcl: ")
