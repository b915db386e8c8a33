# SPDX-License-Identifier: Apache-2.0
"""The compiled frame loop of one twin: its arrays and functions, bound once."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.native_call import Bound, bind, unbox
from drill_twin.dynamics.audit import state_check
from drill_twin.dynamics.solver import slices
from drill_twin.dynamics.solver.state import HALVINGS, NEXT_STEP, UNFINISHED
from drill_twin.dynamics.twin import frame_kernel, observation
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.frame_kernel import Frames, Past, Places, Rows, States
from drill_twin.dynamics.twin.observer import Observer
from drill_twin.dynamics.twin.step_guard import StepGuard
from drill_twin.physics.model.section_stress import SCALARS

LONGEST_FRAME = 60.0
"""Most processor time of a frame unless `numerics.processor_time` says another [s]."""
LAST_STEPS = 100
"""Attempts of a step, beyond that time, until one is cut, which shows where Newton's method fails."""


class FrameLoop:
    """Advances a twin frame by frame in compiled code.

    Attributes:
        outcome: Outcome of the last frame, see `drill_twin.dynamics.twin.frame_kernel`; PAUSED for one that took longer
            than `longest`.
        longest: Most processor time of a frame, its repetitions included [s].
    """

    def __init__(self, dynamics: Dynamics, guard: StepGuard, observer: Observer, past: Past) -> None:
        self._dynamics, self._guard, self._observer = dynamics, guard, observer
        self._shown = observer.shown(past)
        self.target = np.zeros_like(dynamics.command)
        """Set-points at the end of the frame: weight on bit [N], rotation [rad/s], speed of a block [m/s]."""
        self.outcome = frame_kernel.GOOD
        given = dynamics.scene.numerics.processor_time
        self.longest = LONGEST_FRAME if given is None else given
        self._recorded = np.zeros(1, np.int64)
        self._iterations = slices.iterations_of(dynamics.rod.length.size)
        self._begun: tuple[float, float] | None = None  # simulated time of a frame that was paused, and clock then [s]
        self._halvings = 0.0  # when that frame was last within `longest`
        self._late = 0  # attempts of a step beyond `longest`
        self._parameters: Any = None
        self._frames: Any = None
        self._called: list[tuple[Bound, Callable[[], tuple[Any, ...]]]] = []

    def attempt(self, seconds: float, *, save: bool) -> int:
        """Advance by a frame of a length [s] to `target`; returns its outcome.

        Args:
            seconds: Length of the frame [s].
            save: Save the state before; not for a frame that is repeated.
        """
        if self._parameters is not self._dynamics.parameters:
            self._bind()
        self._seconds[0], self._save[0] = seconds, save
        return self._run(self._attempt, fresh=save)

    def advance_frame(self, seconds: float) -> int:
        """Advance by a frame of a length [s] to `target`, and show it if it is good; returns its outcome."""
        if self._parameters is not self._dynamics.parameters:
            self._bind()
        self._seconds_shown[0] = seconds
        return self._run(self._advance_frame)

    def show(self) -> None:
        """Show the frame that was observed last."""
        frame_kernel.compiled().show(self._frames, *self._dynamics.unknowns, self._shown)
        self._take()

    def advance(self, commands: Array, seconds: float, row: int, rows: Rows, states: States) -> int:
        """Advance by frames while they are good; returns the first that was not, as `recorded`, and sets `outcome`.

        Args:
            commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
            seconds: Length of a frame [s].
            row: First frame.
            rows: Record of the frames.
            states: The rest of it.
        """
        if self._parameters is not self._dynamics.parameters:
            self._bind()
        self._recorded[0] = row
        function, unknowns, recorded = frame_kernel.compiled().advance_frames, self._dynamics.unknowns, self._recorded
        self._run(
            lambda: function(self._frames, *unknowns, commands, seconds, int(recorded[0]), rows, states, recorded)
        )
        return self.recorded

    @property
    def recorded(self) -> int:
        """Number of rows that hold a frame, of those given last."""
        return int(self._recorded[0])

    def record(self, rows: Rows, states: States, row: int) -> None:
        """Record the frame that was observed last."""
        frame_kernel.compiled().record(self._frames, *self._dynamics.unknowns, rows, states, row)
        self._recorded[0] = row + 1
        self._take()

    def begin_rows(self) -> int:
        """Begin with the first of other rows, and return it."""
        self._recorded[0] = 0
        return 0

    def _take(self) -> None:
        """Take the frame that was attempted last: its end is the state to go back to from now on."""
        self._dynamics.progress[UNFINISHED] = 0.0

    def abandon(self) -> None:
        """Go back to the end of the last whole frame, if one has been begun since."""
        if self._dynamics.progress[UNFINISHED] != 0.0:
            self._guard.rollback(*self._dynamics.unknowns)
            self._take()

    def _run(self, function: Callable[[], int], *, fresh: bool = True) -> int:
        """Call a function of the loop, for a frame that is not a repetition or for one that is; sets `outcome`."""
        if fresh:
            self._begun = None
        self.outcome = int(slices.in_slices(function, self._dynamics.progress, self._next_slice))
        return self.outcome

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

    def rows(self, frames: int) -> Rows:
        """Make an empty record of a number of frames."""
        marks, dynamics = self._observer.seen.spin.size, self._dynamics
        impulses = dynamics.parameters.drive.bit.impulse.size
        sizes = {
            "time": (), "command": self.target.shape, "position": (marks, 3), "centre": (marks, 3), "spin": (marks,),
            "wall_force": (marks,), "ends": (2, 3), "counted": (dynamics.counters.size,), "pushed": (impulses,),
            "string": (3,),
        }  # fmt: skip
        return Rows(**{name: np.empty((frames, *size)) for name, size in sizes.items()})

    def states(self, frames: int) -> States:
        """Make an empty record of the rest of a number of frames."""
        seen, (u, v) = self._observer.seen, self._dynamics.unknowns
        like = (u, v, seen.tangents, seen.wall_force, seen.velocity, seen.spin_rate, seen.deepest, self._stress)
        return States(*(np.empty((frames, *array.shape)) for array in like))

    @property
    def _stress(self) -> Array:
        stress = self._dynamics.stress
        return np.zeros((0, len(SCALARS))) if stress is None else stress

    def _bind(self) -> None:
        dynamics, guard, observer = self._dynamics, self._guard, self._observer
        u, v = dynamics.unknowns
        rod, seen = dynamics.rod, observer.seen
        self._parameters = dynamics.parameters
        if self._called:  # other numbers, of the same types and in the same arrays
            self._frames = self._frames._replace(limits=guard.limits(dynamics.step))
            for bound, arguments in self._called:
                bound.call.words[:] = unbox(arguments())
            return
        kernel = bind(dynamics.kernel.advance, self._advance_arguments())
        observe = bind(observation.compiled(), self._sight())
        check = bind(state_check.compiled(), (rod.outer_radius, u, v, guard.extremes))
        self._frames = Frames(
            advance=kernel.call, observe=observe.call, check=check.call,
            places=_places(kernel.arguments), limits=guard.limits(dynamics.step),
            memory=dynamics.memory_block.view(np.int64), saved=guard.saved.view(np.int64), clock=dynamics.clock,
            progress=dynamics.progress,
            command=dynamics.command, target=self.target, guard=guard.memory,
            extremes=guard.extremes, before=guard.before,
            counters=dynamics.counters, counters_before=observer.counters_before,
            impulse=dynamics.parameters.drive.bit.impulse, impulse_before=observer.impulse_before, seen=seen,
            stress=self._stress,
        )  # fmt: skip
        compiled = frame_kernel.compiled()
        attempt = bind(compiled.attempt, self._attempt_arguments())
        shown = bind(compiled.advance_frame, self._shown_arguments())
        self._called = [
            (kernel, self._advance_arguments), (observe, self._sight), (attempt, self._attempt_arguments),
            (shown, self._shown_arguments),
        ]  # fmt: skip
        self._kept = check  # whose arrays are known by address
        self._attempt = partial(attempt.entry, attempt.call.words, attempt.call.target)
        self._advance_frame = partial(shown.entry, shown.call.words, shown.call.target)
        self._seconds, self._save = attempt.call.words[-2:-1].view(np.float64), attempt.call.words[-1:]
        self._seconds_shown = shown.call.words[-1:].view(np.float64)

    def _advance_arguments(self) -> tuple[Any, ...]:
        return self._dynamics.arguments(self.target, 0.0, 0.0)

    def _sight(self) -> tuple[Any, ...]:
        dynamics, observer = self._dynamics, self._observer
        rod, hole = dynamics.rod, dynamics.model.wellbore
        return (rod.length, rod.shape, hole, dynamics.wall, *dynamics.unknowns, observer.marks, observer.seen)

    def _attempt_arguments(self) -> tuple[Any, ...]:
        return (self._frames, 0.0, True)

    def _shown_arguments(self) -> tuple[Any, ...]:
        return (self._frames, *self._dynamics.unknowns, self._shown, 0.0)


def _places(arguments: tuple[Any, ...]) -> Places:
    """Places of the step control, whose first number is the step and whose last the most halvings, and of the times."""
    control, start = (len(unbox(arguments[:count])) for count in (5, 8))
    return Places(control, control + 3, start, start + 1)
