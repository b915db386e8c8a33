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
from typing import Any, ClassVar

from rclpy.context import Context
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.lifecycle.node import LifecycleNodeMixin

from drill_twin.errors import CheckpointError, DrillTwinError
from drill_twin.messages.diagnostics import Level, Status
from drill_twin.messages.stamps import stamp_ns
from drill_twin.messages.topics import CLOCK_TOPIC, STRING_POSES
from drill_twin.nodes.base import Tick, TwinNode, run_node
from drill_twin.nodes.controls import offer
from drill_twin.nodes.keeper import Keeper
from drill_twin.nodes.lifecycle import answer_any_transition
from drill_twin.nodes.pacing import Pacer
from drill_twin.nodes.parameters import Value
from drill_twin.nodes.scenes import scene_of
from drill_twin.nodes.simulator_health import health_values, verdict
from drill_twin.nodes.simulator_parameters import PARAMETERS
from drill_twin.nodes.start import StopRequest

_LEASE = 6.0  # s; a killed node has left the graph by then
_BURST = 200  # frames; as fast as possible must not be faster than the readers
_DISCOVERY = 1.0  # s; a living node has been found by then
_DONE, _REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class Simulator(LifecycleNodeMixin, TwinNode):
    """Moves the string of a scene under the commands it receives."""

    NAME: ClassVar = "simulator"
    PURPOSE: ClassVar = "Moves the drillstring of a scene under the set-points it receives."
    PARAMETERS: ClassVar = PARAMETERS

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, also_known: Sequence[str] = ()
    ) -> None:
        TwinNode.__init__(self, context, values, also_known)
        LifecycleNodeMixin.__init__(self)
        answer_any_transition(self, self._service_change_state)
        self._born = time.monotonic()
        self._keeper = Keeper()
        self._stage: Any = None
        self._inbox: Any = None
        self._pacer = Pacer(1.0)
        self._active = self._paused = self._started = self._over = False
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
            self.retire()
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
        self.retire()
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
        from drill_twin.nodes.inbox import Inbox
        from drill_twin.nodes.stage import TOPICS_OF_STAGE, Stage

        settings = self.settings
        scene = scene_of(settings)
        rate = settings.frame_rate or scene.numerics.frame_rate
        self._period = 1.0 / rate
        self._pacer = Pacer(self._period)
        for topic in TOPICS_OF_STAGE:
            self.advertise(topic)
        # Latched, so that a driver which comes back in mid-run learns at once what time it is.
        self.advertise(CLOCK_TOPIC, latched=True)
        stage = Stage(scene, self._period, settings.pace, self.outgoing)
        self._inbox = Inbox(self, scene, stage.first, lambda: stage.twin.time)
        self._refuse_a_second_one()
        if settings.checkpoint and Path(settings.checkpoint).exists():
            self._go_on_from(settings.checkpoint, stage)
        stage.announce()
        self._inbox.listen()
        self.on_live()
        actions = (self.pause, self.resume, self.step, self.reset, self.save_checkpoint, self.load_checkpoint)
        self.services_while_configured += offer(self, {action.__name__: action for action in actions})
        self._stage = stage
        self.offer_readiness()
        self.get_logger().info(
            f"{scene.name}: {stage.twin.elements} elements, {stage.twin.step_size * 1e6:.0f} us steps, "
            f"{rate:g} frames/s, {settings.pace}"
        )

    def _refuse_a_second_one(self) -> None:
        time.sleep(max(self._born + _DISCOVERY - time.monotonic(), 0.0))
        deadline = time.monotonic() + _LEASE
        while len(others := self.publishers_of(STRING_POSES)) > 1:
            if time.monotonic() > deadline:
                raise DrillTwinError(
                    f"expected to be the only simulator here, found {len(others) - 1} more that publishes "
                    f"{STRING_POSES} in ROS_DOMAIN_ID={self.context.get_domain_id()}; stop it, or choose "
                    "another domain or namespace"
                )
            time.sleep(0.1)

    # --- one turn of the loop -------------------------------------------------------------------------------------

    def work(self) -> None:
        """Take one frame, or wait for what it needs."""
        self.take_all()
        if self._must_wait():
            self._pacer.restart()
            self.listen_for(0.05)
            return
        self.listen_for(0.0)
        if self._must_wait():  # a service may just have said so
            return
        self._advance()
        if self.settings.pace == "realtime":
            self._pacer.wait()
        elif self.settings.pace == "fast" and self._stage.frames % _BURST == 0:
            self.flush(1.0)

    def _must_wait(self) -> bool:
        return not self._active or self._paused or self._over or self._waits_for_command()

    def _waits_for_command(self) -> bool:
        desk = self._inbox.desk
        if not self._started and self.settings.wait_for_command and not desk.heard:
            return True
        return self.settings.pace == "lockstep" and desk.last_stamp <= stamp_ns(self._stage.twin.time)

    def _advance(self) -> None:
        self._started = True
        command = self._inbox.desk.set_point(self._period)
        self._stage.advance(command, picture=self._picture_due(), exaggeration=self.settings.exaggeration)
        if self._keep_due is not None and self._keep_due.due():
            self._keeper.keep(self._checkpoint(), self.settings.checkpoint)

    def _picture_due(self) -> bool:
        """In lockstep by simulated time, so that runs are alike; else by the wall clock, for the eyes."""
        if self.settings.pace != "lockstep" or self._picture is None:
            return self._picture is not None and self._picture.due()
        return self._stage.frames % max(round(1.0 / (self._period * self.settings.marker_rate)), 1) == 0

    def on_live(self) -> None:
        """A parameter was changed."""
        if self._inbox is None:
            return
        settings = self.settings
        self._inbox.follow_settings()
        self._picture = Tick(1.0 / settings.marker_rate) if settings.marker_rate else None
        keeps = settings.checkpoint and settings.checkpoint_period
        self._keep_due = Tick(settings.checkpoint_period) if keeps else None

    @property
    def finished(self) -> bool:
        """Whether the wanted duration has been simulated, or a lifecycle manager has ended the node."""
        wanted = self.settings.duration
        return self._over or bool(self._stage and wanted and self._stage.twin.time >= wanted - 0.5 * self._period)

    def close(self) -> None:
        """Keep the state, say how it went, and see that the readers have received everything."""
        self._keeper.finish()
        if self._stage is not None and self._stage.frame is not None:
            if self._keep_due is not None:
                self._keeper.keep(self._checkpoint(), self.settings.checkpoint)
                self._keeper.finish()
            self.report_health()
            self.flush()
            self.get_logger().info(f"{self._stage.twin.time:.2f} s simulated, {self._stage.cost.sentence()}")

    # --- services: each says in a sentence what it did ------------------------------------------------------------

    def pause(self) -> str:
        """Let time stand still."""
        self._paused = True
        return f"paused at {self._at()}"

    def resume(self) -> str:
        """Let time run again."""
        self._paused = False
        return f"running from {self._at()}"

    def step(self) -> str:
        """Take frames now, one after the other, so that they are out when the answer comes."""
        if not self._paused:
            raise DrillTwinError("expected a paused run to step, found one that runs; call ~/pause first")
        if self.settings.pace == "lockstep":
            raise DrillTwinError(
                "expected the pace realtime or fast to step by hand, found lockstep, where each command is a step; "
                "call ~/resume and send commands one by one"
            )
        count = self.settings.step_frames
        for _ in range(count):
            self._advance()
        return f"{count} frame{'s' if count > 1 else ''} on, at {self._at()}"

    def reset(self) -> str:
        """Begin again at time zero, as a run of its own."""
        self._inbox.begin_again()
        self._started = False
        self._pacer.restart()
        self._stage.reset()
        return f"began again at {self._at()}"

    def save_checkpoint(self) -> str:
        """Keep the state in the file that the parameter names."""
        path = self._checkpoint_path()
        self._keeper.finish()
        self._checkpoint().save(path)
        return f"kept {self._at()} in {path}"

    def load_checkpoint(self) -> str:
        """Go to the state in that file."""
        path = self._checkpoint_path()
        self._keeper.finish()
        self._go_on_from(path, self._stage)
        self._pacer.restart()
        self._stage.announce()
        return f"went to {self._at()}, from {path}"

    def _at(self) -> str:
        return f"t = {self._stage.twin.time:.6g} s"

    def _checkpoint_path(self) -> str:
        if not self.settings.checkpoint:
            raise CheckpointError(
                "expected a file for the checkpoint, found none; ros2 param set /simulator checkpoint FILE.npz"
            )
        return str(self.settings.checkpoint)

    def _checkpoint(self) -> Any:
        from drill_twin.checkpoint import Checkpoint

        return Checkpoint.of(self._stage.twin, self._inbox.desk.good)

    def _go_on_from(self, path: str, stage: Any) -> None:
        from drill_twin.checkpoint import Checkpoint

        checkpoint = Checkpoint.load(path)
        if self.settings.duration and checkpoint.time >= self.settings.duration - 0.5 * self._period:
            raise CheckpointError(
                f"{path}: expected a checkpoint before the duration of {self.settings.duration:g} s, found one at "
                f"{checkpoint.time:g} s, where the run was over; move it away, or simulate for longer"
            )
        stage.go_on_from(checkpoint)
        self._inbox.begin_again(checkpoint.command)
        self.get_logger().info(f"going on from {path} at {checkpoint.time:.6g} s")

    # --- readiness and diagnostics --------------------------------------------------------------------------------

    @property
    def comes_later(self) -> bool:
        """Whether it is still to be configured."""
        return self._stage is None

    def not_ready(self) -> str:
        """Why the twin cannot be driven yet; empty when it can."""
        if self._stage is None:
            return "the twin is being compiled" if self.settings.autostart else "it is not configured"
        return "" if self._active else "it is not active"

    def health(self) -> Status:
        """Pace, cost, set-points and where they come from."""
        if self._stage is None:
            return Status(self.NAME, Level.OK, self.not_ready())
        stage, desk, keeper = self._stage, self._inbox.desk, self._keeper
        desk.settle_doubts()
        sources = self._inbox.sources()
        values = health_values(self.settings, stage, desk, self._pacer, keeper, sources)
        stage.cost.next_window()
        if len(self.publishers_of(STRING_POSES)) > 1:
            text = f"another simulator publishes {STRING_POSES} in this domain and namespace"
            return Status(self.NAME, Level.ERROR, text, values)
        if not self._active or self._paused:
            return Status(self.NAME, Level.OK, f"{'paused' if self._active else 'inactive'} at {self._at()}", values)
        waiting = self._waits_for_command()
        return Status(self.NAME, *verdict(self.settings, stage, desk, keeper, sources, waiting=waiting), values)


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the simulator."""
    run_node(Simulator, arguments, stop)
