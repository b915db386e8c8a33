# SPDX-License-Identifier: Apache-2.0
"""Checks of the running nodes in the domain: who publishes what, with which quality of service, clock and version."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from shutil import which
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from drill_twin.core import __version__
from drill_twin.core.errors import MessageError
from drill_twin.io.bag.reader import ends_of
from drill_twin.io.messages.decode import read_clock
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, TOPICS
from drill_twin.ros.core.graph import UNKNOWN_NAME, full_name, unmet
from drill_twin.ros.core.topics import SEVERAL_PUBLISHERS, message_class, quality
from drill_twin.ros.doctor.installation import Check, Verdict, judged

NODES, TOPIC_SECTION, CLOCKS = "nodes", "topics", "clocks"
NAME = "doctor"
_WORDS = {"best_effort": "best effort", "transient_local": "latched", "volatile": "not latched"}


@dataclass(frozen=True)
class Observed:
    """Nodes, endpoints and statuses seen in the domain."""

    nodes: Sequence[str]
    publishers: dict[str, list[TopicEndpointInfo]]
    readers: dict[str, list[TopicEndpointInfo]]
    statuses: dict[str, Status]
    """Diagnostics by full name of the node."""
    clocks: dict[str, list[tuple[float, int]]]
    """Wall time [s] at which each message was sent, and its simulated time [ns], by topic."""


def observe(node: Node, spin_once: Callable[[float], None], seconds: float) -> Observed:
    """Listen to the domain for a time [s]."""
    statuses: dict[str, Status] = {}
    clocks: dict[str, list[tuple[float, int]]] = {}

    def on_diagnostics(raw: bytes) -> None:
        with suppress(MessageError):
            statuses.update({f"/{status.name}": status for status in decode_diagnostics(bytes(raw))[1]})

    def on_clock(topic: str, raw: bytes, info: Mapping[str, Any]) -> None:
        with suppress(MessageError):
            clocks.setdefault(topic, []).append((info["source_timestamp"] * 1e-9, read_clock(bytes(raw))))

    row = TOPICS[DIAGNOSTICS]
    node.create_subscription(message_class(row), DIAGNOSTICS, on_diagnostics, quality(row), raw=True)
    listening: set[str] = set()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for topic, types in node.get_topic_names_and_types():
            if topic.endswith(CLOCK_TOPIC) and TOPICS[CLOCK_TOPIC].type_name in types and topic not in listening:
                listening.add(topic)
                node.create_subscription(
                    message_class(TOPICS[CLOCK_TOPIC]),
                    topic,
                    partial(on_clock, topic),
                    quality(TOPICS[CLOCK_TOPIC], depth=100),
                    raw=True,
                )
        spin_once(0.05)
    own = node.get_fully_qualified_name()
    names = sorted(f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces())
    topics = [topic for topic, _ in node.get_topic_names_and_types() if _contract(topic)]
    return Observed(
        [name for name in names if name != own],
        {topic: _others(node.get_publishers_info_by_topic(topic), own) for topic in topics},
        {topic: _others(node.get_subscriptions_info_by_topic(topic), own) for topic in topics},
        {name: status for name, status in statuses.items() if status.hardware_id.startswith("drill_twin")},
        clocks,
    )


def graph_checks(seen: Observed) -> Iterator[Check]:
    """Checks of the nodes, the topics and the clocks."""
    if not seen.nodes:
        start = "ros2 launch drill_twin twin.launch.py" if which("ros2") else "drill-twin ros node twin"
        yield Check(NODES, "nodes", "none in this domain", Verdict.NOTE, start)
        return
    yield from _nodes(seen)
    for topic in sorted(seen.publishers):
        yield _topic(topic, seen.publishers[topic], seen.readers[topic])
    for topic, times in sorted(seen.clocks.items()):
        yield _clock(topic, times, seen)


def _nodes(seen: Observed) -> Iterator[Check]:
    for name, count in Counter(seen.nodes).items():
        if count > 1:
            remedy = "end one of them, or give it a namespace: -r __ns:=/rig2"
            yield Check(NODES, name, f"{count} nodes of this name", Verdict.PROBLEM, remedy)
    paused = {status.hardware_id for status in seen.statuses.values() if status.values.get("state") == "paused"}
    stale = {name for name, status in seen.statuses.items() if status.level == Level.STALE}
    idle = {name for name in stale if not _has_clock(name, seen)}
    for name, status in sorted(seen.statuses.items()):
        waits = "the simulator is paused; " if status.level == Level.STALE and status.hardware_id in paused else ""
        other = status.values.get("version", "")
        if other and other != __version__:
            remedy = f"install the same version everywhere; this command is of {__version__}"
            yield Check(NODES, name, f"drill_twin {other}", Verdict.PROBLEM, remedy)
        elif status.level == Level.OK or waits:
            yield Check(NODES, name, f"drill_twin {other or 'of unknown version'}: {waits}{status.text}")
        elif name in idle:
            yield Check(NODES, name, f"waits: {status.text}", Verdict.NOTE)
        else:
            remedy = "see the log of the node, and docs/reference/diagnostics.md"
            yield Check(NODES, name, status.text, Verdict.PROBLEM, remedy)
    if idle:
        found = "none, as nothing sends /clock: the run has ended, has not begun, or its simulator was killed"
        remedy = "start a simulator or a replay, or end the nodes that wait; the log of the simulator says how it ended"
        yield Check(NODES, "simulator", found, Verdict.NOTE, remedy)
    silent = [name for name in dict.fromkeys(seen.nodes) if name not in seen.statuses]
    if silent:
        yield Check(NODES, "others", ", ".join(silent))


def _has_clock(name: str, seen: Observed) -> bool:
    """Tell whether anything sends a clock to a node: the clock of its namespace, or the clock without a namespace."""
    return any(seen.publishers.get(topic) for topic in (name.rpartition("/")[0] + CLOCK_TOPIC, CLOCK_TOPIC))


def _topic(topic: str, publishers: list[TopicEndpointInfo], readers: list[TopicEndpointInfo]) -> Check:
    row = TOPICS[_contract(topic)]
    found, remedy = f"{_list(publishers) or 'no publisher'} -> {_list(readers) or 'no reader'}", ""
    if wrong := [end for end in (*publishers, *readers) if end.topic_type != row.type_name]:
        found = f"{wrong[0].topic_type} of {full_name(wrong[0])}"
        remedy = f"use {row.type_name}, or another name: -r {topic.lstrip('/')}:=OTHER"
    elif len(set(map(full_name, publishers))) > 1 and row.name not in SEVERAL_PUBLISHERS:
        found, remedy = f"several publishers: {_list(publishers)}", "end one, or give it a namespace"
    elif mismatch := _mismatch(publishers, readers):
        found, remedy = mismatch
    return judged(TOPIC_SECTION, topic, found, remedy)


def _mismatch(publishers: list[TopicEndpointInfo], readers: list[TopicEndpointInfo]) -> tuple[str, str] | None:
    """Finding and remedy for the first pair that DDS does not connect; None without one."""
    for reader in readers:
        for publisher in publishers:
            if mismatch := unmet(reader.qos_profile, publisher.qos_profile):
                word, offered = (_WORDS.get(value, value) for value in mismatch[1:])
                asks, offers = full_name(reader), full_name(publisher)
                return (
                    f"{asks} asks for {word}, {offers} offers {offered}: nothing arrives",
                    f"let {offers} publish {word}, or {asks} ask for less (qos_overrides)",
                )
    return None


def _clock(topic: str, times: list[tuple[float, int]], seen: Observed) -> Check:
    source = _list(seen.publishers.get(topic, []))
    first, last = times[0], times[-1]
    found = f"{last[1] * 1e-9:.2f} s, by {source or 'unknown'}"
    if last[0] - first[0] < 0.2:
        return Check(CLOCKS, topic, f"{found}: stands still")
    if any(late < early for (_, early), (_, late) in pairwise(times)):
        remedy = "run one simulator or replay in a namespace; a loop or a reset steps back too"
        return Check(CLOCKS, topic, f"{found}: steps back", Verdict.PROBLEM, remedy)
    factor = (last[1] - first[1]) * 1e-9 / (last[0] - first[0])
    return Check(CLOCKS, topic, f"{found}: {factor:.2f} x real time")


def _contract(topic: str) -> str:
    """Topic of the contract that a full name stands for, in any namespace; empty where there is none."""
    return next((name for name in ends_of(topic) if name != DIAGNOSTICS or topic == name), "")


def _others(ends: Sequence[TopicEndpointInfo], own: str) -> list[TopicEndpointInfo]:
    return [end for end in ends if end.node_name != UNKNOWN_NAME and full_name(end) != own]


def _list(ends: Sequence[TopicEndpointInfo]) -> str:
    return ", ".join(dict.fromkeys(f"{full_name(end)} ({_quality(end.qos_profile)})" for end in ends))


def _quality(profile: QoSProfile) -> str:
    reliable = "reliable" if profile.reliability == ReliabilityPolicy.RELIABLE else "best effort"
    return reliable + (", latched" if profile.durability == DurabilityPolicy.TRANSIENT_LOCAL else "")
