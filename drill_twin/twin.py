# SPDX-License-Identifier: Apache-2.0
"""The twin: a scene that moves.

>>> twin = Twin(load_scene("pa6_bench"))
>>> frame = twin.step(Command(weight_on_bit=40.0, rotation=12.6), seconds=0.01)
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.errors import RunError
from drill_twin.frame import Frame, MarkStates, RigState, StepStats
from drill_twin.rod.mesh import Rod, Tube, build_rod
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.solve import lateral_assembly, state, work
from drill_twin.solve.compose import compose, effect_module, entry
from drill_twin.solve.drive import Drive
from drill_twin.solve.midpoint import SMALLEST_SHARE
from drill_twin.solve.observe import make_probe, make_sight, observe
from drill_twin.solve.resolution import auto_elements, auto_step

# Which of (r, r', psi) an end holds: x, y, z, x', y', z', psi.
BIT_ENDS = {
    "guided": (True, True, False, True, True, False, False),
    "pinned": (True, True, False, False, False, False, False),
    "sliding": (False, False, False, True, True, False, False),
    "free": (False, False, False, False, False, False, False),
}
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
        tubes = [Tube(s.length, s.outer_diameter, s.inner_diameter, s.youngs_modulus, s.poisson_ratio, s.density)
                 for s in scene.string.sections]  # fmt: skip
        compression = _largest_compression(scene)
        numerics = scene.numerics
        self.elements = auto_elements(tubes, compression) if numerics.elements == "auto" else int(numerics.elements)
        rod = build_rod(tubes, self.elements)
        self.elements = rod.length.size
        self.step_size = (
            auto_step(tubes, compression, _fastest(scene), 1.0 / numerics.frame_rate)
            if numerics.step == "auto"
            else float(numerics.step)
        )
        self.effects = list(scene.effect_names)
        compiled = [name for name in self.effects if hasattr(effect_module(name), "parameters")]
        self.site = Site(rod, scene.hole.radius, scene.hole.inclination)
        self.form = form_of(scene)
        self._kernel = compose(tuple(compiled), self.form)
        self._advance: Callable[..., int] | None = None  # once compiled
        from_top = scene.rig.weight_on_bit.at == "top"
        self._parameters = self._kernel.Parameters(
            Drive(1.0 if from_top else 0.0),
            *(effect_module(name).parameters(getattr(scene.effects, name), self.site) for name in compiled),
        )
        self._from_top = from_top
        self._fixed = np.array([BIT_ENDS[scene.string.bit_end], CLAMPED_TOP])
        if from_top:
            self._fixed[0, 2], self._fixed[1, 2] = True, False
        self._work = (work if self.form == SPATIAL else lateral_assembly).make_work(self.elements)
        self._state = state.make_state(self.elements)
        self._limits = state.Limits(self.step_size, NEWTON_PLACE * float(rod.outer_radius.min()), NEWTON_ANGLE)
        self._counters = np.zeros(state.COUNTERS)
        wall: Any = getattr(self._parameters, "wall", None)
        self._clearance = np.full(2 * self.elements, np.inf) if wall is None else wall.clearance
        self._stiffness = 0.0 if wall is None else float(wall.stiffness)
        self._torques = [
            (effect_module(name).bit_torque, getattr(self._parameters, name))
            for name in compiled
            if hasattr(effect_module(name), "bit_torque")
        ]
        marks = scene.string.marks
        self._probe = make_probe(rod, [m.distance_from_bit for m in marks], [m.on == "wall" for m in marks])
        self._command = np.array([scene.rig.weight_on_bit.initial, 0.0])
        _hang(self._state, rod, scene, float(self._command[0]))
        for name in self.effects:
            start = getattr(effect_module(name), "start", None)
            if start is not None:
                start(getattr(scene.effects, name), self.site, self._state.u, self._state.v)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._state.clock[state.TIME])

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.site.rod

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self._state.u, self._state.v

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
        before = self._counters.copy()
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
        return self._frame(self._counters - before, seconds, time.perf_counter() - began)

    def _frame(self, counted: Array, seconds: float, wall_seconds: float) -> Frame:
        u, v = self._state.u, self._state.v
        sight = make_sight(u.shape[0], self._probe.element.size)
        observe(self.rod.length, self.rod.shape, u, v, self._clearance, self._stiffness, self._probe, sight)
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
            marks=marks, rig=self._rig(counted / seconds), stats=stats,
        )  # fmt: skip

    def _rig(self, mean: Array) -> RigState:
        """The rig, with reactions averaged over the frame: single steps carry the ringing of unresolved waves."""
        u, v = self._state.u, self._state.v
        block = float(u[-1, 2])
        return RigState(
            top_drive_angle=float(u[-1, 6]), top_drive_speed=float(v[-1, 6]),
            top_drive_torque=float(mean[state.TORQUE_IMPULSE]),
            bit_angle=float(u[0, 6]), bit_speed=float(v[0, 6]), bit_torque=self._bit_torque(),
            bit_force=float(mean[state.BIT_IMPULSE]) if self._from_top else float(self._command[0]),
            block_position=block, block_velocity=float(v[-1, 2]),
            hookload=-float(self._command[0]) if self._from_top else float(mean[state.HOOK_IMPULSE]),
        )  # fmt: skip

    def _bit_torque(self) -> float:
        return sum(float(torque(block, self._command, self._state.v)) for torque, block in self._torques)

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


def form_of(scene: Scene) -> str:
    """Which unknowns a scene calls for: the string in space, or only its lateral motion."""
    return LATERAL if scene.effects.stretch is None and scene.effects.torsion is None else SPATIAL


def _largest_compression(scene: Scene) -> float:
    command = scene.rig.weight_on_bit
    return max(abs(command.value), abs(command.initial), 1.0)


def _fastest(scene: Scene) -> float:
    command = scene.rig.rotation
    return max(abs(command.value), abs(command.initial))


def _hang(state: state.State, rod: Rod, scene: Scene, weight_on_bit: float) -> None:
    """Start straight and in axial balance, so that the string's weight is not dropped on it at t = 0."""
    axial_weight = np.zeros(rod.length.size)
    gravity = getattr(scene.effects, "gravity", None)
    if gravity is not None:
        axial_weight = rod.line_mass * gravity.magnitude * np.cos(scene.hole.inclination)
    below = np.concatenate([[0.0], np.cumsum(axial_weight * rod.length)])
    tension = below - weight_on_bit
    if scene.rig.weight_on_bit.at == "top":
        tension = below - below[-1] - weight_on_bit
    stiffness = np.concatenate([rod.axial[:1], 0.5 * (rod.axial[1:] + rod.axial[:-1]), rod.axial[-1:]])
    stretch = np.cumsum(0.5 * (tension[1:] + tension[:-1]) / rod.axial * rod.length)
    state.u[:, 2] = rod.arc - rod.arc[-1] + np.concatenate([[0.0], stretch]) - stretch[-1]
    state.u[:, 5] = 1.0 + tension / stiffness
