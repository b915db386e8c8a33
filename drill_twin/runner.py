# SPDX-License-Identifier: Apache-2.0
"""One run without ROS: schedule, twin, analysis and bag in one process.

It sends itself what rig driver, simulator and analyzer send each other in lockstep, as the same bytes on the same
topics, so a bag does not tell who made it. The messages are stamped and recorded in simulated time.

>>> session = Session(load_scene("pa6_bench"))
>>> outcome = session.run("out/bag_0")
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drill_twin.errors import RunError, StoppedError
from drill_twin.io.adapters import describe_run, string_geometry
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import CommandEncoder, TwinEncoder, encode_string
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    STRING_MARKERS,
    STRING_POSES,
    TWIN_SCENE,
    WOB_COMMAND,
)
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.monitor.drilling_progress import DrillingProgress
from drill_twin.monitor.failure_dump import save_failure
from drill_twin.monitor.missing_effects import MissingEffects
from drill_twin.monitor.rejected_steps import RejectedSteps
from drill_twin.monitor.run_timing import RunTiming
from drill_twin.scene import Scene
from drill_twin.schedule import Command, Schedule
from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin
from drill_twin.whirl import Findings, Summary

PICTURES = 25.0
"""Pictures for RViz and Foxglove, per simulated second."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended."""

    bag: Path
    """Folder of the bag."""
    simulated: float
    """Simulated time [s]."""
    finished: bool
    """Whether it ran to its end; False when it was stopped."""
    wall_seconds: float
    """Wall-clock time of the run, compiling left out [s]."""
    summary: Summary
    """What the analysis found."""


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    simulated: float
    """Simulated time [s]."""
    duration: float
    """Simulated time at its end [s]."""
    findings: Findings | None
    """The latest findings about whirl."""
    realtime_factor: float
    """Simulated time over the time the physics took."""


def _ignore(progress: Progress) -> None:
    """Nobody watches."""


class Session:
    """A scene made ready to run: the schedule is read and the kernel compiled, nothing is written yet."""

    def __init__(self, scene: Scene, schedule: Schedule | None = None) -> None:
        """Takes up to half a minute the first time a set of effects is compiled.

        Args:
            scene: What to simulate.
            schedule: Set-points, if they are not to be made from the scene.

        Raises:
            TableError: The record that the scene plays cannot be played.
        """
        self.scene = scene
        self.schedule = schedule or Schedule.from_scene(scene)
        self._period = round(NANOSECONDS / scene.numerics.frame_rate)
        self._first = Command(*scene.rig.first)
        # A first frame of another twin compiles the kernel, so that the run's cost does not contain it.
        Twin(scene).advance(self._first, seconds(self._period))

    def run(
        self,
        folder: str | Path,
        *,
        progress: Callable[[Progress], None] = _ignore,
        stop: Callable[[], bool] = lambda: False,
    ) -> Outcome:
        """Run to the end of the scene, or until `stop()`, and record everything; the bag is closed in any case.

        Args:
            folder: New folder of the bag.
            progress: Called after every frame.
            stop: Asked before every frame.

        Raises:
            BagError: The folder exists or cannot be written.
            RunError: The motion could not be followed to the end; the bag holds what came before, and the folder
                with `_stop` behind its name the last good state.
        """
        began = time.monotonic()
        frames = max(1, math.ceil(self.schedule.duration * NANOSECONDS / self._period - 0.5))
        with BagWriter(folder) as bag:
            run = _Run(self.scene, bag, self._first)
            done = 0
            try:
                while done < frames and not stop():
                    done += 1
                    stamp = done * self._period
                    run.advance(stamp, self.schedule.at(seconds(stamp)), seconds(self._period))
                    progress(Progress(seconds(stamp), seconds(frames * self._period), run.findings, run.factor))
            except RunError as error:
                kept = run.give_up(error)
                text = f"{error}; what came before is recorded in {bag.folder}{kept}"
                raise (error.with_message(text) if isinstance(error, StoppedError) else RunError(text)) from error
            run.report_health()
        return Outcome(
            bag.folder, seconds(done * self._period), done == frames, time.monotonic() - began, run.pipeline.summary()
        )


class _Run:
    """The state of one run, and what is written about it."""

    def __init__(self, scene: Scene, bag: BagWriter, first: Command) -> None:
        self.pipeline = WhirlPipeline()
        self._bag = bag
        self._twin = Twin(scene)
        self._encoder = TwinEncoder(string_geometry(self._twin))
        self._commands = CommandEncoder()
        self._command = first
        self._cost = RunTiming()
        self._drilled = DrillingProgress(self._twin)
        self._omissions = MissingEffects(scene)
        self._interventions = RejectedSteps()
        self._stamp = self._frames = 0
        self._echo_due = self._picture_due = 0
        self._health_due = NANOSECONDS
        self._say(TWIN_SCENE, encode_string(describe_run(self._twin)))
        self._say(CLOCK_TOPIC, self._encoder.clock(0.0))

    @property
    def findings(self) -> Findings | None:
        """The latest findings."""
        return self.pipeline.findings

    @property
    def factor(self) -> float:
        """Simulated time over the time the physics took."""
        return self._cost.realtime_factor

    def advance(self, stamp: int, command: Command, duration: float) -> None:
        """Go on to a stamp [ns], where the command holds."""
        self._send(stamp, command)
        begin = time.perf_counter()
        frame = self._twin.advance(command, duration)
        stepped = time.perf_counter()
        self._stamp = stamp
        self._frames += 1
        self._publish(frame)
        self._cost.update(duration, stepped - begin, time.perf_counter() - stepped, frame)
        self._omissions.update(frame)
        self._interventions.update(frame)
        if stamp >= self._health_due:
            self._health_due += NANOSECONDS
            self.report_health()

    def _send(self, stamp: int, command: Command) -> None:
        """What the rig driver sends."""
        self._say(RIG_COMMAND, self._commands.command(stamp, command))
        if command != self._command or stamp >= self._echo_due:
            self._echo_due = stamp + NANOSECONDS
            self._say(WOB_COMMAND, self._commands.wob_command(command))
            self._say(RPS_COMMAND, self._commands.rps_command(command))
        self._command = command

    def _publish(self, frame: Frame) -> None:
        """What the simulator publishes."""
        self._say(RIG_STATE, self._encoder.rig_state(frame))
        self._say(MARKS_STATE, self._encoder.marks(frame))
        self._say(STRING_POSES, self._encoder.poses(frame))
        if self._stamp >= self._picture_due:
            self._picture_due = self._stamp + round(NANOSECONDS / PICTURES)
            self._say(STRING_MARKERS, self._encoder.markers(frame))
        self._say(CLOCK_TOPIC, self._encoder.clock(frame.time))

    def _say(self, topic: str, raw: bytes) -> None:
        """Record a message, and what the analysis finds in it."""
        self._bag.write(topic, self._stamp, raw)
        for found, message in self.pipeline.take(topic, raw):
            self._bag.write(found, self._stamp, message)

    def report_health(self) -> None:
        """Write how the run is going, as the simulator and the analyzer do each second."""
        pipeline = self.pipeline
        quality = pipeline.summary().quality
        simulator = {
            "pace": "fast",
            "simulated_time": f"{self._twin.time:.6f}",
            "frames": str(self._frames),
            **self._cost.values(),
            **self._drilled.values(),
            "elements": str(self._twin.elements),
            "step_s": repr(float(self._twin.step_size)),
            "weight_on_bit": f"{self._command.weight_on_bit:g}",
            "speed_rev_s": f"{self._command.rotation / math.tau:g}",
            **self._omissions.values(),
            **self._interventions.values(),
        }
        analyzer = {"samples": str(quality.accepted), "malformed": str(pipeline.malformed)}
        motion = self.findings.motion.value if self.findings else "unknown"
        statuses = [
            Status("simulator", *self._verdict(), simulator),
            Status("analyzer", Level.OK, f"motion: {motion}", analyzer),
        ]
        self._cost.start_window()
        self._bag.write(DIAGNOSTICS, self._stamp, encode_diagnostics(self._stamp, statuses))

    def _verdict(self) -> tuple[Level, str]:
        guard, missing = self._interventions, self._omissions.found
        if guard.stopped:
            return Level.ERROR, guard.stopped
        if guard.last:
            return Level.WARN, guard.last
        return (Level.WARN, missing[-1]) if missing else (Level.OK, self._cost.text())

    def give_up(self, error: RunError) -> str:
        """The run cannot go on: say so in the bag and keep the last good state; returns where, in words."""
        self._interventions.stopped = str(error)
        self.report_health()
        if not isinstance(error, StoppedError):
            return ""
        folder = self._bag.folder.with_name(f"{self._bag.folder.name}_stop")
        return f"; {save_failure(folder, self._twin, self._command, error)}"
