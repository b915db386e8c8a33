# SPDX-License-Identifier: Apache-2.0
"""Publishers and subscriptions of a node, by topic of the contract; messages are CDR bytes, decoded by their row."""

import importlib
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription

from drill_twin.core.errors import MessageError, ParameterError
from drill_twin.io.messages.readers import reader_of
from drill_twin.io.messages.topic_row import Topic
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, RPS_COMMAND, TF, TOPICS, TWIN_SCENE, WOB_COMMAND
from drill_twin.ros.core.given import given_parameters, refuse_unknown, warn_of_misspelled
from drill_twin.ros.core.graph import UNKNOWN_NAME, full_name, unmet
from drill_twin.ros.core.queues import DropCounter, SceneGate

SEVERAL_PUBLISHERS = (DIAGNOSTICS, WOB_COMMAND, RPS_COMMAND, TF)
"""Topics that several nodes may publish; the sequence numbers of the publishers cannot be told apart."""
_PATIENCE = Duration(seconds=0.1)  # longest wait for a reader, which may have been killed
_QOS_OVERRIDES = "qos_overrides."
_ENDS, _POLICIES = "publisher|subscription", "history|depth|reliability|durability"
_OVERRIDE = re.compile(rf"qos_overrides\.(/.+)\.(?:{_ENDS})\.(?:{_POLICIES})")
_OVERRIDABLE = QoSOverridingOptions(
    (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
)
_BYTES_AND_INFO = inspect.Signature([inspect.Parameter(name, inspect.Parameter.POSITIONAL_ONLY) for name in "ab"])

Received = Callable[[bytes, Mapping[str, Any]], object]
"""Callback of a subscription: the CDR bytes, and rclpy's information on the message, such as its times."""
Kept = Callable[[Callable[[], object]], None]
"""Calls a function; keeps an error that it raises until the executor has returned."""


def relative(topic: str, namespace: str = "") -> str:
    """Topic name relative to the node's namespace, so that two twins can share a domain; `/diagnostics` is global.

    A namespace given as "/rig2" stands in place of the node's.
    """
    if topic == DIAGNOSTICS:
        return topic
    return namespace + topic if namespace else topic.lstrip("/")


def message_class(topic: Topic) -> Any:
    """Message class of a topic in rclpy, which has no common base class."""
    package, _, name = topic.type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def installed(topic: str) -> bool:
    """True where the package of a topic's messages is installed; the wheels lack tf2_msgs."""
    return find_spec(TOPICS[topic].type_name.partition("/")[0]) is not None


def quality(topic: Topic, *, depth: int = 0, latched: bool | None = None) -> QoSProfile:
    """Quality of service of a topic; depth 0 and latched None stand for the contract's values."""
    keep = topic.latched if latched is None else latched
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        history=HistoryPolicy.KEEP_LAST,
        depth=depth or topic.depth,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if keep else DurabilityPolicy.VOLATILE,
    )


class NodeTopics:
    """Topics of the contract that a node publishes and subscribes to.

    Quality of service can be given as to every ROS 2 node, by parameters `qos_overrides./topic.publisher.depth`.
    """

    def __init__(self, node: Node, unreadable: Callable[[str], object], kept: Kept) -> None:
        """Connect the topics to their node.

        Args:
            node: The node.
            unreadable: Called with the topic of a message that could not be decoded or used.
            kept: Calls the callbacks of messages.
        """
        self.publishers: dict[str, Publisher] = {}
        """Publishers by topic of the contract."""
        self.prefix = ""
        """Namespace of the topics that are advertised from now on, as "/rig2"; empty: the node's."""
        self.muted = False
        """True while messages are dropped, but for latched ones: the node is inactive."""
        self.taken = 0
        """Messages taken."""
        self.number: int | None = None
        """Sequence number that its publisher gave the message which is being handed over."""
        self._node, self._unreadable, self._kept = node, unreadable, kept
        self.scenes = SceneGate(lambda _: None)
        """Gate of `/twin/scene`, where the node reads it."""
        self._inputs: list[tuple[Subscription, str, str]] = []  # with the type, and the name to count drops by
        self.drops = DropCounter()
        """Messages that were dropped unread from a full queue, as of the last `queue_report`."""

    def advertise(self, topic: str) -> Publisher:
        """Create the publisher of a topic, which is given bytes."""
        row = TOPICS[topic]
        offered = quality(row, depth=row.publisher_depth, latched=row.offered_latched)
        with _readable_overrides(topic):
            publisher = self.publishers[topic] = self._node.create_publisher(
                message_class(row), relative(topic, self.prefix), offered, qos_overriding_options=_OVERRIDABLE
            )
        return publisher

    def publish(self, topic: str, raw: bytes) -> None:
        """Publish a message on an advertised topic; a latched one replaces the last once every reader has that."""
        if TOPICS[topic].latched:
            self.publishers[topic].wait_for_all_acked(_PATIENCE)
        self.publishers[topic].publish(raw)

    def withdraw(self, topic: str) -> None:
        """Destroy the publisher of a topic."""
        self._node.destroy_publisher(self.publishers.pop(topic))

    def subscribe(
        self,
        topic: str,
        received: Callable[[Any], object],
        *,
        depth: int = 0,
        latched: bool | None = None,
        malformed: Callable[[str], object] | None = None,
    ) -> Subscription:
        """Create the subscription to a topic.

        Args:
            topic: The topic.
            received: Called with each message, decoded as the topic's row says; may raise MessageError as well.
            depth: Messages that wait; 0: the contract's number.
            latched: Whether earlier messages are asked for; None: as the contract says.
            malformed: Called with the reason why a message could not be used, in place of counting it.
        """
        read = reader_of(topic)

        def decoded(raw: bytes, _: Mapping[str, Any]) -> None:
            try:
                received(read(raw))
            except MessageError as error:
                self._unreadable(topic) if malformed is None else malformed(str(error))

        return self.subscribe_raw(topic, decoded, depth=depth, latched=latched)

    def subscribe_scenes(self, received: Callable[[bytes], object]) -> Subscription:
        """Create the subscription to `/twin/scene`; the callback gets the bytes that the gate lets pass."""
        gate = self.scenes = SceneGate(received)
        return self.subscribe_raw(TWIN_SCENE, lambda raw, _: gate.take(raw), depth=1)

    def subscribe_raw(
        self, topic: str, received: Received, *, depth: int = 0, latched: bool | None = None
    ) -> Subscription:
        """Create the subscription to a topic; the callback receives bytes, and what rclpy knows of the message."""
        row = TOPICS[topic]
        keeps = row.latched if latched is None else latched
        counted = topic if topic not in SEVERAL_PUBLISHERS and depth != 1 and not row.offered_latched else ""

        def take(*given: Any) -> None:
            raw, info = given if len(given) > 1 else given[0]  # rclpy 7.1.6 hands over both as one argument
            self.taken += 1
            self.number = info["publication_sequence_number"]
            if all(kept is not subscription for kept, *_ in self._inputs):  # destroyed while the message waited
                return
            self.drops.take(counted, info)
            if keeps or not self.muted:
                self._kept(lambda: received(bytes(raw), info))

        setattr(take, "__signature__", _BYTES_AND_INFO)  # noqa: B010 - by it rclpy knows what to hand over
        with _readable_overrides(topic):
            subscription = self._node.create_subscription(
                message_class(row),
                relative(topic),
                take,
                quality(row, depth=depth, latched=latched),
                qos_overriding_options=_OVERRIDABLE,
                raw=True,
            )
        self._inputs.append((subscription, row.type_name, counted))
        return subscription

    def unsubscribe(self, subscription: Subscription) -> None:
        """Destroy a subscription."""
        self._inputs = [row for row in self._inputs if row[0] is not subscription]
        self._node.destroy_subscription(subscription)

    def destroy_all_but(self, kept: str) -> None:
        """Destroy all subscriptions, and all publishers except one topic's."""
        for subscription, _, _ in self._inputs:
            self._node.destroy_subscription(subscription)
        for topic in set(self.publishers) - {kept}:
            self.withdraw(topic)
        self._inputs, self.drops, self.scenes = [], DropCounter(), SceneGate(lambda _: None)

    def queue_report(self) -> dict[str, str]:
        """Fill and drops of the queues since the last report, for the diagnostics."""
        counted = {topic: subscription for subscription, _, topic in self._inputs if topic}
        self.drops.confirm_gaps(lambda topic: counted[topic].get_publisher_count() if topic in counted else 0)
        return self.drops.values()

    def publisher_nodes(self, topic: str) -> list[str]:
        """Full names of the nodes that publish a topic, one entry a publisher."""
        found = self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(relative(topic)))
        return sorted(map(full_name, found))

    def several_clocks(self) -> str:
        """Sentence on a clock of this node that several publish; empty where one does, or this node has none."""
        clock = self._node.resolve_topic_name(relative(CLOCK_TOPIC))
        reader = next((one for one, *_ in self._inputs if one.topic_name == clock), None)
        own = self.publishers.get(CLOCK_TOPIC) or reader
        found = [] if own is None else sorted(map(full_name, self._node.get_publishers_info_by_topic(own.topic_name)))
        if len(found) < 2:
            return ""
        names = f"expected one publisher of {CLOCK_TOPIC}, found {', '.join(found)}; stop all but one, for time flips"
        return names if len(set(found)) > 1 else f"{names}; a killed one is listed for up to 20 s"

    @property
    def loss(self) -> str:
        """Messages that were dropped unread, in a sentence; empty where none was."""
        lost = ", ".join(f"{number} of {topic}" for topic, number in self.drops.dropped.items())
        return f"messages were dropped unread, as this node was too slow for them: {lost}" if lost else ""

    def incompatible_publisher(self) -> str:
        """First publisher that a subscription is not connected to, with reason and remedy; empty where none is."""
        for subscription, kind, _ in self._inputs:
            topic = subscription.topic_name
            for info in self._node.get_publishers_info_by_topic(topic):
                if info.node_name == UNKNOWN_NAME:
                    continue
                name = full_name(info)
                if info.topic_type != kind:
                    return f"{topic}: expected {kind}, found {info.topic_type} of {name}, not received; publish {kind}"
                if mismatch := unmet(subscription.qos_profile, info.qos_profile):
                    policy, expected, found = mismatch
                    return (
                        f"{topic}: expected a {expected} publisher, found {name} as {found}, not received; publish "
                        f"{expected}, or start this node with qos_overrides.{topic}.subscription.{policy}:={found}"
                    )
        return ""


@contextmanager
def _readable_overrides(topic: str) -> Iterator[None]:
    """Turn rclpy's errors about an override into one line.

    Raises:
        ParameterError: The policy does not know the value.
    """
    try:
        yield
    except (InvalidQosOverridesError, InvalidParameterTypeException, RuntimeError, ValueError) as error:
        raise ParameterError(
            f"qos_overrides of {topic}: expected history keep_last or keep_all, a depth, reliability reliable or "
            f"best_effort, durability volatile or transient_local; found {error}"
        ) from error


def refuse_unused_overrides(node: Node) -> None:
    """Refuse overrides of topics that this node lacks, which rclpy ignores; warn where they were given to all nodes.

    Raises:
        ParameterError: An override that was meant for this node names no topic of this node.
    """
    known = [f"{_QOS_OVERRIDES}{name}" for name in node.get_parameters_by_prefix(_QOS_OVERRIDES.removesuffix("."))]
    given = [name for name in given_parameters(node) if name.startswith(_QOS_OVERRIDES)]
    others = refuse_unknown(node, known, [name for name in given if name not in known])
    found = {name: _OVERRIDE.fullmatch(name) for name in others}
    misspelled = [name for name, parts in found.items() if parts is None or not _ends_as_known(parts[1])]
    ends = [f"{end}.{policy}" for end in _ENDS.split("|") for policy in _POLICIES.split("|")]
    warn_of_misspelled(node, misspelled, (f"{_QOS_OVERRIDES}{topic}.{end}" for topic in TOPICS for end in ends))


def _ends_as_known(topic: str) -> bool:
    """True for a topic of the contract, in any namespace."""
    return any(topic[place:] in TOPICS for place in range(len(topic)) if topic[place] == "/")
