# SPDX-License-Identifier: Apache-2.0
"""The loop of a simulator: commands in, a frame of the twin, the frame out, and the wait until the next one is due."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, ClassVar

from rclpy.context import Context
from rclpy.logging import get_logging_directory

from drill_twin.errors import RunError, StoppedError
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import STRING_POSES
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Pacer, Tick
from drill_twin.ros.core.parameters import Value
from drill_twin.ros.simulator.checkpoint_writer import CheckpointWriter
from drill_twin.ros.simulator.health import health_values, verdict
from drill_twin.ros.simulator.parameters import PARAMETERS

_BURST = 200  # frames; as fast as possible must not be faster than the readers


class Simulation(TwinNode):
    """A twin that moves while it is active, not paused, and has the command it waits for."""

    NAME: ClassVar = "simulator"
    PURPOSE: ClassVar = "Moves the drillstring of a scene under the set-points it receives."
    PARAMETERS: ClassVar = PARAMETERS

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, other_parameters: Sequence[str] = ()
    ) -> None:
        super().__init__(context, values, other_parameters)
        self._keeper = CheckpointWriter()
        self._stage: Any = None
        self._inbox: Any = None
        self._pacer = Pacer(1.0)
        self._period = 1.0
        self._picture: Tick | None = None
        self._keep_due: Tick | None = None
        self._active = self._paused = self._started = self._over = False

    def work(self) -> None:
        """Take one frame, or wait for what it needs."""
        self.spin_once(0.0)
        if self._must_wait():
            self._pacer.restart()
            self.spin_once(0.05)
            return
        self._advance()
        if self.settings.pace == "realtime":
            self._pacer.wait()
        elif self.settings.pace == "fast" and self._stage.frames % _BURST == 0:
            self.topics.flush(1.0)

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
        try:
            self._stage.advance(command, picture=self._picture_due(), exaggeration=self.settings.exaggeration)
        except StoppedError as error:
            self._give_up(command, error)
        if self._keep_due is not None and self._keep_due.due():
            self._keeper.keep(self._checkpoint(), self.settings.checkpoint)

    def _give_up(self, command: Any, error: StoppedError) -> None:
        """Keep the last good state beside the checkpoint, or else in the folder of the logs, and end the node."""
        from drill_twin.monitor.failure_dump import save_failure

        self._keeper.finish()
        beside = self.settings.checkpoint
        home = Path(beside).parent if beside else Path(get_logging_directory())
        name = f"{self.get_name()}_stop_{datetime.now(UTC):%Y%m%dT%H%M%S}_{os.getpid()}"
        raise RunError(f"{error}; {save_failure(home / name, self._stage.twin, command, error)}") from error

    def _picture_due(self) -> bool:
        """In lockstep by simulated time, so that runs are alike; else by the wall clock, for the eyes."""
        if self.settings.pace != "lockstep" or self._picture is None:
            return self._picture is not None and self._picture.due()
        return self._stage.frames % max(round(1.0 / (self._period * self.settings.marker_rate)), 1) == 0

    def on_change(self) -> None:
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
        if self._stage is not None and (self._stage.frame is not None or self._stage.interventions.stopped):
            if self._keep_due is not None:
                self._keeper.keep(self._checkpoint(), self.settings.checkpoint)
                self._keeper.finish()
            if self._keeper.trouble:
                self.get_logger().error(f"no checkpoint: {self._keeper.trouble}")
            self.publish_diagnostics()
            self.topics.flush()
            self.get_logger().info(f"{self._stage.twin.time:.2f} s simulated, {self._stage.cost.text()}")

    # --- readiness and diagnostics --------------------------------------------------------------------------------

    @property
    def topics_pending(self) -> bool:
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
        stage.cost.start_window()
        if len(self.topics.publisher_nodes(STRING_POSES)) > 1:
            text = f"another simulator publishes {STRING_POSES} in this domain and namespace"
            return Status(self.NAME, Level.ERROR, text, values)
        if not self._active or self._paused:
            return Status(self.NAME, Level.OK, f"{'paused' if self._active else 'inactive'} at {self._at()}", values)
        waiting = self._waits_for_command()
        return Status(self.NAME, *verdict(self.settings, stage, desk, keeper, sources, waiting=waiting), values)

    def _at(self) -> str:
        return f"t = {self._stage.twin.time:.6g} s"

    def _checkpoint(self) -> Any:
        from drill_twin.twin.checkpoint import Checkpoint

        return Checkpoint.of(self._stage.twin, self._inbox.desk.good)
