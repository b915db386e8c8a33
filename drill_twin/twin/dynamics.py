# SPDX-License-Identifier: Apache-2.0
"""What moves the string: the compiled kernel of a scene with every array that it works on, and nothing that judges."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from drill_twin.audit.effect_timing import EffectTimer
from drill_twin.audit.energy_ledger import make_energy_ledger
from drill_twin.base.arrays import Array
from drill_twin.discretisation.boundary_conditions import Ends
from drill_twin.discretisation.discretise import axis_at, discretise, sections_of, tubes_of
from drill_twin.discretisation.drive import make_drive
from drill_twin.discretisation.initial_state import axial_weight, set_initial_state
from drill_twin.discretisation.resolution import auto_elements, auto_step, newton_place
from drill_twin.effects import effect_module
from drill_twin.errors import SceneError
from drill_twin.model.mesh import Rod, build_rod
from drill_twin.scene import Scene
from drill_twin.schedule import Command, extremes
from drill_twin.solver import state
from drill_twin.solver.boundary.bit_frame import bit_frame
from drill_twin.solver.kernel_codegen import build_kernel, entry_point
from drill_twin.solver.lateral.assembly import make_workspace as make_lateral_workspace
from drill_twin.solver.spatial.workspace import make_workspace
from drill_twin.statics.static_start import start_in_equilibrium
from drill_twin.twin.memory import named_arrays, pack_arrays

SPATIAL, LATERAL = "spatial", "lateral"
AXIAL = "work.axial"
"""Array of a lateral string's memory that checkpoints of drill_twin 0.1.0 lack."""
HALVINGS = 1000
"""How often the step may be cut where nobody says."""


class Dynamics:
    """The kernel of a scene and its memory; it begins as `rig.start` says.

    Attributes:
        scene: The scene.
        model: The string in its hole.
        ends: How its ends are held and driven.
        form: "spatial", or "lateral" for a scene that calls for neither stretch nor torsion.
        hole: "straight" or "curved".
        effects: Keys of the effects in the kernel, in the order of their parameters.
        parameters: What the kernel takes besides the string: drive, effects, ledger of an audit.
        step: Nominal time step [s].
        command: Set-points last reached: weight on bit [N], rotation [rad/s].
        counters: See `drill_twin.solver.state`.
        too_many_halvings: Whether the last advance ended because the step was cut too often.
        block: The bytes of all that decides how the motion goes on, shape (size,).
    """

    def __init__(self, scene: Scene) -> None:
        """Compile what the scene calls for, or take it from where compiled code is kept.

        Raises:
            SceneError: The scene asks for an accuracy instead of elements and a step.
            TableError: Elements or step are to be chosen for a record that cannot be played.
            RunError: It is to begin in balance, and none was found.
        """
        self.scene = scene
        elements, self.step = _resolution(scene)
        rod = build_rod(tubes_of(scene), elements)
        self.model, self.ends, self.form = discretise(scene, rod), Ends.of(scene), form_of(scene)
        self.hole = "straight" if self.model.wellbore.axis is None else "curved"
        self.effects = tuple(name for name in scene.effect_names if hasattr(effect_module(name), "parameters"))
        audit = scene.numerics.audit == "energy"
        self.kernel = build_kernel(self.effects, self.form, self.hole, audit=audit)
        parameters = self.kernel.Parameters(
            make_drive(scene, float(axial_weight(scene, self.model).sum())),
            *(effect_module(name).parameters(getattr(scene.effects, name), self.model) for name in self.effects),
            *([make_energy_ledger(len(self.effects), rod, bit_held=self._bit_is_held)] if audit else []),
        )
        self._held = self.ends.held(scene.string.bit_end)
        self._work: Any = (make_workspace if self.form == SPATIAL else make_lateral_workspace)(rod.length.size)
        self._advance: Callable[..., int] | None = None  # once compiled
        command, counters = np.array([scene.rig.first[0], 0.0]), np.zeros(state.COUNTERS)
        memory, self.block = pack_arrays((parameters, state.make_state(rod.length.size), command, counters))
        self.parameters, self._state, self.command, self.counters = memory
        self.too_many_halvings = False
        self._state.bit_frame[:] = bit_frame(axis_at(scene, np.array([scene.length])))
        self._limits = state.Limits(self.step, newton_place(scene.tolerance, rod, self.wall), scene.tolerance, HALVINGS)
        self._set_off()

    def _set_off(self) -> None:
        set_initial_state(self._state, self.model, self.scene, float(self.command[0]))
        if self.scene.rig.start == "equilibrium":
            start_in_equilibrium(self, Dynamics)
        for name in self.scene.effect_names:
            module = effect_module(name)
            if hasattr(module, "initial_state"):
                module.initial_state(getattr(self.scene.effects, name), self.model, *self.unknowns)

    @property
    def _bit_is_held(self) -> bool:
        return self.ends.from_top and not self.ends.on_rock

    @property
    def wall(self) -> Any:
        """Parameters of the wall; None without one."""
        return getattr(self.parameters, "wall", None)

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.model.rod

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._state.clock[state.TIME])

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows (r, r', psi) and their velocities, each shape (n + 1, 7); views, not copies."""
        return self._state.u, self._state.v

    def memory(self) -> Iterator[tuple[str, Array]]:
        """All that decides how the motion goes on: the arrays themselves, each with its name."""
        yield from named_arrays("state", self._state)
        yield from named_arrays("effects", self.parameters)  # some of them remember
        yield from (("command", self.command), ("counters", self.counters))
        if self.form == LATERAL:
            yield AXIAL, self._work.axial  # the weight last summed begins the next step

    def advance(self, target: Array, seconds: float, step: float | None = None, max_halvings: int = HALVINGS) -> bool:
        """Move on; the set-points go linearly from `command`, which is left as it is, to `target`.

        Args:
            target: Weight on bit [N] and rotation [rad/s] to be reached at the end.
            seconds: How far to go [s].
            step: Time step [s]; the nominal one if not given.
            max_halvings: How often it may be cut.

        Returns:
            False where no step, however small, satisfies the equations, or it was halved too often; then
            `too_many_halvings` is true.
        """
        limits = self._limits._replace(step=self.step if step is None else step, max_halvings=max_halvings)
        advance = self._advance or self.kernel.advance
        start = self.time
        status = advance(
            self.parameters, self.rod, self._work, self._held, self._state, limits,
            self.command, target, start, start + seconds, self.counters,
        )  # fmt: skip
        self._advance = self._advance or entry_point(self.kernel)
        self.too_many_halvings = status == state.TOO_MANY_HALVINGS
        return status == state.CONVERGED

    def begin(self, u: Array, v: Array, command: Command) -> None:
        """Take up a state: node rows, their velocities, shapes (n + 1, 7), and the set-points that are in force."""
        self._state.u[:], self._state.v[:] = u, v
        self._state.clock[state.KNOWN] = 0.0
        self.command[:] = command.weight_on_bit, command.rotation

    def pseudo_transient_step(self, seconds: float) -> bool:
        """One step from rest to rest under the last command: the middle of a midpoint step is backward Euler's end.

        Returns:
            False, and nothing moved, where Newton's method fails.
        """
        u, v = self.unknowns
        before, halvings = u.copy(), self.counters[state.HALVINGS]
        self.begin(u, np.zeros_like(v), Command(float(self.command[0]), 0.0))
        converged = self.advance(self.command.copy(), seconds, step=seconds)
        whole = converged and self.counters[state.HALVINGS] == halvings
        u[:] = 0.5 * (before + u) if whole else before
        v[:] = 0.0
        return bool(whole)

    def meter(self) -> Callable[[str], float]:
        """Times an effect: by its name, what it takes of one Newton iteration now [s]; 0 for those that take none."""
        meter = EffectTimer(self.parameters._fields[1:], self.parameters, self.rod)

        def price(effect: str) -> float:
            return (
                meter.price(effect, *self.unknowns, self.command, 0.5 * self.step) if effect in meter.effects else 0.0
            )

        return price


def take(memory: Iterator[tuple[str, Array]], arrays: Mapping[str, Array]) -> None:
    """Fill the arrays of a memory from those of the same names; `AXIAL` may be missing."""
    for name, array in memory:
        array[...] = arrays.get(name, array) if name == AXIAL else arrays[name]


def form_of(scene: Scene) -> str:
    """Which unknowns a scene calls for: the string in space, or only its lateral motion."""
    return LATERAL if scene.effects.stretch is None and scene.effects.torsion is None else SPATIAL


def _resolution(scene: Scene) -> tuple[int, float]:
    """Number of elements and time step [s], as written or sought."""
    numerics = scene.numerics
    if numerics.accuracy is not None:
        raise SceneError(
            f"{scene.name}: expected numerics.elements and numerics.step, found numerics.accuracy, which only "
            "drill-twin run and the simulator node turn into them (drill_twin.accuracy.resolve)"
        )
    if "auto" not in (numerics.elements, numerics.step):
        return int(numerics.elements), float(numerics.step)
    tubes, most = sections_of(scene), extremes(scene)  # of a record too, which is read for it
    compression = max(most.weight_on_bit, 1.0)
    elements = auto_elements(tubes, compression) if numerics.elements == "auto" else int(numerics.elements)
    if numerics.step == "auto":
        return elements, auto_step(tubes, compression, most.rotation, 1.0 / numerics.frame_rate)
    return elements, float(numerics.step)
