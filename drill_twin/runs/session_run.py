# SPDX-License-Identifier: Apache-2.0
"""One run of a session, some frames at a time: what driver, simulator and analyzer send, recorded as it goes."""

import math
import time
from collections.abc import Callable, Sequence
from itertools import takewhile
from typing import Protocol

from drill_twin.core.errors import MessageError
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.rig_messages import DRIVER, CommandEncoder
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import COMMANDER, DIAGNOSTICS, MARKS_STATE, RIG_COMMAND
from drill_twin.io.samples import SampleRows
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.runs.loop import RunLoop
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command
from drill_twin.whirl import Findings

MARKER_RATE = 25.0
"""Messages on `/string/markers` per simulated second."""
BLOCK_SECONDS = 0.05
"""Time by the clock after which the frames computed so far are recorded [s]."""
SetPoints = Callable[[float], Command]
"""Set-points at a time [s]."""
Recorded = tuple[str, int, bytes]
"""Topic, stamp [ns] and CDR bytes of a message."""


class MessageSink(Protocol):
    """Takes the messages of a session: a bag writer, or `drill_twin.io.bag.virtual_bags.MemoryBag`."""

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record the CDR bytes of a message at a stamp [ns]."""

    def write_all(self, messages: Sequence[Recorded]) -> None:
        """Record messages one after the other."""


class SessionRun:
    """One run, some frames at a time, recorded as it goes.

    Attributes:
        loop: The run loop with the twin.
        pipeline: The whirl analysis.
    """

    def __init__(self, scene: Scene, recorder: MessageSink) -> None:
        """Compile what the scene calls for, and announce the run.

        Args:
            scene: The scene.
            recorder: Takes the messages.
        """
        self._recorder = recorder
        self._period = scene.numerics.frame_period_ns
        self.pipeline = WhirlPipeline()
        self.loop = RunLoop(scene, seconds(self._period), self._record)
        self.command = self.loop.first
        """Set-points in force."""
        self._commands = CommandEncoder()
        self._frame_id = self.loop.geometry.frame_id
        self.motion_seconds = 0.0
        """Processor time of computing the motion so far [s]."""
        self.last: Frames | None = None
        """The last frame; views that hold until the next call of `advance`."""
        self._quick = 1  # frames in BLOCK_SECONDS
        self._markers_due = 0
        self._diagnostics_due = NANOSECONDS
        self.loop.announce()
        for commander in ("", DRIVER):  # as the simulator: nobody, until the first command
            self._record(COMMANDER, encode_string(commander))

    @property
    def stamp(self) -> int:
        """Simulated time [ns]."""
        return self.loop.frames * self._period

    @property
    def findings(self) -> Findings | None:
        """The latest findings."""
        return self.pipeline.findings

    @property
    def most_frames(self) -> int:
        """Most frames of the next `advance`: up to the next diagnostics, and some `BLOCK_SECONDS` by the clock."""
        until = -(-(self._diagnostics_due - self.stamp) // self._period)
        return max(1, min(until, self.loop.most_frames, self._quick))

    def advance(self, commands: Sequence[Command]) -> None:
        """Advance by frames, `most_frames` at most, at whose ends the commands hold.

        Raises:
            RunError: The motion could not be followed; the frames before are recorded.
            MessageError: A set-point or a result is not a finite number; the frames before are recorded.
        """
        began, start = time.perf_counter(), self.stamp
        sound = sum(1 for _ in takewhile(Command.is_finite, commands))
        busy = time.thread_time()
        frames, error = self.loop.fill(commands[:sound])
        self.motion_seconds += time.thread_time() - busy
        filled, count = time.perf_counter(), len(frames.time)
        self._write(start, commands[:count], frames)
        self.loop.count(frames, time.perf_counter() - filled)
        if count:
            self.last = frames.part(slice(-1, None))
        if error is not None and not isinstance(error, Exception):  # a request to stop is no fault of the next command
            raise error
        if count < len(commands):  # what the driver sent before it failed
            after, self.command = self.stamp + self._period, commands[count]
            self._recorder.write(RIG_COMMAND, self.stamp, self._commands.command(after, self.command))
        if error is not None:
            raise error
        self._quick = max(1, int(BLOCK_SECONDS * count / (time.perf_counter() - began)))
        if self.stamp >= self._diagnostics_due:
            self._diagnostics_due += NANOSECONDS
            self.report_diagnostics()

    def follow(self, set_points: SetPoints, frames: int) -> None:
        """As `advance`, under set-points by the end of a frame [s]; records the frames before a failing set-point."""
        commands: list[Command] = []
        try:
            for frame in range(1, frames + 1):
                end = seconds(self.stamp + frame * self._period)
                commands.append(set_points(end))
        except BaseException:
            if commands:
                self.advance(commands)
            raise
        self.advance(commands)

    def _write(self, start: int, commands: Sequence[Command], frames: Frames) -> None:
        """Record frames from a stamp [ns] on: what driver, simulator and analyzer send."""
        stamps = [start + k * self._period for k in range(1, len(commands) + 1)]
        if not stamps:
            return
        markers_due = self._markers_due
        try:
            messages = self.loop.messages(frames, self._markers_at(stamps))
        except MessageError:
            if len(stamps) == 1:
                raise
            half, self._markers_due = len(stamps) // 2, markers_due
            self._write(start, commands[:half], frames.part(slice(half)))
            self._write(stamps[half - 1], commands[half:], frames.part(slice(half, None)))
            return
        findings = self.pipeline.analyse_samples(SampleRows.of(stamps, frames, self._frame_id))
        batch: list[Recorded] = []
        for row, (stamp, raw) in enumerate(zip(stamps, self._commands.commands(stamps, commands), strict=True)):
            batch.append((RIG_COMMAND, stamp - self._period, raw))  # the driver sends it before the frame
            for topic, sent in messages[row]:
                batch.append((topic, stamp, sent))
                if findings is None or topic == MARKS_STATE:
                    found = self.pipeline.analyse(topic, sent) if findings is None else findings[row]
                    batch += [(name, stamp, message) for name, message in found]
        self._recorder.write_all(batch)
        self.command = commands[-1]

    def _record(self, topic: str, raw: bytes) -> None:
        """Record a message, and the findings of the analysis from it."""
        self._recorder.write(topic, self.stamp, raw)
        for found, message in self.pipeline.analyse(topic, raw):
            self._recorder.write(found, self.stamp, message)

    def _markers_at(self, stamps: Sequence[int]) -> list[int]:
        """Numbers of the frames, by their stamps [ns], for which markers are due."""
        rows = []
        for row, stamp in enumerate(stamps):
            if stamp >= self._markers_due:
                self._markers_due = stamp + round(NANOSECONDS / MARKER_RATE)
                rows.append(row)
        return rows

    def report_diagnostics(self) -> None:
        """Record the diagnostics of simulator and analyzer, as the nodes publish them each second."""
        quality = self.pipeline.summary().quality
        simulator = {
            "pace": "fast",
            **self.loop.diagnostics(),
            "weight_on_bit": f"{self.command.weight_on_bit:g}",
            "speed_rev_s": f"{self.command.rotation / math.tau:g}",
        }
        level, severity = self.pipeline.encoder.severity if self.pipeline.encoder else (Level.OK, "unknown")
        analyzer = {"samples": str(quality.accepted), "malformed": str(self.pipeline.malformed), "severity": severity}
        motion = self.findings.motion.value if self.findings else "unknown"
        statuses = [
            Status("simulator", *self.loop.verdict(), simulator),
            Status("analyzer", level, f"motion: {motion}", analyzer),
        ]
        self._recorder.write(DIAGNOSTICS, self.stamp, encode_diagnostics(self.stamp, statuses))
