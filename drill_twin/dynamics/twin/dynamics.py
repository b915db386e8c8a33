# SPDX-License-Identifier: Apache-2.0
"""Dynamics of a scene: its compiled kernel with the arrays of state, parameters and workspace."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.packed_arguments import (
    Packed,
    named_arrays,
    pack,
    pack_arrays,
    replace_numbers,
    undispatched,
)
from drill_twin.dynamics.audit.energy import Energy, energy, joined_energy, lateral_energy
from drill_twin.dynamics.audit.energy_ledger import make_energy_ledger
from drill_twin.dynamics.discretisation.discretise import set_initial_state, survey_of
from drill_twin.dynamics.discretisation.kernel_arguments import (
    JOINED,
    LATERAL,
    SPATIAL,
    KernelArguments,
    effects_of,
    form_of,
)
from drill_twin.dynamics.discretisation.resolution import newton_place, resolution_of
from drill_twin.dynamics.equilibrium import begin_turning, start_in_equilibrium
from drill_twin.dynamics.solver import slices, state
from drill_twin.dynamics.solver.kernel_codegen import build_kernel
from drill_twin.dynamics.twin.binding import bounds_of, memories, reactions_of
from drill_twin.dynamics.twin.frame_kernel import BoundTwin
from drill_twin.dynamics.twin.frame_record import row_type
from drill_twin.physics.effects import Effect, effect_module
from drill_twin.physics.model import SPIN, Rod
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command


class Dynamics(KernelArguments):
    """Kernel of a scene and its state, initialised as in `rig.start`.

    Attributes:
        parameters: Parameters of drive and effects, and the ledger of an audit.
        step: Nominal time step [s].
        command: Set-points last reached, a `drill_twin.scene.set_points.Command`, shape (3,).
        counters: See `drill_twin.dynamics.solver.state`.
        memory_block: Bytes of all arrays of the state, shape (size,).
        progress: Progress of an advance, see `drill_twin.dynamics.solver.state`.
        bound: Arguments of the compiled frame loop, with the parameters in force.
    """

    bound: BoundTwin
    _packed: Packed

    def __init__(self, scene: Scene, rod: Rod | None = None) -> None:
        """Build the model, load or compile the kernel, and set the initial state.

        Args:
            scene: The scene.
            rod: The meshed string; by default the scene's mesh, whose nodes depend on the scene's largest set-points.

        Raises:
            SceneError: The scene asks for an accuracy instead of elements and a step.
            TableError: Elements or step are to be chosen for a record that cannot be used.
            RunError: No equilibrium or steady whirl was found to start from.
        """
        super().__init__(scene, rod)
        self.step, audit = resolution_of(scene)[1], scene.numerics.audit == "energy"
        self.kernel = build_kernel(self.effects, self.form, self.hole, audit=audit)
        ends = self.boundary_conditions
        held = ends.weight_at_top and not ends.bit_on_rock
        ledger = [make_energy_ledger(len(self.effects), self.rod, bit_held=held)] if audit else []
        command, counters = np.zeros(3), np.zeros(state.COUNTERS)
        command[0] = scene.rig.first[0]
        axial = getattr(self._work, "axial", ())  # the last sum of weights is used in the next step
        memory, self.memory_block = pack_arrays(
            (self.parameters_for(self.kernel, scene, *ledger), self._state, command, counters, axial)
        )
        self.parameters, self._state, self.command, self.counters, axial = memory
        if self.form == LATERAL:
            self._work = self._work._replace(axial=axial)
        self.progress = slices.make_progress()
        impulse = self.parameters.drive.bit.impulse
        self._memories = memories(
            scene, self.model, self.counters, impulse, self.stress, getattr(self._work, "side", np.zeros(0))
        )
        self._saved = self.memory_block.copy()
        self._run: Callable[..., int] | None = None  # once compiled
        self._kind: Any = None
        self.set_parameters(self.parameters)
        self._set_initial_state()

    def set_parameters(self, parameters: Any) -> None:
        """Take parameters of drive and effects, and the tolerance of Newton's method that their stiffness asks for."""
        self.parameters = parameters
        blades = getattr(parameters, "bit_stabiliser", None)
        place = newton_place(self.scene.tolerance, self.rod, self.wall, getattr(blades, "stiffness", 0.0))
        self._control = state.StepControl(self.step, place, self.scene.tolerance, 0)
        self.bound = self._bind()
        self._packed = pack(self.bound, self._kind)
        self._kind = self._packed.kind  # other numbers change no type

    def change_numbers(self, scene: Scene) -> None:
        """Take the numbers of another scene, which differs in effects and drive only; the state stays.

        Parameters and memory of an effect share its arrays. What differs between the parameters of both scenes, each
        fresh, is a number and is replaced; the rest is memory and stays.

        Args:
            scene: The other scene, with the same kernel and string, and without an audit, whose ledger depends on no
                number.
        """
        before, after = (self.parameters_for(self.kernel, each) for each in (self.scene, scene))
        self.scene = scene
        self.set_parameters(replace_numbers(self.parameters, before, after))

    def _set_initial_state(self) -> None:
        set_initial_state(self._state, self.model, self.scene, float(self.command[0]))
        if self.scene.rig.start == "equilibrium":
            start_in_equilibrium(self, Dynamics)
        elif self.scene.rig.start == "rotating":
            from drill_twin.dynamics.torque_drag.sliding_balance import rotating_rows  # here, for its use of scipy

            begin_turning(self, Dynamics, rotating_rows(self.scene, self.rod).copy())
        elif self.scene.rig.start == "whirl-state":
            from drill_twin.dynamics.rotordynamics.steady.whirl_states import (
                start_in_whirl,  # here, for its use of scipy
            )

            self.begin(*start_in_whirl(self.scene))
        for name in self.scene.effect_names:
            module = effect_module(name)
            if hasattr(module, "initial_state"):
                module.initial_state(getattr(self.scene.effects, name), self.model, *self.unknowns)
        if self.form == JOINED:  # from the joint up the string follows the hole, where a kick does not push it
            self._state.v[self._work.below.diagonal.shape[0] - 1 :, [0, 1, 3, 4]] = 0.0

    @property
    def wall(self) -> Any:
        """Parameters of the wall; None if the scene lists none."""
        return getattr(self.parameters, "wall", None)

    @property
    def stress(self) -> Array | None:
        """Sections of the effect `fatigue`, a view, as `drill_twin.dynamics.twin.frame.Frame.stress`; None without
        it.
        """
        fatigue = getattr(self.parameters, "fatigue", None)
        return None if fatigue is None else fatigue.seen

    def row_type(self, *, whole: bool) -> Any:
        """Numpy's type of a recorded frame (`drill_twin.dynamics.twin.frame_record`)."""
        sections = 0 if self.stress is None else len(self.stress)
        return row_type(self.rod.arc.size, len(self.scene.string.marks), sections, whole=whole)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._state.clock[state.TIME])

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self._state.u, self._state.v

    def arrays(self) -> Iterator[tuple[str, Array]]:
        """Yield the arrays of the state, not copies, each with its name in checkpoints."""
        yield from named_arrays("state", self._state)
        # some effects have a state; indices have none, and no file may set an index
        yield from (pair for pair in named_arrays("effects", self.parameters) if pair[1].dtype != np.int64)
        yield from (("command", self.command), ("counters", self.counters))
        if self.form == LATERAL:
            yield "work.axial", self._work.axial

    def _bind(self) -> BoundTwin:
        model, wall = self.model, self.wall
        return BoundTwin(
            parameters=self.parameters, rod=self.rod, hole=model.wellbore, wall=wall, scratch=self._work,
            constrained=self.constrained, state=self._state, control=self._control, command=self.command,
            progress=self.progress, memory=self.memory_block.view(np.int64), saved=self._saved.view(np.int64),
            reactions=reactions_of(self.boundary_conditions),
            bounds=bounds_of(self.scene, model, wall, lateral=self.form == LATERAL), **self._memories,
        )  # fmt: skip

    def run(self, commands: Array, seconds: float, step: float, table: Array, iterations: Callable[[], float]) -> int:
        """Advance by frames in compiled code, which returns after each slice, so that signals are handled.

        `drill_twin.dynamics.solver.slices.checked` may end it between two slices.

        Args:
            commands: Set-points at the end of each frame, shape (F, 3).
            seconds: Length of a frame [s].
            step: Nominal time step [s].
            table: The record (`frame_kernel.bind`).
            iterations: Newton iterations of the next slice; 0 to leave the rest undone.

        Returns:
            Outcome of the last frame; PAUSED where the rest was left undone.
        """
        arguments = *self._packed[:2], commands, float(seconds), float(step), table  # the compiled types
        status = state.PAUSED
        try:
            while status == state.PAUSED and (allowed := iterations()) > 0.0:
                self.progress[state.ITERATIONS_LEFT] = allowed
                self._run = self._run or undispatched(self.kernel.run, *arguments)
                status = self._run(*arguments)
                if status == state.PAUSED:
                    slices.call_check()
        finally:
            self.progress[state.NEXT_STEP] = 0.0
        return status

    def roll_back(self) -> None:
        """Restore the state at the start of the frame."""
        np.copyto(self.memory_block, self._saved)

    def advance(self, target: Array, seconds: float, step: float | None = None) -> bool:
        """Advance in time, unjudged; the set-points change linearly from `command`, which is not updated, to `target`.

        Args:
            target: Set-points at the end, shape (3,).
            seconds: Time to advance [s].
            step: Time step [s]; the nominal one if not given.

        Returns:
            False if Newton's method fails at the smallest step, or the step is halved too often.
        """
        iterations = slices.iterations_of(self.rod.length.size)
        slices.call_check()  # between the many short slices of a search for an equilibrium
        self.bound.course[:] = 0
        step = self.step if step is None else step
        return self.run(target.reshape(1, -1), seconds, step, np.zeros((0, 0)), lambda: iterations) == state.CONVERGED

    def energy_of(self, u: Array, v: Array) -> Energy:
        """Energy of node rows (r, r', psi) and their velocities, shape (n + 1, 7) each, as the kernel samples it."""
        if self.form == LATERAL:
            return lateral_energy(self.rod, u, v)
        return energy(self.rod, u, v) if self.form == SPATIAL else joined_energy(self.rod, self._work, u, v)

    def largest_change(self) -> int:
        """Node with the largest change, in tolerances, of the last Newton iteration."""
        if self.form == JOINED:
            below, change = np.abs(self._work.below.diagonal[:, :, 7]), np.abs(self._work.change[1:])
            changes = np.vstack((below, np.zeros((len(change), 7))))
            changes[len(below) :, [2, 5, SPIN]] = change
        else:
            changes = np.abs(self._work.diagonal[:, :, 7] if self.form == SPATIAL else self._work.right)
        places = 2 if self.form == LATERAL else 3
        sizes = np.hstack((changes[:, :places] / self._control.position, changes[:, places:] / self._control.angle))
        return int(np.nan_to_num(sizes, nan=np.inf).max(axis=1).argmax())

    def begin(self, u: Array, v: Array, command: Command) -> None:
        """Set the state, node rows and their velocities, shape (n + 1, 7) each, and the set-points in force."""
        self._state.u[:], self._state.v[:] = u, v
        self._state.clock[state.KNOWN] = 0.0
        self.command[:] = command

    def pseudo_transient_step(self, seconds: float) -> bool:
        """Take a backward Euler step from rest to rest under the last command: the first half of a midpoint step.

        Returns:
            False, with the state unchanged, if Newton's method fails.
        """
        u, v = self.unknowns
        before, halvings = u.copy(), self.counters[state.HALVINGS]
        self.begin(u, np.zeros_like(v), Command(float(self.command[0]), 0.0))
        converged = self.advance(self.command.copy(), seconds, step=seconds)
        whole = converged and self.counters[state.HALVINGS] == halvings
        u[:] = 0.5 * (before + u) if whole else before
        v[:] = 0.0
        return bool(whole)


def kernel_of(scene: Scene) -> tuple[tuple[Effect, ...], str, str, bool]:
    """Properties that select a scene's kernel: effects, formulation, "straight" or "curved" hole, audit."""
    hole = "straight" if survey_of(scene.hole) is None else "curved"
    return effects_of(scene), form_of(scene), hole, scene.numerics.audit == "energy"
