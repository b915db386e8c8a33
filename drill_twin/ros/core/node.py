# SPDX-License-Identifier: Apache-2.0
"""Base class of all nodes: a loop, the topics of the contract, diagnostics, and the start-up barrier.

A node has a loop of its own instead of `rclpy.spin`: each turn waits for messages, processes all that have arrived,
does the node's step, and checks whether the node was asked to stop.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar

from rclpy.context import Context
from rclpy.node import Node
from rclpy.service import Service

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.good_samples import GoodSamples
from drill_twin.io.messages.topics import DIAGNOSTICS
from drill_twin.ros.core.diagnostics_publisher import DiagnosticsPublisher
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.parameters import Parameter, declare, follow_changes
from drill_twin.ros.core.request_guard import Answer, guarded
from drill_twin.ros.core.startup_barrier import StartupBarrier
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics.node_topics import NodeTopics
from drill_twin.ros.core.topics.raw_subscriptions import RawSubscriptions

_DIAGNOSTICS_PERIOD = 1.0  # s


class TwinNode(Node):
    """A node of drill_twin.

    Raises:
        ParameterError: A parameter with which it cannot start.
    """

    NAME: ClassVar[str]
    PURPOSE: ClassVar[str]
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    OTHER_PARAMETERS: ClassVar[frozenset[str]] = frozenset()
    """Names of parameters of other nodes in this process."""
    ON_CHANGE: ClassVar[tuple[str, ...]] = ()
    """Topics of which this node expects a message on change only, so that their silence is no fault."""

    def __init__(self, context: Context) -> None:
        """Create the node without topics but the diagnostics."""
        super().__init__(self.NAME, context=context)
        self.settings: SimpleNamespace = declare(self, self.PARAMETERS, other_names=self.OTHER_PARAMETERS)
        follow_changes(self, self.PARAMETERS, self.settings, check=self.check_change, changed=self.on_change)
        self._raw_subscriptions = RawSubscriptions(self, context)
        self.samples = GoodSamples(on_change=self.ON_CHANGE)
        """Good and bad samples by topic."""
        self.topics = NodeTopics(self, self._raw_subscriptions, self.samples.unreadable)
        self.barrier = StartupBarrier(self)
        self.services_while_configured: list[Service] = []
        self.ended = False
        """True once the node is being closed in order."""
        self._diagnostics = DiagnosticsPublisher(self, self.topics)
        self._diagnostics_due = Tick(_DIAGNOSTICS_PERIOD)

    def create_service(self, srv_type: Any, srv_name: str, callback: Answer, **options: Any) -> Service:
        """Create a service whose requests cannot end the node, rclpy's own services of parameters included."""
        return super().create_service(srv_type, srv_name, guarded(self, srv_type, callback), **options)

    # --- implemented by each node ---------------------------------------------------------------------------------

    def on_start(self) -> None:
        """Create topics and load what is needed; may take long, and a signal ends it at once."""

    def step(self) -> None:
        """Do one turn of the loop."""
        self.spin_once(0.05)

    def on_stop(self) -> None:
        """Complete what is open; called once, also after an error."""

    @property
    def finished(self) -> bool:
        """True once the node has completed its task."""
        return False

    @property
    def topics_pending(self) -> bool:
        """True while topics are still to be created; the service `~/ready` is not offered before."""
        return False

    def not_ready(self) -> str:
        """Reason why this node cannot take part yet; empty when it can."""
        return ""

    def health(self) -> Status:
        """Diagnostic status, published once a second."""
        return Status(self.NAME, Level.OK, "running")

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse settings that hold a live change, by raising a DrillTwinError."""

    def on_change(self) -> None:
        """Apply a live change; the settings hold the new value."""

    # --- the loop -------------------------------------------------------------------------------------------------

    def run(self, stop: StopRequest) -> None:
        """Work until finished or asked to stop."""
        self.offer_readiness()
        while not stop and not self.finished:
            self.step()
            self.publish_due_diagnostics()

    def spin_once(self, seconds: float) -> None:
        """Wait for messages and service calls, at most this long [s], and process all that have arrived."""
        self._raw_subscriptions.spin_once(seconds)
        self.topics.pass_on_scenes()

    def drain(self, quiet: float, longest: float = 2.0) -> None:
        """Process what is still arriving, until nothing has come for `quiet` seconds or `longest` have passed."""
        self._raw_subscriptions.drain(quiet, longest)

    def publish_due_diagnostics(self) -> None:
        """Publish the diagnostics of this node, if the last ones are a second old."""
        if self._diagnostics_due.due():
            self.publish_diagnostics()

    def publish_diagnostics(self) -> None:
        """Publish the diagnostics of this node now."""
        self._diagnostics.publish(self.health, ended=self.ended)

    def offer_readiness(self) -> None:
        """Create the service `~/ready`, unless topics are still to be created."""
        if not self.topics_pending:
            self.barrier.create_service()

    def destroy_endpoints(self) -> None:
        """Destroy all topics and services of a configured node; the diagnostics remain."""
        self.barrier.destroy_service()
        for service in self.services_while_configured:
            self.destroy_service(service)
        self.services_while_configured.clear()
        self.topics.destroy_all_but(DIAGNOSTICS)
