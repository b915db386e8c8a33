# SPDX-License-Identifier: Apache-2.0
"""The run loop: advance the twin by frames, encode them, count their cost, diagnose them.

A session without ROS and the simulator node both drive this loop; they differ in the sink that takes the messages (a
bag, memory, DDS) and in what decides when the next frame is due.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from drill_twin.core.errors import RunError
from drill_twin.dynamics.discretisation.notes import notes_on
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.frame import Frame, Frames
from drill_twin.dynamics.twin.frame_record import Record, frame_of
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.drawing.geometry import StringGeometry
from drill_twin.io.messages.encode import TwinEncoder, encode_float64, encode_string
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    MARKS_STATE,
    REALTIME_FACTOR,
    RIG_STATE,
    STRING_MARKERS,
    STRING_POSES,
    STRING_STRESS,
    TWIN_SCENE,
)
from drill_twin.io.run_messages import Measurements, describe_run, sensor_topics
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.runs.monitor import NOTES, SEPARATOR, MissingEffects, RejectedSteps, RunTiming
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

TOPICS = (RIG_STATE, STRING_POSES, MARKS_STATE, STRING_MARKERS, TWIN_SCENE, REALTIME_FACTOR, CLOCK_TOPIC)
"""Topics that the loop sends in every run."""


def topics_of(scene: Scene) -> tuple[str, ...]:
    """Topics that the loop sends in a run of a scene."""
    stress = () if scene.effects.fatigue is None else (STRING_STRESS,)
    return TOPICS + sensor_topics(scene) + stress


MOST_FRAMES = 256
"""Most frames that are computed in one compiled call."""
_MOST_BYTES = 16 * 1024 * 1024

Message = tuple[str, bytes]
"""Topic and CDR bytes."""
Sink = Callable[[str, bytes], None]
"""Takes a topic and the CDR bytes of a message."""


class RunLoop:
    """Advances the twin of a scene and sends its frames to a sink.

    Attributes:
        scene: The scene.
        period: Simulated time of a frame [s].
        twin: The twin.
        frames: Number of frames since the start of the run.
        timing: Cost of the run.
        missing_effects: Effects that the run called for and the scene leaves out.
        rejected_steps: Frames that the step guard rejected, and why the run was stopped.
    """

    def __init__(self, scene: Scene, period: float, sink: Sink, *, pace: str = "fast", frame_prefix: str = "") -> None:
        """Build the twin; compiles its kernel where `drill_twin.runs.compile_kernel` has not.

        Args:
            scene: The scene.
            period: Simulated time of a frame [s].
            sink: Takes the messages.
            pace: realtime, fast or lockstep, for the description of the run.
            frame_prefix: Put before the names of the frames of messages and tf.

        Raises:
            DrillTwinError: The scene cannot be run (as `Twin`).
        """
        self.scene, self.period = scene, period
        self._sink, self._pace = sink, pace
        self._frame_prefix = frame_prefix
        self.first = Command(*scene.rig.first)
        """Set-points at the start."""
        self.timing = RunTiming()
        self.notes = notes_on(scene)
        """Sentences on the scene's resolution and drag."""
        self._begin(Twin(scene))
        self._encoder = TwinEncoder(self.geometry)

    def _begin(self, twin: Twin) -> None:
        self.twin = twin
        twin.load()
        self._single = twin.record(1)
        self.__dict__.pop("_record", None)  # the record of an earlier twin
        self.frames = 0
        self.missing_effects = MissingEffects(self.scene, twin.rod)
        self.rejected_steps = RejectedSteps()
        self._measurements = Measurements(twin, self._frame_prefix) if self.scene.sensors is not None else None

    @property
    def geometry(self) -> StringGeometry:
        """Sizes of string and hole for markers and tf."""
        return replace(string_geometry(self.twin.scene, self.twin.rod.arc), frame_prefix=self._frame_prefix)

    def announce(self) -> None:
        """Send the description of the run and its time, at the start of a run or after a checkpoint was resumed."""
        self._sink(TWIN_SCENE, encode_string(describe_run(self.twin, self._pace)))
        self.tell_time()

    def tell_time(self) -> None:
        """Send the simulated time."""
        self._sink(CLOCK_TOPIC, *self._encoder.clock(np.array([self.twin.time])))

    def reset(self) -> None:
        """Start a new run at time zero."""
        self._begin(Twin(self.scene))
        self.announce()

    def resume(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint.

        Raises:
            CheckpointError: The checkpoint is of another scene.
        """
        checkpoint.restore(self.twin)
        self.rejected_steps = RejectedSteps()
        if self._measurements is not None:
            self._measurements = Measurements(self.twin, self._frame_prefix)
        self.frames = round(self.twin.time / self.period)

    def advance(
        self,
        command: Command,
        *,
        markers: bool = False,
        exaggeration: float | None = None,
        also: Callable[[Frame], None] | None = None,
    ) -> None:
        """Advance by a frame and send it.

        Args:
            command: Set-points at the end of the frame.
            markers: Whether `/string/markers` is due.
            exaggeration: Factor of lateral motion in them; the default where None.
            also: Called with the frame before `/clock` is sent.

        Raises:
            RunError: The motion could not be followed; the twin is back at the last good frame.
        """
        frames, error = self.fill([command], self._single)
        if error is not None:
            raise error
        advanced = time.perf_counter()
        (messages,) = self.messages(frames, [0] if markers else [], exaggeration)
        for topic, raw in messages[:-1]:
            self._sink(topic, raw)
        if also is not None:
            also(frame_of(self._single.table[0], self._single.kind, frames.stats.wall_seconds, None, frames.energy))
        self._sink(*messages[-1])
        self.count(frames, time.perf_counter() - advanced)

    def fill(self, commands: Sequence[Command], record: Record | None = None) -> tuple[Frames, BaseException | None]:
        """Advance by `most_frames` at most; the caller sends the `messages`, and calls `count`.

        Args:
            commands: Set-points at the end of each frame.
            record: Takes the frames; by default a record with room for `most_frames`.

        Returns:
            The frames, which hold until the next call, and the error that ended them before the last command.
        """
        targets = np.array(commands).reshape(-1, 3)
        frames, error = self.twin.fill(self._record if record is None else record, targets, self.period)
        if isinstance(error, RunError):
            self.rejected_steps.stopped = str(error)
        return frames, error

    @property
    def most_frames(self) -> int:
        """Most frames that `fill` takes."""
        return self._record.size

    @cached_property
    def _record(self) -> Record:
        return self.twin.record(max(1, min(MOST_FRAMES, _MOST_BYTES // self._single.table.nbytes)))

    def messages(
        self, frames: Frames, markers: Sequence[int], exaggeration: float | None = None
    ) -> list[list[Message]]:
        """Encode frames; a list of topics and bytes for each, in the order of sending.

        Args:
            frames: The frames.
            markers: Numbers of the frames for which `/string/markers` is due.
            exaggeration: Factor of lateral motion in them; the default where None.

        Raises:
            MessageError: A number in a frame is not finite.
        """
        encoder = self._encoder
        regular = {RIG_STATE: encoder.rig_state, MARKS_STATE: encoder.marks, STRING_POSES: encoder.poses}
        if frames.stress is not None:
            regular[STRING_STRESS] = encoder.stress
        columns = [[(topic, raw) for raw in encode(frames)] for topic, encode in regular.items()]
        messages = [list(row) for row in zip(*columns, strict=True)]
        if markers:
            for row, raw in zip(markers, encoder.markers(frames.part(markers), exaggeration), strict=True):
                messages[row].append((STRING_MARKERS, raw))
        if self._measurements is not None and frames.u is not None and frames.v is not None:
            for row, (end, u, v) in enumerate(zip(frames.time.tolist(), frames.u, frames.v, strict=True)):
                messages[row] += self._measurements.messages(end, u, v, frames.rig_state(row))
        # The clock is last: a driver that answers it can rely on the frame being out.
        for row, raw in enumerate(encoder.clock(frames.time)):
            messages[row].append((CLOCK_TOPIC, raw))
        return messages

    def count(self, frames: Frames, publishing: float) -> None:
        """Count frames that were sent, which took a time [s]."""
        number = len(frames.time)
        if number:
            self.frames += number
            self.timing.update(number * self.period, publishing, frames.stats, number)
            self.missing_effects.update(frames)
            self.rejected_steps.update(frames)

    def diagnostics(self) -> dict[str, str]:
        """Named values of the run for `/diagnostics`; sends the real-time factor and begins a new window of it."""
        self._sink(REALTIME_FACTOR, encode_float64(self.timing.recent_realtime_factor))
        values = {
            "simulated_time": f"{self.twin.time:.6f}",
            "frames": str(self.frames),
            **self.timing.values(),
            "elements": str(self.twin.elements),
            "step_s": repr(float(self.twin.step_size)),
            **self.missing_effects.values(),
            **({NOTES: SEPARATOR.join(self.notes)} if self.notes else {}),
            **self.rejected_steps.values(),
        }
        self.timing.start_window()
        return values

    def verdict(self) -> tuple[Level, str]:
        """Level and sentence for `/diagnostics`: why the run was stopped, what was rejected, what is missing."""
        if self.rejected_steps.stopped:
            return Level.ERROR, self.rejected_steps.stopped
        if self.rejected_steps.last:
            return Level.WARN, self.rejected_steps.last
        if self.missing_effects.found:
            return Level.WARN, self.missing_effects.found[-1]
        return Level.OK, self.timing.text()
