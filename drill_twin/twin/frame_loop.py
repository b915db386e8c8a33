# SPDX-License-Identifier: Apache-2.0
"""The compiled frame loop of one twin: its arrays and functions, bound once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from drill_twin.audit import state_check
from drill_twin.base.arrays import Array
from drill_twin.model.section_stress import SCALARS
from drill_twin.solver.native_call import Bound, bind, unbox
from drill_twin.twin import frame_kernel, observation
from drill_twin.twin.dynamics import Dynamics
from drill_twin.twin.frame_kernel import Frames, Past, Places, Rows, States
from drill_twin.twin.observer import Observer
from drill_twin.twin.step_guard import StepGuard


class FrameLoop:
    """Advances a twin frame by frame in compiled code.

    Attributes:
        outcome: Outcome of the last frame, see `drill_twin.twin.frame_kernel`.
    """

    def __init__(self, dynamics: Dynamics, guard: StepGuard, observer: Observer, past: Past) -> None:
        self._dynamics, self._guard, self._observer = dynamics, guard, observer
        self._shown = observer.shown(past)
        self.target = np.zeros_like(dynamics.command)
        """Set-points at the end of the frame: weight on bit [N], rotation [rad/s], speed of a block [m/s]."""
        self.outcome = frame_kernel.GOOD
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
        self.outcome = self._attempt()
        return self.outcome

    def advance_frame(self, seconds: float) -> int:
        """Advance by a frame of a length [s] to `target`, and show it if it is good; returns its outcome."""
        if self._parameters is not self._dynamics.parameters:
            self._bind()
        self._seconds_shown[0] = seconds
        self.outcome = self._advance_frame()
        return self.outcome

    def show(self) -> None:
        """Show the frame that was observed last."""
        frame_kernel.compiled().show(self._frames, *self._dynamics.unknowns, self._shown)

    def advance(self, commands: Array, seconds: float, row: int, rows: Rows, states: States) -> int:
        """Advance by frames while they are good; returns the first that was not, and sets `outcome`.

        Args:
            commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
            seconds: Length of a frame [s].
            row: First frame.
            rows: Record of the frames.
            states: The rest of it.
        """
        if self._parameters is not self._dynamics.parameters:
            self._bind()
        outcome = np.zeros(1, np.int64)
        arguments = (self._frames, *self._dynamics.unknowns, commands, seconds, row, rows, states, outcome)
        stopped = int(frame_kernel.compiled().advance_frames(*arguments))
        self.outcome = int(outcome[0])
        return stopped

    def record(self, rows: Rows, states: States, row: int) -> None:
        """Record the frame that was observed last."""
        frame_kernel.compiled().record(self._frames, *self._dynamics.unknowns, rows, states, row)

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
