# SPDX-License-Identifier: Apache-2.0
"""The twin: advances the dynamics a frame at a time, checked by the step guard."""

import time
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.model.bit import DRILLED
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import Rod
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.twin.dynamics import LATERAL, Dynamics, take
from drill_twin.twin.energy_balance import EnergyAudit
from drill_twin.twin.failure_report import failure_report
from drill_twin.twin.frame import EnergyBalance, Frame, Intervention
from drill_twin.twin.observer import Observer
from drill_twin.twin.state_bounds import bounds_of
from drill_twin.twin.state_history import StateHistory
from drill_twin.twin.step_guard import StepGuard, max_halvings
from drill_twin.twin.violation import Violation


class Twin:
    """A drillstring that is turned and loaded; holds all state of a run.

    Attributes:
        scene: The scene.
        dynamics: What moves it.
        books: Its energy balance, where the scene asks for an audit.
    """

    def __init__(self, scene: Scene) -> None:
        """Put the string in its hole, as `rig.start` says.

        Raises:
            SceneError: The scene asks for an accuracy instead of elements and a step.
            TableError: Elements or step are to be chosen for a record that cannot be played.
            RunError: It is to begin in balance, and none was found.
        """
        self.scene = scene
        self.dynamics = dynamics = Dynamics(scene)
        lateral = dynamics.form == LATERAL
        self.books: EnergyAudit | None = None
        if scene.numerics.audit == "energy":
            self.books = EnergyAudit(
                dynamics.parameters.ledger, dynamics.effects, self.model, dynamics.wall, lateral=lateral
            )
        self._guard = StepGuard(bounds_of(scene, self.model, lateral=lateral), self.model, dynamics.wall)
        self._guard.watch(dynamics.block)
        self._observer = Observer(dynamics)
        self._energy: EnergyBalance | None = None
        self._recent = StateHistory(self.rod.arc.size, scene.numerics.frame_rate)

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
        """Keys of the effects that the scene lists."""
        return self.scene.effect_names

    @property
    def form(self) -> str:
        """Either "spatial", or "lateral" for a scene that calls for neither stretch nor torsion."""
        return self.dynamics.form

    @property
    def drilled(self) -> float:
        """Depth that the bit has drilled since the start [m]; 0 without `bit_cutting`."""
        return float(self.dynamics.parameters.drive.bit.impulse[DRILLED])

    @property
    def model(self) -> DiscreteModel:
        """The string in its hole."""
        return self.dynamics.model

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.dynamics.rod

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self.dynamics.unknowns

    def meter(self) -> Callable[[str], float]:
        """Times an effect: by its name, what it takes of one Newton iteration now [s]; 0 for those that take none."""
        return self.dynamics.meter()

    def checkpoint(self) -> dict[str, Array]:
        """Copies of all that decides how the motion goes on, by name; `restore` takes them back."""
        return {name: array.copy() for name, array in self._memory()}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Go on from the `checkpoint` of a twin of the same scene."""
        take(self._memory(), arrays)
        self._recent.forget()

    def last_second(self) -> tuple[Array, Array, Array]:
        """Times of the last frames [s], shape (k,), and their node rows u and v, shape (k, n + 1, 7); copies."""
        return self._recent.read()

    def _memory(self) -> Iterator[tuple[str, Array]]:
        yield from self.dynamics.memory()
        yield "guard", self._guard.memory

    def advance(self, command: Command, seconds: float) -> Frame:
        """Move on by `seconds`; the set-points go linearly from the last command to this one.

        Args:
            command: Weight on bit [N] and rotation [rad/s] to be reached at the end.
            seconds: How far to go [s].

        Raises:
            StoppedError: no step, however small, satisfies the equations or gives a state that can be meant; the twin
                is then back at the last good frame.
        """
        began = time.perf_counter()
        target = np.array([command.weight_on_bit, command.rotation])
        if self.books is not None:
            self.books.begin(*self.unknowns)
        self._guard.keep(*self.unknowns)
        self._observer.begin()
        found, intervention = self._attempt(target, seconds), None
        if found is None:
            self._guard.grow()
        else:
            intervention = self.retry_with_smaller_step(found, target, seconds)
        self.dynamics.command[:] = target
        self._recent.add(self.time, *self.unknowns)
        return self._observer.frame(seconds, time.perf_counter() - began, intervention, self._energy)

    def _attempt(self, target: Array, seconds: float) -> Violation | None:
        """Move on by `seconds`, and look at what has become of the string."""
        dynamics, guard, step = self.dynamics, self._guard, self._step_now(seconds)
        halvings = max_halvings(seconds, self.step_size)
        if not dynamics.advance(target, seconds, step, halvings):
            return guard.diverged(*self.unknowns, step, halvings if dynamics.too_many_halvings else None)
        depth, place = self._observer.look()
        load = max(abs(float(dynamics.command[0])), abs(float(target[0])))
        found = guard.find(*self.unknowns, depth, place, load, step)
        if found is None and self.books is not None:
            self._energy, grown = self.books.balance(*self.unknowns)
            found = guard.energy_drift(self._energy, grown)
        return found

    def retry_with_smaller_step(self, first: Violation, target: Array, seconds: float) -> Intervention:
        """Take back what was found and do it again with half the step, until nothing is found."""
        found: Violation | None = first
        tries = 0
        while found is not None:
            self._guard.rollback(*self.unknowns)
            start = self.time
            if self._guard.gives_up(found, tries):
                raise failure_report(
                    self.dynamics, found, self._guard.suspect, target, seconds, self._step_now(seconds)
                )
            tries += 1
            self._guard.halve()
            found = self._attempt(target, seconds)
        return self._guard.intervention(start, first, tries, self._step_now(seconds))

    def _step_now(self, seconds: float) -> float:
        """The time step for a frame of `seconds`, as the guard has it at present [s]."""
        return min(self.step_size, seconds) * self._guard.share
