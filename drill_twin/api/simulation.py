# SPDX-License-Identifier: Apache-2.0
"""A run in Python: the scene's schedule, or a controller of one's own in the loop."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from drill_twin.api.scenes import RPM, Overrides, Quantity, as_scene, in_si, with_resolution
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, RunError
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE, SPEED, TIME
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import FASTEST_BLOCK, FASTEST_ROTATION, LARGEST_LOAD
from drill_twin.scene.set_points import Command, Schedule

if TYPE_CHECKING:
    from drill_twin.api.result import Result
    from drill_twin.dynamics.twin.frame import Frames
    from drill_twin.runs.session_run import SetPoints
    from drill_twin.whirl import Findings


class CompileProgress:
    """Writes the progress: on a terminal one line that is written over, else the first text only."""

    def __init__(self) -> None:
        self._width = 0

    def __call__(self, text: str) -> None:
        """Write a text of progress."""
        stream = sys.stderr
        if stream.isatty():
            print(f"\r{text:<{self._width}}", end="", file=stream, flush=True)
        elif self._width == 0:
            print(text, file=stream, flush=True)
        self._width = max(self._width, len(text))

    def end(self) -> None:
        """Erase the line of a terminal."""
        if self._width and sys.stderr.isatty():
            print(f"\r{'':<{self._width}}\r", end="", file=sys.stderr, flush=True)


@dataclass(frozen=True, eq=False)
class State:
    """State of a run at one instant, for a controller; m marks in the order of the scene."""

    time: float
    """Simulated time [s]."""
    weight_on_bit: float
    """Weight on bit as applied [N], positive = compression."""
    rpm: float
    """Speed of the top drive [rev/min]."""
    bit_rpm: float
    """Speed of the bit [rev/min]."""
    hookload: float
    """Force that holds the string at the top [N]."""
    torque: float
    """Torque of the top drive on the string [N m]."""
    bit_torque: float
    """Torque of the rock on the bit [N m]."""
    centre: Array
    """Positions of the centre line at the marks [m], shape (m, 3)."""
    wall_force: Array
    """Normal forces of the wall on the string at the marks [N], shape (m,)."""
    motion: str
    """Motion state of the string, such as "forward whirl"; "unknown" before the first sample of a mark."""
    onset_s: float | None
    """Onset of whirl [s], once it is found."""

    @classmethod
    def of(cls, frames: Frames, findings: Findings | None) -> State:
        """State at the end of some frames and of the analysis after them."""
        rig, onset = frames.rig_state(-1), findings.onset if findings else None
        return cls(
            time=float(frames.time[-1]),
            weight_on_bit=rig.bit_force,
            rpm=rig.top_drive_speed / RPM,
            bit_rpm=rig.bit_speed / RPM,
            hookload=rig.hookload,
            torque=rig.top_drive_torque,
            bit_torque=rig.bit_torque,
            centre=frames.marks.centre[-1].copy(),
            wall_force=frames.marks.wall_force[-1].copy(),
            motion=findings.motion.value if findings else "unknown",
            onset_s=onset.time_s if onset else None,
        )


class Simulation:
    """A run of a scene, analysed while it goes on and kept in memory.

    >>> result = Simulation("pa6_bench").run(duration=30)
    >>> result.onset_s

    Attributes:
        scene: The scene, with elements and step in place of an accuracy.
        state: The state after the last frame; None before the first.
    """

    def __init__(self, scene: Scene | str | Path, overrides: Overrides | None = None) -> None:
        """Prepare a run; compiles the effects of the scene, which takes a minute or two the first time.

        The compilation is done in a child process, with a line of progress on standard error; Ctrl-C ends it.

        Args:
            scene: The scene, or its name or file.
            overrides: Values that replace the scene's values.

        Raises:
            SceneError: The scene cannot be loaded, or has an accuracy that cannot be reached.
            RunError: The scene begins in static equilibrium, and none was found.
        """
        from drill_twin.io.bag.virtual_bags import MemoryBag
        from drill_twin.runs import SessionRun, compile_kernel

        self.scene = with_resolution(as_scene(scene, overrides))
        self._period = self.scene.numerics.frame_period_ns
        progress = CompileProgress()
        try:
            compile_kernel(self.scene, self.frame_time, progress, analysis=True)
        finally:
            progress.end()
        self._bag = MemoryBag(f"run of {self.scene.name}")
        self._run = SessionRun(self.scene, self._bag)
        self._reported = -1
        self.state: State | None = None

    def __repr__(self) -> str:
        """One line: scene, time, motion."""
        return f"<Simulation of {self.scene.name}: {self.time:g} s, {self.state.motion if self.state else 'not begun'}>"

    @property
    def frame_time(self) -> float:
        """Simulated time of a frame [s], 1 / `numerics.frame_rate` in whole nanoseconds."""
        return seconds(self._period)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return seconds(self._run.stamp)

    @cached_property
    def schedule(self) -> Schedule:
        """Set-points of the scene over time.

        Raises:
            TableError: The record that the scene plays cannot be played.
            SceneError: The shape of a set-point cannot be loaded.
        """
        return Schedule.from_scene(self.scene)

    def run(self, duration: Quantity | None = None, *, progress: Callable[[State], None] | None = None) -> Result:
        """Run on under the set-points of the scene.

        Args:
            duration: Simulated time to run [s]; left out: to the end of the scene.
            progress: Called with the state after each frame.

        Raises:
            ArgumentError: The duration is not above 0 s, or left out at the end of the scene.
            RunError: The motion could not be followed; `result` gives what came before.
        """
        if duration is None:
            length = self.schedule.duration - self.time
            if length < 0.5 * self.frame_time:
                raise ArgumentError(
                    f"rig.duration: expected at least half a frame ({0.5 * self.frame_time:g} s) after {self.time:g} "
                    f"s, found the scene at its end ({self.schedule.duration:g} s); run for longer (--duration, "
                    "duration=10, or rig.duration of the scene)"
                )
        else:
            length = in_si("duration", duration, TIME)
        self._run_on(self.schedule.at, max(1, math.ceil(self._frames("duration", length) - 0.5)), progress)
        return self.result()

    def advance(
        self,
        wob: Quantity | None = None,
        rpm: Quantity | None = None,
        seconds: Quantity | None = None,
        block: Quantity | None = None,
    ) -> State:
        """Run on under set-points of one's own, reached linearly within the first frame and held.

        Args:
            wob: Weight on bit [N]; left out: as before.
            rpm: Speed of the top drive [rev/min]; left out: as before.
            seconds: Simulated time, a whole number of frames [s]; left out: one frame.
            block: Speed of the travelling block [m/s], of a scene with `rig.block`; left out: as before.

        Raises:
            ArgumentError: A set-point is no such quantity, or the time is not a whole number of frames.
            RunError: The motion could not be followed; `result` gives what came before.
        """
        last, carried = self._run.command, self.scene.rig.block
        if block is not None and (carried is None or carried.auto_driller is not None):
            found = "none" if carried is None else "a block that an auto-driller moves, command wob"
            raise ArgumentError(f"block: expected a scene with rig.block, found {found} in {self.scene.name}")
        command = Command(
            last.weight_on_bit if wob is None else in_si("wob", wob, FORCE),
            last.rotation if rpm is None else in_si("rpm", rpm, ANGULAR_SPEED, RPM),
            last.block if block is None else in_si("block", block, SPEED),
        )
        self._check_ranges(command)
        wanted = 1.0 if seconds is None else self._frames("seconds", in_si("seconds", seconds, TIME))
        frames = round(wanted)
        if abs(wanted - frames) > 1e-6 * wanted:
            raise ArgumentError(
                f"seconds: expected a whole number of frames of {self.frame_time:g} s, found {seconds!r}; "
                f"take {max(frames, 1) * self.frame_time:g}, or set numerics.frame_rate"
            )
        return self._run_on(lambda _: command, frames)

    @staticmethod
    def _check_ranges(command: Command) -> None:
        for name, value, largest, unit, symbol in (
            ("wob", command.weight_on_bit, LARGEST_LOAD, 1.0, "N"),
            ("rpm", command.rotation, 60.0 * FASTEST_ROTATION, RPM, "rpm"),
            ("block", command.block, FASTEST_BLOCK, 1.0, "m/s"),
        ):
            if abs(value) > largest * unit * (1.0 + 1e-9):
                raise ArgumentError(
                    f"{name}: expected {-largest:g} to {largest:g} {symbol}, found {value / unit:g} {symbol}"
                )

    def follow(self, command: Command) -> State:
        """Run on by a frame, at whose end a command holds: weight on bit [N] and speed of the top drive [rad/s].

        Raises:
            RunError: The motion could not be followed; `result` gives what came before.
        """
        return self.play([command])

    def play(self, commands: Sequence[Command]) -> State:
        """Run on by frames, at whose ends the commands hold, as `follow` for each.

        Raises:
            RunError: The motion could not be followed; `result` gives what came before.
        """
        first = self._run.loop.frames + 1
        return self._run_on(lambda end: commands[round(end / self.frame_time) - first], len(commands))

    def result(self) -> Result:
        """All that was recorded so far, and its analysis; the run can go on afterwards.

        Raises:
            ArgumentError: Nothing was run yet.
        """
        from drill_twin.api.result import Result

        if self.state is None:
            raise ArgumentError("expected a run of at least one frame, found none; call run or advance first")
        self._report()
        pipeline = self._run.pipeline  # without marks the recording analyses the readings of a sub, where it has one
        findings = None if pipeline.bit_only is not None else pipeline.summary()
        return Result(self._bag.snapshot(), self.scene, findings=findings)

    def _frames(self, name: str, length: float) -> float:
        if length <= 0.0:
            raise ArgumentError(f"{name}: expected a time above 0 s, found {length:g} s")
        return length * NANOSECONDS / self._period

    def _run_on(self, set_points: SetPoints, frames: int, progress: Callable[[State], None] | None = None) -> State:
        """Run on by frames: one at a time for a progress, else as many at once as `SessionRun` takes."""
        end = self._run.loop.frames + frames
        while (left := end - self._run.loop.frames) > 0:
            try:
                self._run.follow(set_points, 1 if progress is not None else min(left, self._run.most_frames))
            except RunError:
                self._report()
                raise
            finally:
                if self._run.last is not None:
                    self.state = state = State.of(self._run.last, self._run.findings)
            if progress is not None:
                progress(state)
        return state

    def _report(self) -> None:
        """Record the diagnostics that close a bag, once for each frame."""
        if self._reported != self._run.loop.frames:
            self._reported = self._run.loop.frames
            self._run.report_diagnostics()
