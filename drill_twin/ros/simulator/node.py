# SPDX-License-Identifier: Apache-2.0
"""The simulator node: set-points in, motion of the string out, in real time, as fast as possible, or in lockstep.

Each turn of its loop processes the commands that have come, advances the twin by a frame (compiled, with the GIL
released), publishes the frame, and waits until the next one is due. Simulated time starts at 0 with the first good
command, or at the time of a checkpoint.

It is a lifecycle node: `configure` compiles and builds, `activate` lets time run, `deactivate` lets it stand still,
`cleanup` drops the twin. With `autostart` it does the first two itself.
"""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from rclpy.context import Context
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.lifecycle.node import LifecycleNodeMixin

from drill_twin.core.errors import DrillTwinError, RunError, RunStopped
from drill_twin.dynamics.solver.slices import checked
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, STRING_POSES, WOB_COMMAND
from drill_twin.ros.core.lifecycle import answer_any_transition
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.scene_parameters import resolved, scene_of
from drill_twin.ros.core.stop_request import Stopped, StopRequest
from drill_twin.ros.core.topics.rclpy_topics import relative
from drill_twin.ros.simulator.parameters import PARAMETERS
from drill_twin.ros.simulator.simulation_interfaces import offer_where_installed
from drill_twin.ros.simulator.trigger_services import offer
from drill_twin.scene.blocks.numerics import frame_period

if TYPE_CHECKING:
    from drill_twin.ros.simulator.run_control import RunControl
    from drill_twin.ros.simulator.simulation import SimulatorRun
    from drill_twin.scene import Scene

_LEASE = 6.0  # s; a killed node has left the graph by then
_DISCOVERY = 1.0  # s; a living node has been found by then
_LOG_PERIOD = 5.0  # s between two lines about a compilation
_DONE, _REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class Configured(NamedTuple):
    """Parts of a configured simulator."""

    simulation: SimulatorRun
    control: RunControl


class Simulator(LifecycleNodeMixin, TwinNode):
    """Moves the string of a scene under the commands it receives."""

    NAME: ClassVar = "simulator"
    PURPOSE: ClassVar = "Moves the drillstring of a scene under the set-points it receives."
    PARAMETERS: ClassVar = PARAMETERS

    def __init__(self, context: Context) -> None:
        self._parts: Configured | None = None
        self._scene: Scene | None = None
        self._compiling = ""
        self._log_due = Tick(_LOG_PERIOD)
        self._stop = StopRequest()
        self._created = time.monotonic()
        self._refusal: Exception | None = None
        self._shut_down = False
        TwinNode.__init__(self, context)
        LifecycleNodeMixin.__init__(self)
        answer_any_transition(self, self._service_change_state)

    # --- life cycle -----------------------------------------------------------------------------------------------

    def on_start(self) -> None:
        """Configure and activate, unless a lifecycle manager is to do it."""
        if not self.settings.autostart:
            name = self.get_fully_qualified_name()
            self.get_logger().info(f"waiting to be configured: ros2 lifecycle set {name} configure")
            return
        self._scene = self._compiled_scene()
        for transition in (self.trigger_configure, self.trigger_activate):
            transition()
            if self._refusal is not None:
                raise self._refusal

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene, compile and build the twin, and announce it."""
        del state
        if self._compiling:
            self.get_logger().warning(f"not configured: {self._compiling}; it configures itself after that")
            return _REFUSED
        try:
            self._configure()
        except Exception as error:  # noqa: BLE001 - rclpy would swallow it; `on_start` raises it
            self._refusal = error
            self.destroy_endpoints()
            if not self.settings.autostart:
                self.get_logger().error(str(error))
            return _REFUSED
        return _DONE

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let time run."""
        del state
        self._set_active(active=True)
        return _DONE

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let time stand still; the twin keeps its state."""
        del state
        self._set_active(active=False)
        return _DONE

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Drop the twin."""
        del state
        if self._parts is not None:
            self._parts.simulation.destroy()
        self._parts = None
        self.destroy_endpoints()
        return _DONE

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the node."""
        del state
        self._shut_down = True
        self._set_active(active=False)
        return _DONE

    def _set_active(self, *, active: bool) -> None:
        if self._parts is not None:
            self._parts.control.active = active

    def _configure(self) -> None:
        # Imported here: it takes long, and a bad parameter should be refused before.
        from drill_twin.ros.simulator.run_control import RunControl
        from drill_twin.ros.simulator.simulation import SimulatorRun

        settings = self.settings
        scene, self._scene = self._scene or self._compiled_scene(), None
        rate = settings.frame_rate or scene.numerics.frame_rate
        # Before its own topics are there: the one that runs would report a second publisher.
        self._refuse_second_simulator(own=0)
        simulation = SimulatorRun(self, scene, rate)
        control = RunControl(simulation, settings, self.get_fully_qualified_name())
        self._refuse_second_simulator(own=1)
        if settings.checkpoint and Path(settings.checkpoint).exists():
            simulation.resume(settings.checkpoint)
        simulation.loop.announce()
        simulation.commands.subscribe()
        simulation.apply_settings()
        self.services_while_configured += offer(self, control.actions())
        self.services_while_configured += offer_where_installed(self, control)
        self._parts = Configured(simulation, control)
        self.offer_readiness()
        twin = simulation.loop.twin
        self.get_logger().info(
            f"{scene.name}: {twin.elements} elements, {twin.step_size * 1e6:.0f} us steps, {rate:g} frames/s, "
            f"{settings.pace}"
        )
        if simulation.waits_for_command:
            topics = [self.resolve_topic_name(relative(name)) for name in (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND)]
            self.get_logger().info(f"time stands still until a command comes on {', '.join(topics)}")

    def _compiled_scene(self) -> Scene:
        """Scene of the parameters; its kernels are in the cache afterwards.

        With autostart, services and diagnostics are served while they are compiled. Within a requested transition
        rclpy answers no other request; a signal ends the compilation in both cases.
        """
        from drill_twin.runs import compile_kernel

        settings = self.settings
        scene = resolved(scene_of(settings), settings.duration, self.get_logger().info)
        rate = settings.frame_rate or scene.numerics.frame_rate
        try:
            compile_kernel(scene, frame_period(rate), self._on_compilation)
        finally:
            if self._compiling:
                self._compiling = ""
                self.barrier.destroy_service()  # created again last, as the start-up barrier requires
        return scene

    def _on_compilation(self, progress: str) -> None:
        self._compiling = progress
        if self._log_due.due():
            self.get_logger().info(progress)
        self.publish_due_diagnostics()
        if not self.settings.autostart:
            if self._stop:
                raise RunError(f"stopped while {progress}")
            return
        self.barrier.create_service()
        self.spin_once(0.0)
        if self._shut_down:
            raise Stopped

    def _refuse_second_simulator(self, *, own: int) -> None:
        time.sleep(max(self._created + _DISCOVERY - time.monotonic(), 0.0))
        deadline = time.monotonic() + _LEASE
        while len(found := self.topics.publisher_nodes(STRING_POSES)) > own:
            if time.monotonic() > deadline:
                topic, domain = self.resolve_topic_name(relative(STRING_POSES)), self.context.get_domain_id()
                raise DrillTwinError(
                    f"expected to be the only simulator here, found publishers of {topic}: {', '.join(found)}, "
                    f"in ROS_DOMAIN_ID={domain}; stop it, or choose another domain or namespace"
                )
            time.sleep(0.1)

    # --- the loop -------------------------------------------------------------------------------------------------

    def run(self, stop: StopRequest) -> None:
        """Work until the run is over or asked to stop."""
        self._stop = stop

        def check() -> None:
            if stop:
                raise RunStopped

        with checked(check), suppress(RunStopped):
            super().run(stop)

    def step(self) -> None:
        """Advance by a frame, or wait for what the run needs."""
        self.spin_once(0.0)
        parts = self._parts
        if parts is None:
            self.spin_once(0.05)
            return
        parts.simulation.tell_commander()
        if parts.control.runs:
            parts.simulation.advance()
            parts.simulation.keep_pace()
        else:
            parts.simulation.stand_still(paused=parts.control.paused or not parts.control.active)
            self.spin_once(0.05)

    @property
    def finished(self) -> bool:
        """True once the wanted duration has been simulated, or a lifecycle manager has ended the node."""
        if self._parts is None:
            return self._shut_down
        return self._shut_down or self._parts.control.over or self._parts.simulation.complete

    def on_stop(self) -> None:
        """Write the last checkpoint, and wait until the readers have received everything."""
        if self._parts is not None:
            self._parts.simulation.close()

    def on_change(self) -> None:
        """Apply a live parameter."""
        if self._parts is not None:
            self._parts.simulation.apply_settings()

    # --- readiness and diagnostics --------------------------------------------------------------------------------

    @property
    def topics_pending(self) -> bool:
        """True until the node is configured."""
        return self._parts is None

    def not_ready(self) -> str:
        """Reason why the twin cannot be driven yet; empty when it can."""
        if self._parts is None:
            return self._compiling or ("it is being configured" if self.settings.autostart else "it is not configured")
        return "" if self._parts.control.active else "it is not active"

    def health(self) -> Status:
        """Pace, cost, set-points and their sources."""
        if self._parts is None:
            return Status(self.NAME, Level.OK, self.not_ready(), {"compiling": self._compiling})
        from drill_twin.ros.simulator.health import diagnostic_values, verdict

        simulation, control = self._parts
        values = {"state": control.state_text, **diagnostic_values(self.settings, simulation)}
        if len(publishers := self.topics.publisher_nodes(STRING_POSES)) > 1:
            topic = self.resolve_topic_name(relative(STRING_POSES))
            text = f"more than one simulator publishes {topic}: {', '.join(publishers)}"
            return Status(self.NAME, Level.ERROR, text, values)
        if not control.active or control.paused:
            return Status(self.NAME, Level.OK, f"{control.state_text} at {simulation.time_text}", values)
        return Status(self.NAME, *verdict(self.settings, simulation), values)
