# SPDX-License-Identifier: Apache-2.0
"""The twin: a machine with a guard over it, that tells a frame at a time."""

import time
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from drill_twin.frame import EnergyBalance, Frame, Intervention
from drill_twin.guard import Guard, Violation, bounds_of, most_cuts
from drill_twin.rod.bit import DRILLED
from drill_twin.rod.mesh import Rod
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.solve.recent import Recent
from drill_twin.twin.books import Books
from drill_twin.twin.last_word import last_word
from drill_twin.twin.machine import LATERAL, Machine, take
from drill_twin.twin.observer import Observer


class Twin:
    """A drillstring that is turned and loaded; holds all state of a run.

    Attributes:
        scene: The scene.
        machine: What moves it.
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
        self.machine = machine = Machine(scene)
        lateral = machine.form == LATERAL
        self.books: Books | None = None
        if scene.numerics.audit == "energy":
            self.books = Books(machine.parameters.ledger, machine.effects, self.site, machine.wall, lateral=lateral)
        self._guard = Guard(bounds_of(scene, self.site, lateral=lateral), self.site, machine.wall)
        self._guard.watch(machine.block)
        self._observer = Observer(machine)
        self._energy: EnergyBalance | None = None
        self._recent = Recent(self.rod.arc.size, scene.numerics.frame_rate)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.machine.time

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.rod.length.size

    @property
    def step_size(self) -> float:
        """Nominal time step [s]."""
        return self.machine.step

    @property
    def effects(self) -> list[str]:
        """Keys of the effects that the scene lists."""
        return self.scene.effect_names

    @property
    def form(self) -> str:
        """Either "spatial", or "lateral" for a scene that calls for neither stretch nor torsion."""
        return self.machine.form

    @property
    def drilled(self) -> float:
        """Depth that the bit has drilled since the start [m]; 0 without `bit_cutting`."""
        return float(self.machine.parameters.drive.bit.impulse[DRILLED])

    @property
    def site(self) -> Site:
        """The string in its hole."""
        return self.machine.site

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.machine.rod

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self.machine.unknowns

    def meter(self) -> Callable[[str], float]:
        """Times an effect: by its name, what it takes of one Newton iteration now [s]; 0 for those that take none."""
        return self.machine.meter()

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
        yield from self.machine.memory()
        yield "guard", self._guard.memory

    def step(self, command: Command, seconds: float) -> Frame:
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
            intervention = self._insist(found, target, seconds)
        self.machine.command[:] = target
        self._recent.add(self.time, *self.unknowns)
        return self._observer.frame(seconds, time.perf_counter() - began, intervention, self._energy)

    def _attempt(self, target: Array, seconds: float) -> Violation | None:
        """Move on by `seconds`, and look at what has become of the string."""
        machine, guard, step = self.machine, self._guard, self._step_now(seconds)
        cuts = most_cuts(seconds, self.step_size)
        if not machine.advance(target, seconds, step, cuts):
            return guard.not_followed(*self.unknowns, step, cuts if machine.ground else None)
        depth, place = self._observer.look()
        load = max(abs(float(machine.command[0])), abs(float(target[0])))
        found = guard.find(*self.unknowns, depth, place, load, step)
        if found is None and self.books is not None:
            self._energy, grown = self.books.balance(*self.unknowns)
            found = guard.unaccounted(self._energy, grown)
        return found

    def _insist(self, first: Violation, target: Array, seconds: float) -> Intervention:
        """Take back what was found and do it again with half the step, until nothing is found."""
        found: Violation | None = first
        tries = 0
        while found is not None:
            self._guard.take_back(*self.unknowns)
            start = self.time
            if self._guard.gives_up(found, tries):
                raise last_word(self.machine, found, self._guard.suspect, target, seconds, self._step_now(seconds))
            tries += 1
            self._guard.halve()
            found = self._attempt(target, seconds)
        return self._guard.intervention(start, first, tries, self._step_now(seconds))

    def _step_now(self, seconds: float) -> float:
        """The time step for a frame of `seconds`, as the guard has it at present [s]."""
        return min(self.step_size, seconds) * self._guard.share
