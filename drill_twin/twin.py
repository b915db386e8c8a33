# SPDX-License-Identifier: Apache-2.0
"""The twin: a scene that moves.

>>> twin = Twin(load_scene("pa6_bench"))
>>> frame = twin.step(Command(weight_on_bit=40.0, rotation=12.6), seconds=0.01)
"""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from drill_twin.errors import RunError
from drill_twin.frame import Frame, MarkStates, RigState, StepStats
from drill_twin.rod.bit import BIT_TORQUE, BIT_WEIGHT, DRILLED, TOP_TORQUE
from drill_twin.rod.mesh import Rod, build_rod
from drill_twin.rod.types import Array
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.solve import lateral_assembly, state, work
from drill_twin.solve.bit_frame import bit_frame
from drill_twin.solve.compose import compose, effect_module, entry
from drill_twin.solve.drive import make_drive
from drill_twin.solve.hang import axial_weight, hang
from drill_twin.solve.midpoint import SMALLEST_SHARE
from drill_twin.solve.observe import DEEPEST, WHERE, make_probe, make_sight, observe
from drill_twin.solve.resolution import auto_elements, auto_step
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
NEWTON_PLACE, NEWTON_ANGLE = 1e-6, 1e-6  # last Newton change, in radii of the string and in radians


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
        RunError: from `step`, when the motion cannot be followed further.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        tubes = sections_of(scene)
        compression = _largest_compression(scene)
        numerics = scene.numerics
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
        self._kernel = compose(tuple(compiled), self.form, "straight" if self.site.bore.axis is None else "curved")
        self._advance: Callable[..., int] | None = None  # once compiled
        from_top = scene.rig.weight_on_bit.at == "top"
        drive = make_drive(scene, float(axial_weight(scene, self.site).sum()))
        self._parameters = self._kernel.Parameters(
            drive,
            *(effect_module(name).parameters(getattr(scene.effects, name), self.site) for name in compiled),
        )
        self._from_top, self._bit, self._driven = from_top, drive.bit, drive.driven > 0.0
        self._on_rock = from_top and bool(CARRIERS & set(self.effects))
        self._fixed = np.array([BIT_ENDS[scene.string.bit_end], CLAMPED_TOP])
        if from_top:
            self._fixed[0, 2], self._fixed[1, 2] = not self._on_rock, False
        self._fixed[1, 6] = not self._driven
        self._work = (work if self.form == SPATIAL else lateral_assembly).make_work(self.elements)
        self._state = state.make_state(self.elements)
        self._state.bit_frame[:] = bit_frame(axis_at(scene, np.array([scene.length])))
        self._limits = state.Limits(self.step_size, NEWTON_PLACE * float(rod.outer_radius.min()), NEWTON_ANGLE)
        self._counters = np.zeros(state.COUNTERS)
        self._wall: Any = getattr(self._parameters, "wall", None)
        marks = scene.string.marks
        places = np.array([m.distance_from_bit for m in marks])
        offset = np.array([place.wall_offset for place in scene.mark_table])
        self._probe = make_probe(rod, places, offset, axis_at(scene, scene.length - places))
        self._command = np.array([scene.rig.weight_on_bit.initial, 0.0])
        hang(self._state, self.site, scene, float(self._command[0]))
        for name in self.effects:
            start = getattr(effect_module(name), "start", None)
            if start is not None:
                start(getattr(scene.effects, name), self.site, self._state.u, self._state.v)

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

    def checkpoint(self) -> dict[str, Array]:
        """Copies of all that decides how the motion goes on, by name; `restore` takes them back."""
        return {name: array.copy() for name, array in self._memory()}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Go on from the `checkpoint` of a twin of the same scene."""
        for name, array in self._memory():
            array[...] = arrays[name]

    def _memory(self) -> Iterator[tuple[str, Array]]:
        yield from named_arrays("state", self._state)
        yield from named_arrays("effects", self._parameters)  # some of them remember
        yield from (("command", self._command), ("counters", self._counters))

    def step(self, command: Command, seconds: float) -> Frame:
        """Move on by `seconds`; the set-points go linearly from the last command to this one.

        Args:
            command: Weight on bit [N] and rotation [rad/s] to be reached at the end.
            seconds: How far to go [s].

        Raises:
            RunError: no step, however small, satisfies the equations.
        """
        began = time.perf_counter()
        target = np.array([command.weight_on_bit, command.rotation])
        before, impulse = self._counters.copy(), self._bit.impulse.copy()
        start = self.time
        advance = self._advance or self._kernel.advance
        status = advance(
            self._parameters, self.rod, self._work, self._fixed, self._state, self._limits,
            self._command, target, start, start + seconds, self._counters,
        )  # fmt: skip
        self._advance = self._advance or entry(self._kernel)
        if status != state.CONVERGED:
            raise self._failure()
        self._command = target
        return self._frame(self._counters - before, self._bit.impulse - impulse, seconds, time.perf_counter() - began)

    def _frame(self, counted: Array, impulse: Array, seconds: float, wall_seconds: float) -> Frame:
        u, v = self._state.u, self._state.v
        sight = make_sight(u.shape[0], self._probe.element.size)
        observe(self.rod, self.site.bore, self._wall, u, v, self._probe, sight)
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
            wall_depth_at=float(self.site.places[int(sight.nearness[WHERE])]),
            marks=marks, rig=self._rig(counted / seconds, impulse / seconds), stats=stats,
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

    def _failure(self) -> RunError:
        u, v = self._state.u, self._state.v
        node = int(np.argmax(np.nan_to_num(np.linalg.norm(v[:, :3], axis=1), nan=np.inf)))
        return RunError(
            f"the motion could not be followed past t = {self.time:.6g} s, even at a step of "
            f"{self.step_size * SMALLEST_SHARE:.2g} s: worst at node {node}, "
            f"{self.rod.arc[node]:.3g} m from the bit, lateral place {np.hypot(u[node, 0], u[node, 1]):.3g} m, "
            f"speed {np.linalg.norm(v[node, :3]):.3g} m/s, under {self._command[0]:.6g} N and "
            f"{self._command[1]:.6g} rad/s. Try a lower load (the string may have folded), a smaller numerics.step, "
            f"more elements, or a softer wall"
        )


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
