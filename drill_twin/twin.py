# SPDX-License-Identifier: Apache-2.0
"""The twin: a scene that moves.

>>> twin = Twin(load_scene("pa6_bench"))
>>> frame = twin.step(Command(weight_on_bit=40.0, rotation=12.6), seconds=0.01)
"""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from drill_twin.balance import begin_in_balance
from drill_twin.books import Books
from drill_twin.errors import SceneError, StoppedError
from drill_twin.frame import EnergyBalance, Frame, Intervention, MarkStates, RigState, StepStats
from drill_twin.guard import NO_MATTER_OF_STEP, REMEDIES, SMALLEST, TRIES, Guard, Violation, bounds_of
from drill_twin.rod.bit import BIT_TORQUE, BIT_WEIGHT, DRILLED, TOP_TORQUE
from drill_twin.rod.mesh import Rod, build_rod
from drill_twin.rod.types import Array
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.solve import lateral_assembly, state, work
from drill_twin.solve.audit import make_ledger
from drill_twin.solve.bit_frame import bit_frame
from drill_twin.solve.blame import Moment, blame
from drill_twin.solve.compose import compose, effect_module, entry
from drill_twin.solve.drive import make_drive
from drill_twin.solve.hang import axial_weight, hang
from drill_twin.solve.meter import Meter
from drill_twin.solve.midpoint import SMALLEST_SHARE
from drill_twin.solve.observe import DEEPEST, WHERE, Sight, make_probe, make_sight, observe
from drill_twin.solve.recent import Recent
from drill_twin.solve.resolution import auto_elements, auto_step, newton_place
from drill_twin.solve.setting import axis_at, sections_of, site_of, tubes_of

# Which of (r, r', psi) an end holds: x, y, z, x', y', z', psi.
BIT_ENDS = {
    "guided": (True, True, False, True, True, False, False),
    "pinned": (True, True, False, False, False, False, False),
    "sliding": (False, False, False, True, True, False, False),
    "free": (False, False, False, False, False, False, False),
    "stabilised": (False, False, False, False, False, False, False),
}
CARRIERS = {"rock_floor", "bit_cutting"}
"""Effects that carry the bit where the weight is set at the top; without one it is held."""
CLAMPED_TOP = (True, True, True, True, True, False, True)


SPATIAL, LATERAL = "spatial", "lateral"


class Twin:
    """A drillstring that is turned and loaded; holds all state of a run.

    Attributes:
        scene: The scene.
        time: Simulated time [s].
        elements: Number of elements.
        step_size: Nominal time step [s].
        effects: The effects that are compiled in.
        form: "spatial", or "lateral" for a scene that calls for neither stretch nor torsion.

    Raises:
        StoppedError: from `step`, when the motion cannot be followed further; the twin is then back at the last good
            frame.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        tubes = sections_of(scene)
        compression = _largest_compression(scene)
        numerics = scene.numerics
        if numerics.accuracy is not None:
            raise SceneError(
                f"{scene.name}: expected numerics.elements and numerics.step, found numerics.accuracy, which only "
                "drill-twin run and the simulator node turn into them (drill_twin.study.accuracy.resolve)"
            )
        self.elements = auto_elements(tubes, compression) if numerics.elements == "auto" else int(numerics.elements)
        rod = build_rod(tubes_of(scene), self.elements)
        self.elements = rod.length.size
        self.step_size = (
            auto_step(tubes, compression, _fastest(scene), 1.0 / numerics.frame_rate)
            if numerics.step == "auto"
            else float(numerics.step)
        )
        self.effects = list(scene.effect_names)
        compiled = [name for name in self.effects if hasattr(effect_module(name), "parameters")]
        self.site = site_of(scene, rod)
        self.form = form_of(scene)
        hole, audit = "straight" if self.site.bore.axis is None else "curved", numerics.audit == "energy"
        self._kernel = compose(tuple(compiled), self.form, hole, audit=audit)
        self._compiled = compiled
        self._advance: Callable[..., int] | None = None  # once compiled
        from_top = scene.rig.weight_on_bit.at == "top"
        on_rock = from_top and bool(CARRIERS & set(self.effects))
        drive = make_drive(scene, float(axial_weight(scene, self.site).sum()))
        self._parameters = self._kernel.Parameters(
            drive,
            *(effect_module(name).parameters(getattr(scene.effects, name), self.site) for name in compiled),
            *([make_ledger(len(compiled), rod, bit_held=from_top and not on_rock)] if audit else []),
        )
        self._from_top, self._bit, self._driven = from_top, drive.bit, drive.driven > 0.0
        self._on_rock = on_rock
        self._fixed = np.array([BIT_ENDS[scene.string.bit_end], CLAMPED_TOP])
        if from_top:
            self._fixed[0, 2], self._fixed[1, 2] = not on_rock, False
        self._fixed[1, 6] = not self._driven
        self._work = (work if self.form == SPATIAL else lateral_assembly).make_work(self.elements)
        self._state = state.make_state(self.elements)
        self._state.bit_frame[:] = bit_frame(axis_at(scene, np.array([scene.length])))
        self._wall: Any = getattr(self._parameters, "wall", None)
        place = newton_place(scene.tolerance, rod, self._wall)
        self._limits = state.Limits(self.step_size, place, scene.tolerance)
        self._counters = np.zeros(state.COUNTERS)
        self._places = self.site.places
        marks = scene.string.marks
        places = np.array([m.distance_from_bit for m in marks])
        offset = np.array([place.wall_offset for place in scene.mark_table])
        self._probe = make_probe(rod, places, offset, axis_at(scene, scene.length - places))
        self._command = np.array([scene.rig.first[0], 0.0])
        hang(self._state, self.site, scene, float(self._command[0]))
        if scene.rig.start == "equilibrium":
            begin_in_balance(self, Twin)
        for name in self.effects:
            start = getattr(effect_module(name), "start", None)
            if start is not None:
                start(getattr(scene.effects, name), self.site, self._state.u, self._state.v)
        self._books: Books | None = None
        self._energy: EnergyBalance | None = None
        if audit:
            lateral = self.form == LATERAL
            self._books = Books(self._parameters.ledger, compiled, self.site, self._wall, lateral=lateral)
        self._guard = Guard(bounds_of(scene, self.site, lateral=self.form == LATERAL), self.site, self._wall)
        self._guard.watch([array for _, array in self._motion()])
        self._recent = Recent(self.rod.arc.size, scene.numerics.frame_rate)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._state.clock[state.TIME])

    @property
    def drilled(self) -> float:
        """Depth that the bit has drilled since the start [m]; 0 without `bit_cutting`."""
        return float(self._bit.impulse[DRILLED])

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.site.rod

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self._state.u, self._state.v

    def meter(self) -> Callable[[str], float]:
        """Times an effect: by its name, what it takes of one Newton iteration now [s]; 0 for those that take none."""
        names = self._kernel.Parameters._fields[1:]
        hole = "straight" if self.site.bore.axis is None else "curved"
        meter = Meter(names, self.form, hole, self._parameters, self.rod)

        def price(effect: str) -> float:
            u, v = self.unknowns
            return meter.price(effect, u, v, self._command, 0.5 * self.step_size) if effect in meter.effects else 0.0

        return price

    def checkpoint(self) -> dict[str, Array]:
        """Copies of all that decides how the motion goes on, by name; `restore` takes them back."""
        return {name: array.copy() for name, array in self._memory()}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Go on from the `checkpoint` of a twin of the same scene."""
        self._take(arrays)
        self._recent.forget()

    def _take(self, arrays: Mapping[str, Array]) -> None:
        for name, array in self._memory():
            array[...] = arrays[name]

    def last_second(self) -> tuple[Array, Array, Array]:
        """Times of the last frames [s], shape (k,), and their node rows u and v, shape (k, n + 1, 7); copies."""
        return self._recent.read()

    def _memory(self) -> Iterator[tuple[str, Array]]:
        yield from self._motion()
        yield "guard", self._guard.memory

    def _motion(self) -> Iterator[tuple[str, Array]]:
        yield from named_arrays("state", self._state)
        yield from named_arrays("effects", self._parameters)  # some of them remember
        yield from (("command", self._command), ("counters", self._counters))

    def step(self, command: Command, seconds: float) -> Frame:
        """Move on by `seconds`; the set-points go linearly from the last command to this one.

        Args:
            command: Weight on bit [N] and rotation [rad/s] to be reached at the end.
            seconds: How far to go [s].

        Raises:
            StoppedError: no step, however small, satisfies the equations or gives a state that can be meant.
        """
        began = time.perf_counter()
        target = np.array([command.weight_on_bit, command.rotation])
        before, impulse = self._counters.copy(), self._bit.impulse.copy()
        start, first, tries = self.time, None, 0
        if self._books is not None:
            self._books.begin(*self.unknowns)
        self._guard.keep(*self.unknowns)
        sight, found = self._attempt(target, start, seconds)
        while found is not None:
            first = first or found
            self._guard.take_back(*self.unknowns)
            enough = 1 if found.kind in NO_MATTER_OF_STEP else TRIES
            if tries >= enough or self._guard.share <= SMALLEST:
                raise self._stop(found, target, seconds)
            tries += 1
            self._guard.halve()
            sight, found = self._attempt(target, start, seconds)
        intervention = None
        if first is None:
            self._guard.grow()
        else:
            intervention = self._guard.intervention(start, first, tries, self._step_now(seconds))
        self._command[:] = target
        self._recent.add(self.time, *self.unknowns)
        counted, impulse = self._counters - before, self._bit.impulse - impulse
        return self._frame(sight, counted, impulse, seconds, time.perf_counter() - began, intervention)

    def _attempt(self, target: Array, start: float, seconds: float) -> tuple[Sight, Violation | None]:
        """Move on by `seconds`, and look at what has become of the string."""
        limits = self._limits
        if self._guard.share < 1.0:
            limits = limits._replace(step=self._step_now(seconds))
        status = self._advance_to(target, start, start + seconds, limits)
        u, v = self.unknowns
        sight = make_sight(u.shape[0], self._probe.element.size)
        if status != state.CONVERGED:
            return sight, self._not_followed()
        observe(self.rod, self.site.bore, self._wall, u, v, self._probe, sight)
        depth, place = float(sight.nearness[DEEPEST]), int(sight.nearness[WHERE])
        load = max(abs(float(self._command[0])), abs(float(target[0])))
        found = self._guard.find(u, v, depth, place, load, self._step_now(seconds))
        if found is None and self._books is not None:
            self._energy, grown = self._books.balance(u, v)
            found = self._guard.unaccounted(self._energy, grown)
        return sight, found

    def _advance_to(self, target: Array, start: float, end: float, limits: state.Limits) -> int:
        advance = self._advance or self._kernel.advance
        status = advance(
            self._parameters, self.rod, self._work, self._fixed, self._state, limits,
            self._command, target, start, end, self._counters,
        )  # fmt: skip
        self._advance = self._advance or entry(self._kernel)
        return status

    def begin(self, u: Array, v: Array, command: Command) -> None:
        """Take up a state: node rows, their velocities, shapes (n + 1, 7), and the set-points that are in force."""
        self._state.u[:], self._state.v[:] = u, v
        self._state.clock[state.KNOWN] = 0.0
        self._command[:] = command.weight_on_bit, command.rotation

    def leap(self, seconds: float) -> bool:
        """One step from rest to rest under the last command: the middle of a midpoint step is backward Euler's end.

        Returns:
            False, and nothing moved, where Newton's method fails.
        """
        u, v = self._state.u, self._state.v
        before, cuts = u.copy(), self._counters[state.CUTS]
        self.begin(u, np.zeros_like(v), Command(float(self._command[0]), 0.0))
        limits = self._limits._replace(step=seconds)
        status = self._advance_to(self._command.copy(), self.time, self.time + seconds, limits)
        whole = status == state.CONVERGED and self._counters[state.CUTS] == cuts
        u[:] = 0.5 * (before + u) if whole else before
        v[:] = 0.0
        return bool(whole)

    def _step_now(self, seconds: float) -> float:
        """The time step for a frame of `seconds`, as the guard has it at present [s]."""
        return min(self.step_size, seconds) * self._guard.share

    def _frame(
        self, sight: Sight, counted: Array, impulse: Array, seconds: float, wall_seconds: float,
        intervention: Intervention | None,
    ) -> Frame:  # fmt: skip
        u, v = self._state.u, self._state.v
        marks = MarkStates(
            position=sight.position, velocity=sight.velocity, spin=sight.spin, spin_rate=sight.spin_rate,
            wall_force=sight.mark_force, centre=sight.centre,
        )  # fmt: skip
        stats = StepStats(
            steps=int(counted[state.STEPS]), iterations=int(counted[state.ITERATIONS]),
            cut_steps=int(counted[state.CUTS]), wall_seconds=wall_seconds,
        )  # fmt: skip
        return Frame(
            time=self.time, positions=u[:, 0:3].copy(), velocities=v[:, 0:3].copy(), tangents=sight.tangents,
            spin=u[:, 6].copy(), spin_rate=v[:, 6].copy(), wall_force=sight.wall_force,
            wall_depth=float(sight.nearness[DEEPEST]),
            wall_depth_at=float(self._places[int(sight.nearness[WHERE])]),
            marks=marks, rig=self._rig(counted / seconds, impulse / seconds), stats=stats, intervention=intervention,
            energy=self._energy,
        )  # fmt: skip

    def _rig(self, mean: Array, ends: Array) -> RigState:
        """The rig, with reactions averaged over the frame: single steps carry the ringing of unresolved waves."""
        u, v = self._state.u, self._state.v
        block = float(u[-1, 2])
        weight = mean[state.BIT_IMPULSE] if self._from_top and not self._on_rock else ends[BIT_WEIGHT]
        return RigState(
            top_drive_angle=float(u[-1, 6]), top_drive_speed=float(v[-1, 6]),
            top_drive_torque=float(ends[TOP_TORQUE] if self._driven else mean[state.TORQUE_IMPULSE]),
            bit_angle=float(u[0, 6]), bit_speed=float(v[0, 6]), bit_torque=float(ends[BIT_TORQUE]),
            bit_force=float(weight) if self._from_top else float(self._command[0]),
            block_position=block, block_velocity=float(v[-1, 2]),
            hookload=-float(self._command[0]) if self._from_top else float(mean[state.HOOK_IMPULSE]),
        )  # fmt: skip

    def _not_followed(self) -> Violation:
        u, v = self._state.u, self._state.v
        node = int(np.argmax(np.nan_to_num(np.linalg.norm(v[:, :3], axis=1), nan=np.inf)))
        smallest = self.step_size * self._guard.share * SMALLEST_SHARE
        return Violation(
            "newton", node,
            f"the equations had no solution, even at a step of {smallest:.2g} s; fastest was {self._guard.at(node)}, "
            f"{np.hypot(u[node, 0], u[node, 1]):.3g} m off the axis at {np.linalg.norm(v[node, :3]):.3g} m/s",
        )  # fmt: skip

    def _stop(self, found: Violation, target: Array, seconds: float) -> StoppedError:
        """The last word about a frame that could not be done; the state is the last good one again."""
        good, suspect = self.unknowns, self._guard.suspect
        states = [good, (suspect[0], suspect[1])] if np.isfinite(suspect).all() else [good]
        step = self._step_now(seconds)
        moments = [
            Moment(u, v, time, step, command)
            for u, v in states
            for time, command in ((self.time + 0.5 * step, self._command), (self.time + seconds, target))
        ]
        kept = self.checkpoint()  # to ask an effect may change what it remembers
        effect, doing = blame(self._parameters, self.rod, self._compiled, moments)
        self._take(kept)
        return StoppedError(
            f"the motion could not be followed past t = {self.time:.6g} s, however often it was "
            f"taken back and the step halved, down to {step:.2g} s: {found.text}, under {target[0]:.6g} N and "
            f"{target[1]:.6g} rad/s{f'; {doing}' if doing else ''}. "
            f"{REMEDIES['finite' if 'no number' in doing else found.kind].capitalize()}",
            self.time, found.kind, found.node, effect,
        )  # fmt: skip


def named_arrays(name: str, value: object) -> Iterator[tuple[str, Array]]:
    """Arrays in nested named tuples, each with its dotted name."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for field, item in zip(getattr(value, "_fields", map(str, range(len(value)))), value, strict=True):
            yield from named_arrays(f"{name}.{field}", item)


def form_of(scene: Scene) -> str:
    """Which unknowns a scene calls for: the string in space, or only its lateral motion."""
    return LATERAL if scene.effects.stretch is None and scene.effects.torsion is None else SPATIAL


def _largest_compression(scene: Scene) -> float:
    command = scene.rig.weight_on_bit
    return max(abs(command.value), abs(command.initial), 1.0)


def _fastest(scene: Scene) -> float:
    command = scene.rig.rotation
    return max(abs(command.value), abs(command.initial))
