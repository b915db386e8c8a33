# SPDX-License-Identifier: Apache-2.0
"""Base class of all nodes: a lifecycle node with the topics of the contract, diagnostics, and the start-up barrier."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, ClassVar

from lifecycle_msgs.srv import ChangeState
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.lifecycle.node import LifecycleNodeMixin
from rclpy.service import Service
from rclpy.timer import Timer
from std_srvs.srv import Trigger

from drill_twin.core.errors import DrillTwinError, shortened
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS
from drill_twin.ros.core.diagnostics_publisher import DiagnosticsPublisher, NodeInputs, of_inactive
from drill_twin.ros.core.parameters import Parameter, Value, declare, follow_changes
from drill_twin.ros.core.policy import Rights
from drill_twin.ros.core.requests import Answer, guarded, sending_later
from drill_twin.ros.core.spinning import SpinningNode, StateChanged
from drill_twin.ros.core.startup_barrier import answer_ready
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics import NodeTopics, refuse_unused_overrides

_DONE, _FAILED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
_DIAGNOSTICS_PERIOD, _SCENE_PERIOD = 1.0, 0.1  # s between two reports, and two looks at the scenes that wait
AUTOSTART = Parameter(
    "autostart", True, "whether to configure and activate itself; else a lifecycle manager does (ros2 lifecycle)"
)
"""Parameter of every node."""


class TwinNode(LifecycleNodeMixin, SpinningNode):
    """A node of drill_twin: a lifecycle node that by default configures and activates itself.

    A node implements `configure` and, where it has something to do there, `complete`, `activate` and `deactivate`. An
    inactive node takes no step, and of messages only latched ones. Attributes that `configure` makes are gone after
    `complete`; an attribute that `complete` reads has a default in the class, or `complete` asks whether it is there,
    since a stop may come before it is made.

    Raises:
        ParameterError: The node cannot start with a parameter that was given.
    """

    NAME: ClassVar[str]
    PURPOSE: ClassVar[str]
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    RIGHTS: ClassVar[Rights] = Rights()
    ON_CHANGE: ClassVar[tuple[str, ...]] = ()
    """Topics of which this node expects a message on change only, so that their silence is no fault."""
    TIMED_BY: ClassVar[str] = CLOCK_TOPIC
    """Topic of which the publisher moves the time of all inputs."""
    configured = False
    """True from the beginning of `configure` until `complete` is over."""

    def __init__(self, context: Context, others: Iterable[str] = (), **defaults: Value) -> None:
        """Create the node without topics but the diagnostics.

        Args:
            context: The rclpy context.
            others: Names of parameters of other nodes in this process.
            defaults: Values of parameters in place of the defaults of the table.
        """
        SpinningNode.__init__(self, self.NAME, context)
        table = [replace(row, default=defaults.get(row.name, row.default)) for row in self.PARAMETERS]
        self.settings, self.unknown = declare(self, table, other_names=others)  # unknown: meant for other nodes
        self._shares_its_process = bool(others)
        follow_changes(self, table, self.settings, check=self.check_change, changed=self._changed)
        self.samples = NodeInputs(self, self.ON_CHANGE, self.TIMED_BY)
        self.topics = NodeTopics(self, lambda topic: self.samples.unreadable(topic), self._keep)  # noqa: PLW0108 - it changes
        self._starts, self._attributes = False, frozenset[str]()  # of the unconfigured node
        self.active = self.ended = self.ends = False
        """True while active; true once closed in order; true once asked by a service to end."""
        self._endpoints: list[Service | Timer] = []
        self._ready: Service | None = None
        self._refusal: Exception | None = None  # of the last transition
        self._unfinished: Exception | None = None  # of a requested clean-up, raised at the end
        LifecycleNodeMixin.__init__(self)
        for service in self.services:
            if service.srv_type is ChangeState:  # rclpy raises where the present state does not have the transition
                service.callback = guarded(self, ChangeState, partial(self._change_state, service.callback))
        self._executor.add_node(self)
        self._diagnostics = DiagnosticsPublisher(self, self.topics)
        self._every(_DIAGNOSTICS_PERIOD, self.publish_diagnostics)
        self._every(_SCENE_PERIOD, lambda: self.topics.scenes.work())  # noqa: PLW0108 - it changes

    def configure(self) -> None:
        """Load what is needed; create topics, services and timers. An error refuses the transition."""

    def activate(self) -> None:
        """Begin to work."""

    def deactivate(self) -> None:
        """Rest, until `activate`."""

    def complete(self) -> None:
        """Complete what is open; called once after `configure`, also at the end of the node and after an error."""

    def step(self) -> None:
        """Do one turn of the loop, while active."""
        self.spin_once(0.05)

    @property
    def finished(self) -> bool:
        """True once the node has completed its task; asked while it is configured."""
        return False

    def not_ready(self) -> str:
        """Reason why this node cannot take part yet; empty when it can."""
        return ""

    def health(self) -> Status:
        """Diagnostic status, published once a second while it is configured."""
        return Status(self.NAME, Level.OK, "running")

    def status(self, values: Mapping[str, str], *told: tuple[Level, str]) -> Status:
        """Status with these values, and with the first of some sentences that is not empty."""
        return Status(self.NAME, *next(one for one in told if one[1]), values)

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse settings that hold a live change, by raising a DrillTwinError."""

    def on_change(self) -> None:
        """Apply a live change, while it is configured; the settings hold the new value."""

    def create_service(self, srv_type: Any, srv_name: str, callback: Answer, **options: Any) -> Service:
        """Create a service whose requests cannot end the node, rclpy's own services of parameters included."""
        service = super().create_service(srv_type, srv_name, guarded(self, srv_type, callback), **options)
        sending_later(service)
        if self.configured:
            self._endpoints.append(service)
        return service

    def every(self, period: float, callback: Callable[[], object]) -> None:
        """Create a timer by the wall clock [s], whatever `use_sim_time` says; it rests while the node is inactive."""
        self._endpoints.append(self._every(period, lambda: callback() if self.active else None))

    def _every(self, period: float, callback: Callable[[], object]) -> Timer:
        return self.create_timer(period, lambda: self._keep(callback), clock=Clock(clock_type=ClockType.STEADY_TIME))

    def offer_ready(self) -> None:
        """Create the service `~/ready`, unless it exists; called after all topics of this node were created."""
        if self._ready is None:
            self._ready = super().create_service(Trigger, "~/ready", lambda _, response: answer_ready(self, response))

    def withdraw_ready(self) -> None:
        """Destroy the service `~/ready`."""
        if self._ready is not None:
            self.destroy_service(self._ready)
        self._ready = None

    def start(self) -> None:
        """Configure and activate, unless a lifecycle manager is to do it.

        Raises:
            Exception: The node refused.
        """
        if not getattr(self.settings, "autostart", True):
            name = self.get_fully_qualified_name()
            self.get_logger().info(f"waiting to be configured: ros2 lifecycle set {name} configure")
            return
        self._starts = True
        for transition in (self.trigger_configure, self.trigger_activate):
            transition()
            if self._refusal is not None:
                raise self._refusal
        self._starts = False

    def _change_state(self, change: Answer, request: Any, response: Any) -> Any:
        """Answer a requested transition, then end the turn of the loop: what the rest of it would use may be gone."""
        if self._starts or self.ended:
            does = "ends" if self.ended else "starts by itself"
            raise DrillTwinError(f"expected a node that can change its state, found a node that {does}")
        asked, offered = request.transition, {row[0]: row[1] for row in self._state_machine.available_transitions}
        if asked.label not in offered.values() if asked.label else asked.id not in offered:  # rcl would log any label
            found = shortened(asked.label or str(asked.id))
            raise DrillTwinError(f"expected a transition of {', '.join(offered.values())}, found {found}")
        response = change(request, response)
        self._raised.append(StateChanged())
        return response

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Configure the node, or leave it as it was."""
        done = self._attempt(self._configure)
        if self._refusal is not None:
            self.clean_up()
        return done

    def _configure(self) -> None:
        self._attributes = frozenset(vars(self))
        self.configured, self.samples = True, NodeInputs(self, self.ON_CHANGE, self.TIMED_BY)
        self.configure()
        if not self._shares_its_process:
            refuse_unused_overrides(self)
        self.topics.muted = not self.active
        self.offer_ready()

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Let the node work."""
        return self._attempt(self.activate, lambda: self._set_active(active=True))

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Let the node rest."""
        return self._attempt(self.deactivate, lambda: self._set_active(active=False))

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Complete what is open, and drop what could not be completed all the same."""
        self._attempt(self.clean_up)
        self._unfinished = self._refusal or self._unfinished
        return _DONE

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Ask the node to end."""
        self.end()
        return _DONE

    def _attempt(self, *actions: Callable[[], object]) -> TransitionCallbackReturn:
        """Do a transition; its error is logged, or kept for `start`, because rclpy would swallow it."""
        self._refusal = None
        try:
            for action in actions:
                action()
        except Exception as error:  # noqa: BLE001 - logged here, or raised by `start`
            self._refusal = error
            if not self._starts:
                self.get_logger().error(str(error))
        return _FAILED if self._refusal else _DONE

    def _set_active(self, *, active: bool) -> None:
        self.active, self.topics.muted = active, not active
        self.samples.rest()
        self.publish_diagnostics()  # at once, before the readers of this node are silent for long

    def _changed(self) -> None:
        if self.configured:
            self.on_change()

    def clean_up(self) -> None:
        """Complete what is open, then destroy all topics, services and timers but the diagnostics.

        Raises:
            Exception: What is open could not be completed; the rest is destroyed all the same.
        """
        if not self.configured:
            return
        try:
            self.complete()
        finally:
            self.configured = False
            self.withdraw_ready()
            for endpoint in self._endpoints:
                self.destroy_timer(endpoint) if isinstance(endpoint, Timer) else self.destroy_service(endpoint)
            self._endpoints.clear()
            self.topics.destroy_all_but(DIAGNOSTICS)
            for name in vars(self).keys() - self._attributes:
                delattr(self, name)

    def end(self) -> None:
        """Ask the node to end."""
        self.ends = True

    def close(self) -> None:
        """Complete what is open, and destroy the node.

        Raises:
            Exception: What is open could not be completed, now or when a lifecycle manager asked for it.
        """
        self.ended = True
        try:
            self.clean_up()
        finally:
            self._executor.shutdown()
            self.destroy_node()
        if self._unfinished is not None:
            raise self._unfinished

    def run(self, stop: StopRequest) -> None:
        """Work until finished or asked to stop."""
        self.stop = stop
        while not (stop or self.ends or (self.configured and self.finished)):
            with suppress(StateChanged):
                self.step() if self.active else self.spin_once(0.05)

    def publish_diagnostics(self) -> None:
        """Publish the diagnostics of this node now."""
        self._diagnostics.publish(self._health, ended=self.ended)

    def _health(self) -> Status:
        status = self.health() if self.configured else Status(self.NAME, Level.OK, "unconfigured")
        return status if self.active else of_inactive(status)
