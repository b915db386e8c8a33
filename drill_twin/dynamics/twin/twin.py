# SPDX-License-Identifier: Apache-2.0
"""Twin of a drillstring: advances frame by frame, checked by the step guard."""

import time
from collections.abc import Iterator, Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.solver.state import HALVINGS, PAUSED, REACHED, STEPS
from drill_twin.dynamics.twin.binding import read_past
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.energy_balance import EnergyAudit
from drill_twin.dynamics.twin.failure_report import failure_report
from drill_twin.dynamics.twin.frame import EnergyBalance, Frame, Frames
from drill_twin.dynamics.twin.frame_kernel import GOOD, HALVED_TOO_OFTEN, IMPLAUSIBLE, max_halvings
from drill_twin.dynamics.twin.frame_record import Record, frame_of, frames_of, make_record
from drill_twin.dynamics.twin.step_guard import FrameLoop, StepGuard, Violation
from drill_twin.physics.model import DiscreteModel, Rod
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command


class Twin:
    """Simulated drillstring of a scene, with all state of a run.

    Attributes:
        scene: The scene.
        dynamics: Kernel and state.
        energy_audit: Energy balance, if the scene asks for an audit.
    """

    def __init__(self, scene: Scene) -> None:
        """Set the initial state of `rig.start`.

        Raises:
            SceneError: The scene asks for an accuracy instead of elements and a step.
            TableError: Elements or step are to be chosen for a record that cannot be used.
            RunError: No equilibrium was found to start from.
        """
        self.scene = scene
        self.dynamics = dynamics = Dynamics(scene)
        self.energy_audit: EnergyAudit | None = None
        if scene.numerics.audit == "energy":
            keys = [effect.key for effect in dynamics.effects]
            self.energy_audit = EnergyAudit(
                dynamics.parameters.ledger, keys, self.model, dynamics.wall, dynamics.energy_of
            )
        self._guard, self._loop = StepGuard(dynamics), FrameLoop(dynamics)
        self._energy: EnergyBalance | None = None
        self._single, self._last = np.zeros((1, 3)), self.record(1)

    def change_numbers(self, scene: Scene) -> None:
        """Take the numbers of another scene in the middle of a run, as `Dynamics.change_numbers`."""
        self.dynamics.change_numbers(scene)
        self.scene = scene

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.dynamics.time

    @property
    def step_size(self) -> float:
        """Nominal time step [s]."""
        return self.dynamics.step

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.rod.length.size

    @property
    def model(self) -> DiscreteModel:
        """Discrete model of string and hole."""
        return self.dynamics.model

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.dynamics.rod

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self.dynamics.unknowns

    def checkpoint(self) -> dict[str, Array]:
        """Copy the arrays of the state, by name, for `restore`."""
        return {name: array.copy() for name, array in self._arrays()}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Restore the `checkpoint` of a twin of the same scene."""
        for name, array in self._arrays():
            array[...] = arrays[name]
        self.dynamics.bound.past.next[0] = 0

    def last_second(self) -> tuple[Array, Array, Array]:
        """Times of the last frames [s], shape (k,), and their node rows u and v, shape (k, n + 1, 7) each; copies."""
        return read_past(self.dynamics.bound.past)

    def _arrays(self) -> Iterator[tuple[str, Array]]:
        yield from self.dynamics.arrays()
        yield "guard", self._guard.memory

    def advance(self, command: Command, seconds: float) -> Frame:
        """Advance by one frame; the set-points change linearly from the last command to this one.

        Args:
            command: Set-points at the end.
            seconds: Length of the frame [s].

        Raises:
            StoppedError: Violation in all retries with smaller steps; the twin is back at the last good frame.
        """
        began = time.perf_counter()
        record, self._single[0] = self._last, command
        self._follow(record, self._single, seconds)
        row, seconds = record.table[0].copy(), time.perf_counter() - began
        return frame_of(row, record.kind, seconds, record.interventions.get(0), self._energy)

    def load(self) -> None:
        """Bind the compiled frame loop and load its machine code, so that no frame waits for it or is timed with it."""
        self._loop.begin()
        self.dynamics.run(self._single[:0], 1.0, self.step_size, self._last.table, self._loop.next_slice)

    def record(self, frames: int, *, nodes: bool = True) -> Record:
        """Make an empty record of a number of frames, with the state of all nodes, as messages need it, or without."""
        return make_record(self.dynamics.row_type(whole=nodes), frames)

    def advance_frames(self, commands: Array, seconds: float, record: Record) -> int:
        """Advance by frames, and record them: the same bits as `advance`.

        Args:
            commands: Set-points at the end of each frame, as a `Command`, shape (F, 3), contiguous.
            seconds: Length of a frame [s].
            record: Takes the F frames.

        Returns:
            Number of frames that were repeated with a smaller step.

        Raises:
            StoppedError: As `advance`; the frames before are recorded.
        """
        self._follow(record, commands, seconds)
        return len(record.interventions)

    def fill(self, record: Record, commands: Array, seconds: float) -> tuple[Frames, BaseException | None]:
        """As `advance_frames`, with all that messages need.

        Args:
            record: Takes the F frames, with their nodes; the result is a view of it.
            commands: As in `advance_frames`.
            seconds: Length of a frame [s].

        Returns:
            The frames, and the error that ended them before the last command, such as a `StoppedError`; the twin is at
            the end of the last of them.
        """
        error: BaseException | None = None
        began = time.perf_counter()
        try:
            self._follow(record, commands, seconds)
        except BaseException as ended:  # noqa: BLE001 - raised by the caller, once the frames before are recorded
            error = ended
        return frames_of(record, self._loop.row, time.perf_counter() - began, self._energy), error

    def energy(self) -> EnergyBalance | None:
        """Energy balance at the end of the last frame, if the scene asks for an audit."""
        return self._energy

    def _follow(self, record: Record, commands: Array, seconds: float) -> None:
        """Advance by frames in compiled code; Python takes over for a frame that is rejected."""
        loop, count = self._loop, len(commands)
        if commands.shape[1:] != (3,) or count > len(record.table):  # compiled code checks no bounds
            raise ArgumentError(
                f"expected set-points of shape (F, 3), F {len(record.table)} at most, found {commands.shape}"
            )
        record.interventions.clear()
        loop.begin()
        try:
            while loop.row < count:
                found = self._go_on(commands, seconds, record.table)
                if found is not None:
                    self._retry_with_smaller_step(found, record, commands, seconds)
        except BaseException:
            loop.abandon()
            raise

    def _go_on(self, commands: Array, seconds: float, table: Array) -> Violation | None:
        """Advance until a frame is rejected, with an audit by one frame; returns why it was."""
        loop, guard, audit, memory = self._loop, self._guard, self.energy_audit, self._guard.memory.copy()
        if audit is not None:
            commands = commands[: loop.row + 1]
            audit.begin(*self.unknowns)
        outcome = self.dynamics.run(commands, seconds, self.step_size, table, loop.next_slice)
        found = self._violation(outcome, seconds)
        if audit is None or found is not None:
            return found
        energy, grown = audit.balance(*self.unknowns)
        found = guard.energy_drift(energy, grown)
        if found is None:
            self._energy = energy
        else:
            loop.take_back()
            guard.memory[:] = memory
        return found

    def _violation(self, outcome: int, seconds: float) -> Violation | None:
        """Violation of a frame with an outcome of the frame loop, if any."""
        if outcome == GOOD:
            return None
        if outcome == PAUSED:
            return self._too_slow(seconds)
        if outcome == IMPLAUSIBLE:
            return self._guard.implausible()
        halvings = as_python(max_halvings)(seconds, self.step_size) if outcome == HALVED_TOO_OFTEN else None
        return self._guard.diverged(self._step_now(seconds), halvings)

    def _retry_with_smaller_step(self, first: Violation, record: Record, commands: Array, seconds: float) -> None:
        """Roll back and repeat the frame with half the step until no violation is found."""
        loop, guard, row = self._loop, self._guard, self._loop.row
        found: Violation | None = first
        tries, before = 0, guard.memory.copy()
        while found is not None:
            guard.roll_back()
            start = self.time
            if guard.exhausted(found, tries):
                step = self._step_now(seconds)
                raise failure_report(self.dynamics, found, guard.suspect, commands[row], seconds, step)
            tries += 1
            guard.halve_step()
            loop.repeat()
            try:
                found = self._go_on(commands[: row + 1], seconds, record.table)
            except BaseException:  # of a signal or of what is called between slices
                if loop.row == row:
                    guard.memory[:] = before
                raise
        record.interventions[row] = guard.intervention(start, first, tries, self._step_now(seconds))

    def _too_slow(self, seconds: float) -> Violation:
        """Violation of a frame that took more processor time than it may."""
        dynamics, progress = self.dynamics, self.dynamics.progress
        counted = dynamics.counters - dynamics.bound.effort.counters_before
        return self._guard.too_slow(
            self._loop.longest, seconds, float(progress[REACHED]) - self.time, int(counted[STEPS]),
            int(counted[HALVINGS]), dynamics.largest_change(),
        )  # fmt: skip

    def _step_now(self, seconds: float) -> float:
        """Current time step for a frame of `seconds` [s]."""
        return min(self.step_size, seconds) * self._guard.fraction
