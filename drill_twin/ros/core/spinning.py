# SPDX-License-Identifier: Apache-2.0
"""Events of a node: messages, services and timers, processed by the loop of the node when it has time for them.

`EventsExecutor` of rclpy (7.1.4 or later) delivers the events, one a turn, and does not look at every entity of the
node. `SingleThreadedExecutor` looks at some forty entities, a millisecond in Python. Errors of callbacks are
raised after the turn (`_keep`), because the executor would print a traceback. The load of the nodes is in
`evidence/docs/cost.md`.
"""

import time
from collections.abc import Callable

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from drill_twin.io.messages.good_samples import GoodSamples
from drill_twin.ros.core.requests import log_refusal
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics import NodeTopics

_OTHERS = 3  # events in a row that are no message, after which none is taken to be left
_AT_ONCE = 1000  # messages processed in one turn
_LAST = 0.8  # s for what still arrives, and for what readers still acknowledge, of the 2 s that a stop may take
_SLICE = 0.1  # s between two looks at a request to stop


class StateChanged(BaseException):
    """Raised by `spin_once` after a requested transition, to end the turn of the loop in which the request came."""


class SpinningNode(Node):
    """A node whose events are processed where its loop says so.

    Attributes:
        topics: Topics of the node of the contract.
        samples: Good and bad samples by topic.
        stop: Request to stop, once the loop has been given it.
    """

    samples: GoodSamples
    topics: NodeTopics

    def __init__(self, name: str, context: Context) -> None:
        Node.__init__(self, name, context=context)
        self.stop = StopRequest()
        self._spins = False
        self._raised: list[BaseException] = []
        self._executor = EventsExecutor(context=context)

    def spin_once(self, seconds: float) -> None:
        """Wait for a message, a service call or a timer, at most this long [s], and process what comes first.

        Within a callback, such as a transition that a service asks for, nothing else is processed.
        """
        if self._spins:
            time.sleep(seconds)
            return
        self._spins = True
        try:
            self._executor.spin_once(max(seconds, 0.0))
        except (ValueError, TypeError, RuntimeError, SystemError) as error:  # rclpy could not take a request or answer
            log_refusal(self, "taken by rclpy", error)
        finally:
            self._spins = False
        if self._raised:
            raise self._raised.pop(0)

    def spin_all(self, most: int = _AT_ONCE) -> None:
        """Process the messages that have arrived, `most` of them; to find that none is left takes 0.4 ms."""
        others = 0  # events without a message of the node's topics, such as times for rclpy itself
        for _ in range(most):  # a flood must not keep the node from its work
            taken = self.topics.taken
            self.spin_once(0.0)
            others = (others + 1) * (taken == self.topics.taken)
            if others > _OTHERS or self.stop:
                return

    def drain(self, quiet: float, longest: float = _LAST) -> None:
        """Process what is still arriving, until nothing has come for `quiet` seconds or `longest` have passed."""
        now = last = time.monotonic()
        end = now + longest
        while now - last < quiet and now < end:
            taken = self.topics.taken
            self.spin_once(0.01)
            now = time.monotonic()
            last = now if self.topics.taken > taken else last

    def flush(self, seconds: float = 5.0) -> None:
        """Wait until every reader has acknowledged all that was published, at most this long [s]; less after a stop."""
        begun = time.monotonic()
        for publisher in self.topics.publishers.values():
            while not publisher.wait_for_all_acked(Duration(seconds=_SLICE)):
                if time.monotonic() - begun > (min(seconds, _LAST) if self.stop else seconds):
                    return

    def _keep(self, callback: Callable[[], object]) -> None:
        """Call a function within the executor; an error is raised once the executor has returned."""
        try:
            callback()
        except BaseException as error:  # noqa: BLE001 - raised by `spin_once`
            self._raised.append(error)
