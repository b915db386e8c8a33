# SPDX-License-Identifier: Apache-2.0
"""How a node hears: messages are waited for and taken here, everything else is the executor's.

A turn of rclpy's executor goes through every entity of a node, some forty of them, in Python: a millisecond, and at 200
frames a second more than the motion itself. Messages need none of it. So the executor leaves the subscriptions alone;
thirty times a second it is looked, in one call, whether somebody has asked a service or answered, and only then the
executor has its turn. For the rest (events of DDS, timers) it has one twice a second.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription

from drill_twin.ros.core.drop_counter import DropCounter

_AT_ONCE = 200  # messages of one topic taken in one turn
_ATTENTION = 0.03  # s; a service call waits no longer than this
_REST = 0.5  # s; nor does anything else wait longer than this
_NANOSECONDS = 1e9

Received = Callable[[bytes, Mapping[str, Any]], None]
"""Callback of a subscription: the CDR bytes, and when they were sent and received."""


class ManualCallbackGroup(CallbackGroup):
    """Keeps an executor from taking the messages of a subscription; its events are still the executor's."""

    def can_execute(self, entity: Any) -> bool:
        """Whether the executor may."""
        return not isinstance(entity, Subscription)

    def beginning_execution(self, entity: Any) -> bool:
        """Whether the executor may now."""
        return self.can_execute(entity)

    def ending_execution(self, entity: Any) -> None:
        """Nothing is locked."""


class RawSubscriptions:
    """The subscriptions of a node, and its executor for all else."""

    def __init__(self, node: Node, context: Context) -> None:
        self._node = node
        self._context = context
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(node)
        self._incoming: list[tuple[Subscription, Received, str]] = []
        self.queues = DropCounter()
        self._wait_set: Any = None
        self._attention_due = self._rest_due = 0.0

    def add(self, subscription: Subscription, received: Received, topic: str = "") -> None:
        """Hear a topic from now on; its callback group is `ManualCallbackGroup`.

        Args:
            subscription: To what.
            received: Who hears it.
            topic: Name under which dropped messages are counted; none where only the newest is wanted.
        """
        self._incoming.append((subscription, received, topic))
        self._wait_set = None

    def close(self) -> None:
        """Hear nothing more."""
        for subscription, _, _ in self._incoming:
            self._node.destroy_subscription(subscription)
        self._incoming.clear()
        self._wait_set = None

    def listen_for(self, seconds: float) -> None:
        """Wait for something to arrive, at most this long [s], and take it with all that came with it.

        Returns sooner when the executor is due.
        """
        self._wait(min(seconds, self._attention_due - time.monotonic()))
        self.take_all()
        now = time.monotonic()
        if now < self._attention_due:
            return
        if now >= self._rest_due or self._is_asked():
            self._executor.spin_once(timeout_sec=0.0)
            self._rest_due = time.monotonic() + _REST
        self._attention_due = time.monotonic() + _ATTENTION

    def take_all(self) -> int:
        """Hand everything that has arrived to its callback, without waiting; returns how many messages."""
        count = 0
        for subscription, received, topic in tuple(self._incoming):
            waiting = 0
            while waiting < _AT_ONCE and (taken := _take(subscription)) is not None:
                raw, info = taken
                if topic:
                    self.queues.number(topic, info["publication_sequence_number"])
                received(raw, info)
                waiting += 1  # not for ever: a flood must not keep the node from its work
            self.queues.took(waiting)
            count += waiting
        return count

    def settle_queues(self) -> dict[str, str]:
        """How full the queues were, for the diagnostics."""
        publishers = {topic: subscription for subscription, _, topic in self._incoming if topic}
        self.queues.settle(lambda topic: publishers[topic].get_publisher_count() if topic in publishers else 0)
        return self.queues.values()

    def _wait(self, seconds: float) -> None:
        if seconds <= 0.0:
            return
        if not self._incoming:
            time.sleep(seconds)
            return
        if self._wait_set is None:
            self._wait_set = self._new_wait_set(subscriptions=len(self._incoming))
        self._wait_set.clear_entities()
        for subscription, _, _ in self._incoming:
            self._wait_set.add_subscription(subscription.handle)
        self._wait_set.wait(round(seconds * _NANOSECONDS))

    def _is_asked(self) -> bool:
        """Whether a service was called, an answer has come, or a message for rclpy itself, such as its clock."""
        ours = {id(subscription) for subscription, _, _ in self._incoming}
        others = [subscription for subscription in self._node.subscriptions if id(subscription) not in ours]
        services, clients = list(self._node.services), list(self._node.clients)
        wait_set = self._new_wait_set(len(others), len(clients), len(services))
        wait_set.clear_entities()
        for other in others:
            wait_set.add_subscription(other.handle)
        for client in clients:
            wait_set.add_client(client.handle)
        for service in services:
            wait_set.add_service(service.handle)
        wait_set.wait(0)
        return any(wait_set.get_ready_entities(kind) for kind in ("subscription", "client", "service"))

    def _new_wait_set(self, subscriptions: int = 0, clients: int = 0, services: int = 0) -> Any:
        return rclpy_implementation.WaitSet(subscriptions, 0, 0, clients, services, 0, self._context.handle)


def _take(subscription: Subscription) -> tuple[bytes, Mapping[str, Any]] | None:
    with subscription.handle:
        return subscription.handle.take_message(subscription.msg_type, True)
