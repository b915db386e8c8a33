# SPDX-License-Identifier: Apache-2.0
"""Twin of a drillstring: advances frame by frame, checked by the step guard."""

import time
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.solver.state import HALVINGS, PAUSED, REACHED, STEPS
from drill_twin.dynamics.twin.dynamics import Dynamics, restore_arrays
from drill_twin.dynamics.twin.energy_balance import EnergyAudit
from drill_twin.dynamics.twin.failure_report import failure_report
from drill_twin.dynamics.twin.frame import EnergyBalance, Frame, Frames, Intervention
from drill_twin.dynamics.twin.frame_kernel import DIVERGED, GOOD, HALVED_TOO_OFTEN, SUSPECT, Rows, States
from drill_twin.dynamics.twin.frame_loop import FrameLoop
from drill_twin.dynamics.twin.number_change import change_numbers
from drill_twin.dynamics.twin.observer import Observer, Record
from drill_twin.dynamics.twin.state_bounds import bounds_of
from drill_twin.dynamics.twin.state_history import StateHistory
from drill_twin.dynamics.twin.step_guard import StepGuard, max_halvings
from drill_twin.dynamics.twin.violation import Violation
from drill_twin.physics.model.bit import DRILLED
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import Rod
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
        lateral = dynamics.form == LATERAL
        self.energy_audit: EnergyAudit | None = None
        if scene.numerics.audit == "energy":
            self.energy_audit = EnergyAudit(
                dynamics.parameters.ledger, dynamics.effects, self.model, dynamics.wall, lateral=lateral
            )
        self._guard = StepGuard(bounds_of(scene, self.model, lateral=lateral), self.model, dynamics.wall)
        self._guard.attach(dynamics.memory_block)
        self._observer = Observer(dynamics)
        self._history = StateHistory(self.rod.arc.size, scene.numerics.frame_rate)
        self._loop = FrameLoop(dynamics, self._guard, self._observer, self._history.memory)
        self._energy: EnergyBalance | None = None

    def change_numbers(self, scene: Scene) -> None:
        """Take the numbers of another scene in the middle of a run, as `drill_twin.dynamics.twin.number_change`, with
        the bounds of a plausible state that belong to them.
        """
        change_numbers(self.dynamics, scene)
        self.scene = scene
        bounds = bounds_of(scene, self.model, lateral=self.dynamics.form == LATERAL)
        self._guard.set_bounds(bounds, self.dynamics.wall)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.dynamics.time

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.rod.length.size

    @property
    def step_size(self) -> float:
        """Nominal time step [s]."""
        return self.dynamics.step

    @property
    def effects(self) -> list[str]:
        """Keys of the scene's effects."""
        return self.scene.effect_names

    @property
    def form(self) -> str:
        """Formulation: "spatial", or "lateral" for a scene with neither stretch nor torsion."""
        return self.dynamics.form

    @property
    def drilled(self) -> float:
        """Depth drilled since the start [m]; 0 without a bit that cuts."""
        return float(self.dynamics.parameters.drive.bit.impulse[DRILLED])

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

    def effect_timer(self) -> Callable[[str], float]:
        """Make a function that measures an effect's time per Newton iteration in the current state [s], by its key."""
        return self.dynamics.effect_timer()

    def checkpoint(self) -> dict[str, Array]:
        """Copy the arrays of the state, by name, for `restore`."""
        return {name: array.copy() for name, array in self._arrays()}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Restore the `checkpoint` of a twin of the same scene."""
        restore_arrays(self._arrays(), arrays)
        self._history.clear()

    def last_second(self) -> tuple[Array, Array, Array]:
        """Times of the last frames [s], shape (k,), and their node rows u and v, shape (k, n + 1, 7) each; copies."""
        return self._history.read()

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
        target = self._loop.target
        target[:] = command.values
        intervention = None
        try:
            if self.energy_audit is not None or self._loop.advance_frame(seconds) != GOOD:
                intervention = self._complete(target, seconds)
                self._loop.show()
        except BaseException:
            self._loop.abandon()
            raise
        return self._observer.frame(seconds, time.perf_counter() - began, intervention, self._energy)

    def load(self) -> None:
        """Bind the compiled frame loop and load its machine code, so that no frame waits for it or is timed with it."""
        rows = self._loop.rows(0)
        self._loop.advance(np.zeros((0, self._loop.target.size)), 1.0, 0, rows, self._loop.states(0))

    def rows(self, frames: int) -> Rows:
        """Make an empty record of a number of frames, for `advance_frames`."""
        return self._loop.rows(frames)

    def record(self, frames: int) -> Record:
        """Make an empty record of a number of frames with all that messages need, for `fill`."""
        return Record(self._loop.rows(frames), self._loop.states(frames), {})

    def advance_frames(self, commands: Array, seconds: float, rows: Rows, states: States | None = None) -> int:
        """Advance by frames in compiled code, without Python in between, and record them: the same bits as `advance`.

        Python takes over for a frame that the step guard rejects, and for each frame of a scene with an audit.

        Args:
            commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
            seconds: Length of a frame [s].
            rows: Takes the F frames.
            states: Takes the rest of them, if wanted.

        Returns:
            Number of frames that were repeated with a smaller step.

        Raises:
            StoppedError: As `advance`; the frames before are recorded.
        """
        interventions: dict[int, Intervention] = {}
        for _ in self._good_rows(commands, seconds, Record(rows, states or self._loop.states(0), interventions)):
            pass
        return len(interventions)

    def fill(self, record: Record, commands: Array, seconds: float) -> tuple[Frames, BaseException | None]:
        """As `advance_frames`, with all that messages need.

        Args:
            record: Takes the F frames; the result is a view of it.
            commands: As in `advance_frames`.
            seconds: Length of a frame [s].

        Returns:
            The frames, and the error that ended them before the last command, such as a `StoppedError`; the twin is at
            the end of the last of them.
        """
        error: BaseException | None = None
        began, energy = time.perf_counter(), self._energy
        record.interventions.clear()
        try:
            for _ in self._good_rows(commands, seconds, record):
                energy = self._energy
        except BaseException as ended:  # noqa: BLE001 - raised by the caller, once the frames before are recorded
            error = ended
        count = self._loop.recorded
        self._history.extend(record.rows.time[:count], record.states.u[:count], record.states.v[:count])
        return self._observer.frames(record, count, seconds, time.perf_counter() - began, energy), error

    def _good_rows(self, commands: Array, seconds: float, record: Record) -> Iterator[int]:
        """Advance; yield the number of rows recorded so far, whenever Python takes over and at the end."""
        loop = self._loop
        rows, states, interventions = record
        row = loop.begin_rows()
        try:
            while row < len(commands):
                if self.energy_audit is None:
                    row = loop.advance(commands, seconds, row, rows, states)
                    yield row
                    if row == len(commands):
                        return
                else:
                    loop.target[:] = commands[row]
                found = self._complete(loop.target, seconds)
                if found is not None:
                    interventions[row] = found
                loop.record(rows, states, row)
                row += 1
                yield row
        except BaseException:
            loop.abandon()
            raise

    def energy(self) -> EnergyBalance | None:
        """Energy balance at the end of the last frame, if the scene asks for an audit."""
        return self._energy

    def _complete(self, target: Array, seconds: float) -> Intervention | None:
        """Check the frame after its first attempt, repeat it if need be, and set the set-points last reached."""
        if self.energy_audit is not None:  # no attempt yet
            self.energy_audit.begin(*self.unknowns)
            self._loop.attempt(seconds, save=True)
        found, intervention = self._violation(self._loop.outcome, target, seconds), None
        if found is None:
            self._guard.count_good_frame()
        else:
            intervention = self.retry_with_smaller_step(found, target, seconds)
        self.dynamics.command[:] = target
        return intervention

    def _violation(self, outcome: int, target: Array, seconds: float) -> Violation | None:
        """Violation of a frame with an outcome of the frame loop, if any."""
        guard, step, found = self._guard, self._step_now(seconds), None
        if outcome == PAUSED:
            return self._too_slow(seconds)
        if outcome in {DIVERGED, HALVED_TOO_OFTEN}:
            halvings = max_halvings(seconds, self.step_size) if outcome == HALVED_TOO_OFTEN else None
            return guard.diverged(*self.unknowns, step, halvings)
        if outcome == SUSPECT:
            load = max(abs(float(self.dynamics.command[0])), abs(float(target[0])))
            found = guard.check(*self.unknowns, *self._observer.deepest, load, step)
        if found is None and self.energy_audit is not None:
            self._energy, grown = self.energy_audit.balance(*self.unknowns)
            found = guard.energy_drift(self._energy, grown)
        return found

    def retry_with_smaller_step(self, first: Violation, target: Array, seconds: float) -> Intervention:
        """Roll back and repeat the frame with half the step until no violation is found."""
        found: Violation | None = first
        tries, before = 0, self._guard.memory.copy()
        while found is not None:
            self._guard.rollback(*self.unknowns)
            start = self.time
            if self._guard.exhausted(found, tries):
                raise failure_report(
                    self.dynamics, found, self._guard.suspect, target, seconds, self._step_now(seconds)
                )
            tries += 1
            self._guard.halve_step()
            try:
                outcome = self._loop.attempt(seconds, save=False)
            except BaseException:  # of a signal or of what is called between slices
                self._guard.memory[:] = before
                raise
            found = self._violation(outcome, target, seconds)
        return self._guard.intervention(start, first, tries, self._step_now(seconds))

    def _too_slow(self, seconds: float) -> Violation:
        """Violation of a frame that took more processor time than it may."""
        progress, counted = self.dynamics.progress, self.dynamics.counters - self._observer.counters_before
        return self._guard.too_slow(
            self._loop.longest, seconds, float(progress[REACHED]) - self.time, int(counted[STEPS]),
            int(counted[HALVINGS]), self.dynamics.largest_change(),
        )  # fmt: skip

    def _step_now(self, seconds: float) -> float:
        """Current time step for a frame of `seconds` [s]."""
        return min(self.step_size, seconds) * self._guard.share
