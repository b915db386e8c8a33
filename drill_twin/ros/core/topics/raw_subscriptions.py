# SPDX-License-Identifier: Apache-2.0
"""Subscriptions of a node, waited for and taken without rclpy's executor.

A turn of rclpy's executor visits every entity of a node, some forty of them, in Python: a millisecond, and at 200
frames a second more than the motion itself. Messages need none of it, so the executor skips the subscriptions. Thirty
times a second one call checks for service requests and answers, and only then the executor spins; for the rest
(DDS events, timers) it spins twice a second.
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

from drill_twin.ros.core.request_guard import log_refusal
from drill_twin.ros.core.topics.drop_counter import DropCounter

_AT_ONCE = 200  # messages of one topic taken in one turn
_SERVICE_PERIOD = 0.03  # s; longest wait of a service call
_SPIN_PERIOD = 0.5  # s; longest wait of anything else
_NANOSECONDS = 1e9

Received = Callable[[bytes, Mapping[str, Any]], None]
"""Callback of a subscription: the CDR bytes, and the times at which they were sent and received."""


class ManualCallbackGroup(CallbackGroup):
    """Excludes subscriptions from an executor; their DDS events are still the executor's."""

    def can_execute(self, entity: Any) -> bool:
        """Return True if the executor may process an entity."""
        return not isinstance(entity, Subscription)

    def beginning_execution(self, entity: Any) -> bool:
        """Return True if the executor may process an entity now."""
        return self.can_execute(entity)

    def ending_execution(self, entity: Any) -> None:
        """No-op: nothing is locked."""


class RawSubscriptions:
    """Raw subscriptions of a node, and the executor for its services, clients and events."""

    def __init__(self, node: Node, context: Context) -> None:
        self._node = node
        self._context = context
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(node)
        self._incoming: list[tuple[Subscription, Received, str]] = []
        self.drops = DropCounter()
        self._wait_set: Any = None
        self._services_due = self._spin_due = 0.0

    def add(self, subscription: Subscription, received: Received, topic: str = "") -> None:
        """Read a subscription from now on; its callback group is `ManualCallbackGroup`.

        Args:
            subscription: A raw subscription of the node.
            received: Callback.
            topic: Name under which dropped messages are counted; empty: they are not counted.
        """
        self._incoming.append((subscription, received, topic))
        self._wait_set = None

    def close(self) -> None:
        """Destroy all subscriptions."""
        for subscription, _, _ in self._incoming:
            self._node.destroy_subscription(subscription)
        self._incoming.clear()
        self._wait_set = None

    def spin_once(self, seconds: float) -> None:
        """Wait for a message, at most this long [s], and process all that have arrived.

        Returns sooner when the executor is due.
        """
        self._wait(min(seconds, self._services_due - time.monotonic()))
        self.take_all()
        now = time.monotonic()
        if now < self._services_due:
            return
        if now >= self._spin_due or self._services_waiting():
            try:
                self._executor.spin_once(timeout_sec=0.0)
            except (ValueError, TypeError, RuntimeError) as error:  # rclpy could not take a request or an answer
                log_refusal(self._node, "taken by rclpy", error)
            self._spin_due = time.monotonic() + _SPIN_PERIOD
        self._services_due = time.monotonic() + _SERVICE_PERIOD

    def drain(self, quiet: float, longest: float) -> None:
        """Process messages until none has come for `quiet` seconds of wall time, or `longest` have passed."""
        now = time.monotonic()
        last, end = now, now + longest
        while now - last < quiet and now < end:
            if self.take_all():
                last = now
            time.sleep(0.01)
            now = time.monotonic()

    def take_all(self) -> int:
        """Hand everything that has arrived to its callback, without waiting; returns how many messages."""
        count = 0
        for subscription, received, topic in tuple(self._incoming):
            waiting = 0
            while waiting < _AT_ONCE and (taken := _take(subscription)) is not None:
                raw, info = taken
                if topic:
                    self.drops.add_sequence_number(topic, info["publication_sequence_number"])
                received(raw, info)
                waiting += 1  # bounded: a flood must not keep the node from its work
            self.drops.add_queue_length(waiting)
            count += waiting
        return count

    def queue_report(self) -> dict[str, str]:
        """Fill and drops of the queues since the last report, for the diagnostics."""
        publishers = {topic: subscription for subscription, _, topic in self._incoming if topic}
        self.drops.confirm_gaps(lambda topic: publishers[topic].get_publisher_count() if topic in publishers else 0)
        return self.drops.values()

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

    def _services_waiting(self) -> bool:
        """Return True if a service request, an answer, or a message for rclpy itself (its clock) has arrived."""
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
        taken: tuple[bytes, Mapping[str, Any]] | None = subscription.handle.take_message(subscription.msg_type, True)
    return taken
