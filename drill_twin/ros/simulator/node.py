# SPDX-License-Identifier: Apache-2.0
"""The simulator node: set-points in, motion of the string out, in real time, as fast as possible, or in lockstep.

Each turn of its loop advances the twin by a frame (compiled, with the GIL released), publishes the frame, and processes
the commands and service calls that come until the next one is due. Simulated time starts at 0 with the first good
command, or at the time of a checkpoint.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

from rclpy.context import Context

from drill_twin.core.errors import RunStopped
from drill_twin.dynamics.solver.slices import checked
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import COMMANDER, RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.ros.core.diagnostics_publisher import STANDS_STILL
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import Rights
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics import relative
from drill_twin.ros.simulator.command_limits import FASTEST
from drill_twin.ros.simulator.start_up import CheckpointPlaces, StartUp

if TYPE_CHECKING:
    from drill_twin.ros.simulator.run_control import RunControl


class Simulator(TwinNode):
    """Moves the string of a scene under the commands it receives."""

    NAME = "simulator"
    PURPOSE = "Moves the drillstring of a scene under the set-points it receives."
    PARAMETERS = (
        SCENE,
        OVERRIDES,
        Parameter(
            "pace",
            "realtime",
            "realtime: frames at their wall-clock times; fast: as fast as possible; lockstep: each frame waits for the "
            "command stamped for it, so that a run is repeatable",
            choices=("realtime", "fast", "lockstep"),
        ),
        Parameter("frame_rate", 0.0, "published frames per simulated second; 0: as the scene says", "Hz", 0.0, 1000.0),
        Parameter(
            "accuracy",
            "",
            'largest error before the onset: chooses elements and step (docs/accuracy.md); "": as the scene says',
            such_as="1 %",
        ),
        Parameter("duration", 0.0, "simulated time after which the node ends; 0: runs until stopped", "s", 0.0, 1e6),
        Parameter(
            "frame_prefix",
            "",
            "put before the names of the frames of messages and tf, for twins that share a tf tree",
            such_as="rig2/",
        ),
        AUTOSTART,
        Parameter("wait_for_command", True, "whether simulated time stands still until the first good command"),
        Parameter(
            "command_timeout", 1.0, "wall time without a command that counts as silence", "s", 0.05, 3600.0, live=True
        ),
        Parameter(
            "on_silence",
            "ramp_if_lost",
            "what follows silence: hold the last set-point; ramp to the safe one; or ramp_if_lost: ramp where the "
            "source sent at a rate on /rig/command, hold what was sent once",
            choices=("ramp_if_lost", "hold", "ramp"),
            live=True,
        ),
        Parameter("safe_weight_on_bit", 0.0, "weight on bit of the safe set-point", "N", -1e7, 1e7, live=True),
        Parameter("safe_speed", 0.0, "top-drive speed of the safe set-point", "rad/s", -FASTEST, FASTEST, live=True),
        Parameter(
            "safe_ramp_time",
            5.0,
            "time of the ramp to the safe set-point and back, simulated",
            "s",
            0.0,
            3600.0,
            live=True,
        ),
        Parameter(
            "max_weight_on_bit",
            0.0,
            "larger commands are refused; 0: ten times the scene's largest",
            "N",
            0.0,
            1e8,
            live=True,
        ),
        Parameter(
            "max_speed",
            0.0,
            "faster commands are refused; 0: ten times the scene's fastest",
            "rad/s",
            0.0,
            FASTEST,
            live=True,
        ),
        Parameter("negative_commands", False, "whether tension and left-hand rotation may be commanded", live=True),
        Parameter("step_frames", 1, "frames that one call of ~/step takes while paused", "", 1, 100000, live=True),
        Parameter(
            "checkpoint",
            "",
            "file to keep the state in (.npz); where it exists when the node starts, the run goes on from it; a change "
            'stays in the folders named at the start; "": none',
            live=True,
        ),
        Parameter(
            "checkpoint_period",
            5.0,
            "wall time between checkpoints; 0: by ~/save_checkpoint only",
            "s",
            0.0,
            86400.0,
            live=True,
        ),
        Parameter(
            "saved_checkpoint",
            "",
            "file (.npz) that ~/save_checkpoint writes, nothing else overwrites and ~/load_checkpoint reads; "
            '"": the file of checkpoint with _saved after its name',
            live=True,
        ),
        Parameter(
            "marker_rate",
            25.0,
            "pictures for RViz and Foxglove and tf, per second of wall time",
            "Hz",
            0.0,
            100.0,
            live=True,
        ),
        Parameter(
            "exaggeration",
            0.0,
            "factor by which the picture widens lateral motion; 0: chosen by size",
            "",
            0.0,
            10000.0,
            live=True,
        ),
    )
    RIGHTS = Rights(
        (RIG_COMMAND, RPS_COMMAND, WOB_COMMAND),
        tuple(
            f"~/{name}"
            for name in (
                *("pause", "resume", "step", "reset", "save_checkpoint", "load_checkpoint"),
                *("get_simulation_state", "set_simulation_state", "step_simulation", "reset_simulation"),
                "get_simulator_features",
            )
        ),
    )
    _control: RunControl
    """Control of the run; made by `configure`."""
    _told = ""

    def __init__(self, context: Context, others: Iterable[str] = ()) -> None:
        super().__init__(context, others)
        self._start_up, self._places = StartUp(self), CheckpointPlaces(self.settings)

    # --- life cycle -----------------------------------------------------------------------------------------------

    def configure(self) -> None:
        """Compile and build the twin; create its publishers, the subscriptions to commands, and the services."""
        settings, start = self.settings, self._start_up
        scene = start.compiled_scene()
        from drill_twin.ros.simulator.run_control import RunControl, offer  # it takes long too
        from drill_twin.ros.simulator.simulation import SimulatorRun
        from drill_twin.runs.loop import topics_of

        rate = settings.frame_rate or scene.numerics.frame_rate
        # Before its own topics are there: a simulator that runs would report a second publisher.
        start.refuse_second_simulator(own=0)
        for topic in (*topics_of(scene), COMMANDER):
            self.topics.advertise(topic)
        self._control = RunControl(SimulatorRun(self, scene, rate, self._places), self)
        run = self._control.simulation
        start.refuse_second_simulator(own=1)
        if settings.checkpoint and Path(settings.checkpoint).exists():
            run.resume(self._places.file(settings.checkpoint))
        run.loop.announce()
        arbiter = run.commands
        self.topics.subscribe_raw(RIG_COMMAND, arbiter.message)
        for topic, received in ((WOB_COMMAND, arbiter.weight_on_bit), (RPS_COMMAND, arbiter.speed)):
            self.topics.subscribe(topic, received, malformed=arbiter.malformed)
        run.apply_settings()
        offer(self, self._control)
        twin = run.loop.twin
        self.get_logger().info(
            f"{scene.name}: {twin.elements} elements, {twin.step_size * 1e6:.0f} us steps, {rate:g} frames/s, "
            f"{settings.pace}"
        )
        if run.waits_for_command:
            names = (RIG_COMMAND,) if settings.pace == "lockstep" else (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND)
            topics = ", ".join(self.resolve_topic_name(relative(name)) for name in names)
            self.get_logger().info(f"time stands still until a command comes on {topics}")

    def activate(self) -> None:
        """Let time run from here."""
        self._control.simulation.stand_still(paused=True)

    def deactivate(self) -> None:
        """Let time stand still, in the middle of a step too."""
        self._control.end_steps("it was deactivated")

    def complete(self) -> None:
        """Write the last checkpoint, wait until the readers have received everything, and drop the twin."""
        if self._is_built:
            self._control.end_steps("it was asked to end")
            self._control.simulation.close()

    # --- the loop -------------------------------------------------------------------------------------------------

    def run(self, stop: StopRequest) -> None:
        """Work until the run is over or asked to stop, also in the middle of a frame."""

        def check() -> None:
            if stop:
                raise RunStopped

        with checked(check), suppress(RunStopped):
            super().run(stop)

    def step(self) -> None:
        """Advance by a frame, or wait for what the run needs."""
        control, run = self._control, self._control.simulation
        run.tell_commander()
        if (state := control.state_text) != self._told:
            self._told = state
            if state in STANDS_STILL:  # told at once, before the readers of this node miss its frames
                self.publish_diagnostics()
        if control.runs:
            run.advance()
            control.frame_taken()
            run.keep_pace(steps=control.steps > 0)
        else:
            run.stand_still(paused=control.paused)
            self.spin_once(0.05)

    @property
    def _is_built(self) -> bool:
        """True from the time on at which `configure` has built the twin."""
        return hasattr(self, "_control")

    @property
    def finished(self) -> bool:
        """True once the wanted duration has been simulated."""
        return self._control.simulation.complete

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse a checkpoint outside the folders named at the start, and a safe set-point beyond the limits."""
        if self._is_built:
            self._control.simulation.commands.limits_of(settings)
        for path in filter(None, (settings.checkpoint, settings.saved_checkpoint)):
            self._places.file(path)

    def on_change(self) -> None:
        """Apply a live parameter."""
        if self._is_built:
            self._control.simulation.apply_settings()
            self.publish_diagnostics()  # the gateway takes the limits from them

    # --- readiness and diagnostics --------------------------------------------------------------------------------

    def not_ready(self) -> str:
        """Reason why the twin cannot be driven yet; empty when it can."""
        return self._start_up.progress or ("" if self._is_built else "it is being configured")

    def health(self) -> Status:
        """Pace, cost, set-points and their sources."""
        if not self._is_built:
            return Status(self.NAME, Level.OK, self.not_ready(), {"compiling": self._start_up.progress})
        from drill_twin.ros.simulator.health import health

        return health(self, self._control)
