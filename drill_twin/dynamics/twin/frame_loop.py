# SPDX-License-Identifier: Apache-2.0
"""The compiled frame loop of one twin, called in slices, with a limit of processor time for each frame."""

from __future__ import annotations

import time

from drill_twin.core.arrays import Array
from drill_twin.dynamics.solver import slices
from drill_twin.dynamics.solver.state import HALVINGS, NEXT_STEP, UNFINISHED
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.frame_kernel import REPEATED, ROW

LONGEST_FRAME = 60.0
"""Most processor time of a frame unless `numerics.processor_time` says another [s]."""
LAST_STEPS = 100
"""Attempts of a step, beyond that time, until one is cut, which shows where Newton's method fails."""


class FrameLoop:
    """Advances a twin frame by frame in compiled code.

    Attributes:
        longest: Most processor time of a frame, its repetitions included [s].
    """

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics, self._course = dynamics, dynamics.bound.course
        given = dynamics.scene.numerics.processor_time
        self.longest = LONGEST_FRAME if given is None else given
        self._iterations = slices.iterations_of(dynamics.rod.length.size)
        self._begun: tuple[float, float] | None = None  # simulated time of a frame that was paused, and clock then [s]
        self._halvings = 0.0  # when that frame was last within `longest`
        self._late = 0  # attempts of a step beyond `longest`

    @property
    def row(self) -> int:
        """Number of the next frame of the block."""
        return int(self._course[ROW])

    def begin(self) -> None:
        """Begin a block."""
        self._course[:] = 0
        self._begun = None

    def run(self, commands: Array, seconds: float, table: Array) -> int:
        """Advance by frames of a block while they are good; returns the outcome of the last.

        Args:
            commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
            seconds: Length of a frame [s].
            table: Record of the frames.

        Returns:
            See `drill_twin.dynamics.twin.frame_kernel`; PAUSED for a frame that took longer than `longest`.
        """
        dynamics = self._dynamics
        step = dynamics.step
        return slices.in_slices(
            lambda: dynamics.run(commands, seconds, step, table), dynamics.progress, self._next_slice
        )  # fmt: skip

    def take_back(self) -> None:
        """Take back the frame that was recorded last."""
        self._course[ROW] -= 1
        self._dynamics.progress[UNFINISHED] = 1.0

    def repeat(self) -> None:
        """Let the next frame begin from the state that was saved."""
        self._course[REPEATED] = 1

    def abandon(self) -> None:
        """Go back to the end of the last whole frame, if one has been begun since."""
        if self._dynamics.progress[UNFINISHED] != 0.0:
            self._dynamics.roll_back()
            self._dynamics.progress[UNFINISHED] = 0.0

    def _next_slice(self) -> float:
        """Newton iterations of the next slice; 0 if the frame takes too long, once it is seen where it is cut."""
        dynamics = self._dynamics
        if dynamics.progress[NEXT_STEP] == 0.0:
            return self._iterations
        now = time.thread_time()
        if self._begun is None or self._begun[0] != dynamics.time:
            self._begun, self._late = (dynamics.time, now), 0
        if now - self._begun[1] <= self.longest:
            self._halvings = dynamics.counters[HALVINGS]
            return self._iterations
        self._late += 1
        return 0.0 if self._late > LAST_STEPS or dynamics.counters[HALVINGS] > self._halvings else 1.0
