# SPDX-License-Identifier: Apache-2.0
"""A run without ROS: schedule, twin and whirl analysis in one process, recorded in a bag or in memory.

The session sends what rig driver, simulator and analyzer send each other in lockstep, as the same bytes on the same
topics, so its recordings equal theirs. Messages are stamped and recorded in simulated time.

>>> session = Session(load_scene("pa6_bench"))
>>> outcome = session.run("out/bag_0")
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from drill_twin.errors import RunError, StoppedError
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import DIAGNOSTICS, OF_EVERY_RUN, RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.monitor.failure_dump import save_failure
from drill_twin.runner.compilation import compile_kernel
from drill_twin.runner.loop import RunLoop, topics_of
from drill_twin.scene import Scene
from drill_twin.schedule import Command, Schedule
from drill_twin.twin.frame import Frame
from drill_twin.whirl import Findings, Summary

MARKER_RATE = 25.0
"""Messages on `/string/markers` per simulated second."""


class Recorder(Protocol):
    """Takes the messages of a session: a bag writer, or `drill_twin.io.bag.memory.MemoryBag`."""

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record the CDR bytes of a message at a stamp [ns]."""


@dataclass(frozen=True)
class Outcome:
    """The end of a run."""

    bag: Path
    """Folder of the bag."""
    simulated: float
    """Simulated time [s]."""
    finished: bool
    """True for a run that went on to its end, False for one that was stopped."""
    wall_seconds: float
    """Wall-clock time of the run without compiling [s]."""
    summary: Summary
    """Findings of the analysis."""


@dataclass(frozen=True)
class Progress:
    """State of a run after a frame."""

    simulated: float
    """Simulated time [s]."""
    duration: float
    """Simulated time at its end [s]."""
    findings: Findings | None
    """The latest findings about whirl."""
    realtime_factor: float
    """Simulated over wall time so far."""


class Run:
    """One run, a frame at a time, recorded as it goes.

    Attributes:
        loop: The run loop with the twin.
        pipeline: The whirl analysis.
    """

    def __init__(self, scene: Scene, recorder: Recorder) -> None:
        """Compile what the scene calls for, and announce the run.

        Args:
            scene: The scene.
            recorder: Takes the messages.
        """
        self._recorder = recorder
        self._period = round(NANOSECONDS / scene.numerics.frame_rate)
        self.pipeline = WhirlPipeline()
        self.loop = RunLoop(scene, seconds(self._period), self._record)
        self.command = self.loop.first
        """Set-points in force."""
        self._commands = CommandEncoder()
        self._echo_due = self._markers_due = 0
        self._diagnostics_due = NANOSECONDS
        self.loop.announce()

    @property
    def stamp(self) -> int:
        """Simulated time [ns]."""
        return self.loop.frames * self._period

    @property
    def findings(self) -> Findings | None:
        """The latest findings."""
        return self.pipeline.findings

    def advance(self, command: Command) -> Frame:
        """Advance by a frame, at whose end the command holds.

        Raises:
            RunError: The motion could not be followed.
        """
        stamp = self.stamp + self._period
        self._send(stamp, command)
        markers = stamp >= self._markers_due
        frame = self.loop.advance(command, markers=markers)
        if markers:
            self._markers_due = stamp + round(NANOSECONDS / MARKER_RATE)
        if stamp >= self._diagnostics_due:
            self._diagnostics_due += NANOSECONDS
            self.report_diagnostics()
        return frame

    def _send(self, stamp: int, command: Command) -> None:
        """Record what the rig driver sends: the command, and its echo as single values on change and once a second."""
        self._record(RIG_COMMAND, self._commands.command(stamp, command))
        if command != self.command or stamp >= self._echo_due:
            self._echo_due = stamp + NANOSECONDS
            self._record(WOB_COMMAND, self._commands.wob_command(command))
            self._record(RPS_COMMAND, self._commands.rps_command(command))
        self.command = command

    def _record(self, topic: str, raw: bytes) -> None:
        """Record a message, and what the analysis finds in it."""
        self._recorder.write(topic, self.stamp, raw)
        for found, message in self.pipeline.take(topic, raw):
            self._recorder.write(found, self.stamp, message)

    def report_diagnostics(self) -> None:
        """Record the diagnostics of simulator and analyzer, as the nodes publish them each second."""
        quality = self.pipeline.summary().quality
        simulator = {
            "pace": "fast",
            **self.loop.diagnostics(),
            "weight_on_bit": f"{self.command.weight_on_bit:g}",
            "speed_rev_s": f"{self.command.rotation / math.tau:g}",
        }
        analyzer = {"samples": str(quality.accepted), "malformed": str(self.pipeline.malformed)}
        motion = self.findings.motion.value if self.findings else "unknown"
        statuses = [
            Status("simulator", *self.loop.verdict(), simulator),
            Status("analyzer", Level.OK, f"motion: {motion}", analyzer),
        ]
        self._recorder.write(DIAGNOSTICS, self.stamp, encode_diagnostics(self.stamp, statuses))


class Session:
    """A scene made ready to run: the schedule is read and the kernel compiled, nothing is written yet."""

    def __init__(
        self,
        scene: Scene,
        schedule: Schedule | None = None,
        compiling: Callable[[str], None] | None = None,
    ) -> None:
        """Compile the effects of the scene, which takes up to half a minute the first time.

        Args:
            scene: The scene.
            schedule: Set-points, if they are not to be made from the scene.
            compiling: Called with the progress of a compilation, as by `compile_kernel`; may raise to end it.

        Raises:
            TableError: The record that the scene plays cannot be played.
        """
        self.scene = scene
        self.schedule = schedule or Schedule.from_scene(scene)
        self._period = round(NANOSECONDS / scene.numerics.frame_rate)
        compile_kernel(scene, seconds(self._period), compiling, analysis=True)

    def run(
        self,
        folder: str | Path,
        *,
        progress: Callable[[Progress], None] | None = None,
        stop: Callable[[], bool] = lambda: False,
    ) -> Outcome:
        """Run to the end of the scene, or until `stop()`, and record everything; the bag is closed in any case.

        Args:
            folder: New folder of the bag.
            progress: Called after every frame.
            stop: Called before every frame.

        Raises:
            BagError: The folder exists or cannot be written.
            RunError: The motion could not be followed to the end; the bag holds what came before, and the folder
                with `_stop` behind its name the last good state.
        """
        began = time.monotonic()
        frames = max(1, math.ceil(self.schedule.duration * NANOSECONDS / self._period - 0.5))
        with BagWriter(folder, topics=dict.fromkeys((*OF_EVERY_RUN, *topics_of(self.scene)))) as bag:
            run = Run(self.scene, bag)
            try:
                while run.loop.frames < frames and not stop():
                    run.advance(self.schedule.at(seconds(run.stamp + self._period)))
                    if progress is not None:
                        factor = run.loop.timing.realtime_factor
                        progress(Progress(seconds(run.stamp), seconds(frames * self._period), run.findings, factor))
            except RunError as error:
                run.report_diagnostics()
                text = f"{error}; what came before is recorded in {bag.folder}{_saved(run, bag.folder, error)}"
                raise (error.with_message(text) if isinstance(error, StoppedError) else RunError(text)) from error
            run.report_diagnostics()
        wall = time.monotonic() - began
        return Outcome(bag.folder, seconds(run.stamp), run.loop.frames == frames, wall, run.pipeline.summary())


def _saved(run: Run, bag: Path, error: RunError) -> str:
    """Save the last good state beside the bag; returns where, in words."""
    if not isinstance(error, StoppedError):
        return ""
    folder = bag.with_name(f"{bag.name}_stop")
    return f"; {save_failure(folder, run.loop.twin, run.command, error)}"
