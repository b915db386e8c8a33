# SPDX-License-Identifier: Apache-2.0
"""The simulator: set-points in, the moving string out, in real time, as fast as possible, or in lockstep.

Each turn of its loop takes the commands that have come, lets the twin take one frame's worth of steps (compiled, with
the GIL released), publishes the frame, and waits until the next one is due. Simulated time starts at 0 with the first
good command, or where a checkpoint left it.

It is a lifecycle node: to configure it builds and compiles, to activate it lets time run, to deactivate it lets time
stand still, to clean it up forgets the twin. With `autostart` it does the first two itself.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from rclpy.context import Context
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.lifecycle.node import LifecycleNodeMixin

from drill_twin.errors import DrillTwinError
from drill_twin.io.messages.topics import CLOCK_TOPIC, RIG_COMMAND, RPS_COMMAND, STRING_POSES, WOB_COMMAND
from drill_twin.ros.core.lifecycle import answer_any_transition
from drill_twin.ros.core.pacing import Pacer
from drill_twin.ros.core.parameters import Value
from drill_twin.ros.core.scene_parameters import resolved, scene_of
from drill_twin.ros.core.topic_qos import relative
from drill_twin.ros.simulator.run_control import RunControl
from drill_twin.ros.simulator.simulation_interfaces import offer_where_installed
from drill_twin.ros.simulator.trigger_services import offer

_LEASE = 6.0  # s; a killed node has left the graph by then
_DISCOVERY = 1.0  # s; a living node has been found by then
_DONE, _REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class Simulator(LifecycleNodeMixin, RunControl):
    """Moves the string of a scene under the commands it receives."""

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, other_parameters: Sequence[str] = ()
    ) -> None:
        RunControl.__init__(self, context, values, other_parameters)
        LifecycleNodeMixin.__init__(self)
        answer_any_transition(self, self._service_change_state)
        self._born = time.monotonic()
        self._refusal: Exception | None = None

    # --- life cycle -----------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Configure and activate, unless somebody else is to do it."""
        if not self.settings.autostart:
            self.get_logger().info("waiting to be configured: ros2 lifecycle set /simulator configure")
            return
        for transition in (self.trigger_configure, self.trigger_activate):
            transition()
            if self._refusal is not None:
                raise self._refusal

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene, compile and build the twin, and announce it."""
        del state
        try:
            self._configure()
        except Exception as error:  # noqa: BLE001 - rclpy would swallow it; `open` raises it
            self._refusal = error
            self.destroy_endpoints()
            if not self.settings.autostart:
                self.get_logger().error(str(error))
            return _REFUSED
        return _DONE

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let time run."""
        del state
        self._active = True
        return _DONE

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let time stand still; the twin keeps its state."""
        del state
        self._active = False
        return _DONE

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the twin."""
        del state
        self._keeper.finish()
        self.destroy_endpoints()
        self._stage.retire()
        self._stage = None
        self._started = self._paused = False
        return _DONE

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the node."""
        del state
        self._over, self._active = True, False
        return _DONE

    def _configure(self) -> None:
        # Imported here: compiling takes long, and a bad parameter should be refused before.
        from drill_twin.ros.simulator.command_subscriptions import CommandSubscriptions
        from drill_twin.ros.simulator.twin_publisher import TOPICS_OF_TWIN, TwinPublisher

        settings = self.settings
        scene = resolved(scene_of(settings), settings.duration, self.get_logger().info)
        rate = settings.frame_rate or scene.numerics.frame_rate
        self._period = 1.0 / rate
        self._pacer = Pacer(self._period)
        for topic in TOPICS_OF_TWIN:
            self.topics.advertise(topic)
        # Latched, so that a driver which comes back in mid-run learns at once what time it is.
        self.topics.advertise(CLOCK_TOPIC, latched=True)
        stage = TwinPublisher(self, scene, self._period, settings.pace, self.topics.publishers)
        self._inbox = CommandSubscriptions(self, scene, stage.first, lambda: stage.twin.time)
        self._refuse_a_second_one()
        if settings.checkpoint and Path(settings.checkpoint).exists():
            self._go_on_from(settings.checkpoint, stage)
        stage.announce()
        self._inbox.listen()
        self.on_change()
        actions = (self.pause, self.resume, self.step, self.reset, self.save_checkpoint, self.load_checkpoint)
        self.services_while_configured += offer(self, {action.__name__: action for action in actions})
        self.services_while_configured += offer_where_installed(self, self)
        self._stage = stage
        self.offer_readiness()
        self.get_logger().info(
            f"{scene.name}: {stage.twin.elements} elements, {stage.twin.step_size * 1e6:.0f} us steps, "
            f"{rate:g} frames/s, {settings.pace}"
        )
        if self._waits_for_command():
            topics = [self.resolve_topic_name(relative(name)) for name in (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND)]
            self.get_logger().info(f"time stands still until a command comes on {', '.join(topics)}")

    def _refuse_a_second_one(self) -> None:
        time.sleep(max(self._born + _DISCOVERY - time.monotonic(), 0.0))
        deadline = time.monotonic() + _LEASE
        while len(others := self.topics.publisher_nodes(STRING_POSES)) > 1:
            if time.monotonic() > deadline:
                raise DrillTwinError(
                    f"expected to be the only simulator here, found {len(others) - 1} more, publishing "
                    f"{STRING_POSES}, in ROS_DOMAIN_ID={self.context.get_domain_id()}; stop it, or choose "
                    "another domain or namespace"
                )
            time.sleep(0.1)
