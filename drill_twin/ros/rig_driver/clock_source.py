# SPDX-License-Identifier: Apache-2.0
"""Clock of the simulator among several publishers of `/clock`, of which some may be processes that were killed."""

import time
from collections.abc import Callable

from drill_twin.io.messages.topics import CLOCK_TOPIC
from drill_twin.ros.core.topics import NodeTopics

_SETTLED = 1.0  # s of wall time in which one publisher alone was heard; a slower clock is not told from a rival


class ClockSource:
    """Subscription to `/clock` that passes on the stamps of one publisher, and none while two are heard.

    The middleware lists a process that was killed for up to 20 s more. Sequence numbers tell whether it is heard:
    the numbers of one publisher follow each other, and where two are heard, they do not.
    """

    def __init__(self, topics: NodeTopics, alone: Callable[[int], object], two_are_heard: Callable[[], object]) -> None:
        """Subscribe to the clock.

        Args:
            topics: Topics of the node.
            alone: Called with each stamp [ns] of a clock that is alone.
            two_are_heard: Called in place of `alone` once the stamps of two clocks were heard.
        """
        self._topics, self._alone, self._two_are_heard = topics, alone, two_are_heard
        self._number, self._changed_at = 0, 0.0  # sequence number, and when numbers last did not follow each other [s]
        self._held: int | None = None  # ns; last stamp that was not passed on
        self._two = False
        self._subscribe()

    def _subscribe(self) -> None:
        self._subscription = self._topics.subscribe(CLOCK_TOPIC, self._take, depth=1, latched=True)

    def _take(self, stamp: int) -> None:
        number, now = self._topics.number or 0, time.monotonic()
        follows, self._number = number == self._number + 1, number
        doubted = now - self._changed_at < _SETTLED
        if not follows:
            self._two, self._changed_at = doubted, now
        if self._subscription.get_publisher_count() <= 1 or (follows and not doubted):
            self._held = None
            self._alone(stamp)
            return
        self._held = stamp
        if self._two:
            self._two_are_heard()

    def settle(self) -> None:
        """Go by the clock that is left, which may wait for an answer to its last message. Called once a second."""
        if self._held is None:
            return
        if self._subscription.get_publisher_count() <= 1:  # the last message may be of the publisher that is gone
            self._held = None
            self._topics.unsubscribe(self._subscription)
            self._subscribe()
        elif time.monotonic() - self._changed_at >= _SETTLED:
            stamp, self._held = self._held, None
            self._alone(stamp)
