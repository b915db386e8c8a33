# SPDX-License-Identifier: Apache-2.0
"""A run without ROS: schedule, twin and whirl analysis in one process, recorded in a bag or in memory.

The session sends the messages that rig driver, simulator and analyzer send each other in lockstep, as the same bytes on
the same topics, so its recordings equal recordings of the nodes. Messages are stamped and recorded in simulated time.

>>> session = Session(load_scene("pa6_bench"))
>>> outcome = session.run("out/bag_0")
"""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from drill_twin.core.errors import RunError, RunStopped, StoppedError
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin.checkpoint import save_failure
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import OF_EVERY_RUN
from drill_twin.runs.compilation import compile_kernel
from drill_twin.runs.loop import topics_of
from drill_twin.runs.session_run import SessionRun
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule
from drill_twin.whirl import Findings, Summary


@dataclass(frozen=True)
class Outcome:
    """The end of a run."""

    bag: Path
    """Folder of the bag."""
    simulated: float
    """Simulated time [s]."""
    finished: bool
    """True for a run that went on to its end, False for a run that was stopped."""
    wall_seconds: float
    """Wall-clock time of the run without compiling [s]."""
    motion_seconds: float
    """Processor time of computing the motion, without recording and analysis [s]."""
    summary: Summary
    """Findings of the analysis."""


@dataclass(frozen=True)
class Progress:
    """State of a run at the end of some frames."""

    simulated: float
    """Simulated time [s]."""
    duration: float
    """Simulated time at its end [s]."""
    findings: Findings | None
    """The latest findings about whirl."""
    realtime_factor: float
    """Simulated over wall time so far."""


class Session:
    """A scene made ready to run: the schedule is read and the kernel compiled, nothing is written yet."""

    def __init__(
        self, scene: Scene, schedule: Schedule | None = None, compiling: Callable[[str], None] | None = None
    ) -> None:
        """Compile the effects of the scene, which takes a minute or two the first time.

        Args:
            scene: The scene.
            schedule: Set-points; made from the scene unless given.
            compiling: Called with the progress of a compilation, as by `compile_kernel`; may raise to end it.

        Raises:
            TableError: The record that the scene plays cannot be played.
        """
        self.scene = scene
        self.schedule = schedule or Schedule.from_scene(scene)
        self._period = scene.numerics.frame_period_ns
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
            progress: Called each time some frames are recorded, after `BLOCK_SECONDS` or a simulated second.
            stop: Called before the next frames, and several times a second within a long one.

        Raises:
            BagError: The folder exists or cannot be written.
            RunStopped: `stop()` while the state to start from was sought.
            RunError: The motion could not be followed to the end; the bag holds what came before, and the folder
                with `_stop` behind its name the last good state.
        """

        def check() -> None:
            if stop():
                raise RunStopped

        began = time.monotonic()
        frames = max(1, math.ceil(self.schedule.duration * NANOSECONDS / self._period - 0.5))
        with BagWriter(folder, topics=dict.fromkeys((*OF_EVERY_RUN, *topics_of(self.scene)))) as bag:
            with checked(check):
                run = SessionRun(self.scene, bag)
            try:
                with checked(check), suppress(RunStopped):
                    while (left := frames - run.loop.frames) > 0 and not stop():
                        run.follow(self.schedule.at, min(left, run.most_frames))
                        if progress is not None:
                            factor = run.loop.timing.realtime_factor
                            end = seconds(frames * self._period)
                            progress(Progress(seconds(run.stamp), end, run.findings, factor))
            except RunError as error:
                run.report_diagnostics()
                text = f"{error}; what came before is recorded in {bag.folder}"
                if not isinstance(error, StoppedError):
                    raise RunError(text) from error
                state = bag.folder.with_name(f"{bag.folder.name}_stop")
                saved = save_failure(state, run.loop.twin, run.command, error)
                raise error.with_message(f"{text}; {saved}") from error
            run.report_diagnostics()
        wall = time.monotonic() - began
        finished = run.loop.frames == frames
        return Outcome(bag.folder, seconds(run.stamp), finished, wall, run.motion_seconds, run.pipeline.summary())
