# SPDX-License-Identifier: Apache-2.0
"""Equations of motion of a scene at one instant: residual, mass, damping and stiffness, from its compiled effects.

The imperfections that turn with the string (`bow`, `eccentricity`) are set to zero here: what is left looks the same
from every direction, unless the hole is inclined. An effect that depends on time itself is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.packed_arguments import undispatched
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.discretisation.discretise import set_initial_state
from drill_twin.dynamics.discretisation.kernel_arguments import KernelArguments
from drill_twin.dynamics.rotordynamics.block_rows import BlockRows
from drill_twin.dynamics.rotordynamics.eigenvalues import Delay, Pencil
from drill_twin.dynamics.solver.boundary import LAG
from drill_twin.dynamics.solver.kernel_codegen import build_linearisation
from drill_twin.physics.effects.bit_regenerative import READY, Regeneration, regeneration
from drill_twin.physics.model import SPIN, Rod
from drill_twin.physics.model.bit import INITIAL, WEIGHT
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

TIME_DEPENDENT = {
    "random_force": "a random force",
    "top_shake": "a shaken top",
    "bit_side_force": "a force of fixed direction at the bit",
}
"""Effects without a place in a steady state, and what they are."""
TURNING_ARRAYS = {"bow": ("moment",), "eccentricity": ("imbalance", "inertia"), "discs": ("unbalance",)}
"""Effects and discs that turn with the string and break the symmetry, and the arrays of their parameters."""
COLUMNS = {"lateral": np.array([0, 1, 3, 4]), "spatial": np.arange(7)}
"""Columns of the unknowns in a node's row of seven."""


@dataclass(frozen=True, eq=False)
class Linearised:
    """Residual and its derivatives by acceleration, velocity and position; m free unknowns."""

    residual: Array
    """Forces out of balance [N, N m], shape (m,)."""
    tangents: Array
    """Mass, damping and stiffness as block rows, shape (3, n + 1, k, 3 k)."""
    rows: BlockRows
    """Operations on them."""

    @cached_property
    def matrices(self) -> Pencil:
        """Mass, damping (derivative by the velocity) and stiffness (by the position), shape (m, m) each."""
        return Pencil(*map(self.rows.dense, self.tangents))

    @property
    def sparse(self) -> Pencil:
        """Mass, damping and stiffness as sparse matrices, for a long string."""
        return Pencil(*map(self.rows.sparse, self.tangents))


def without(scene: Scene, effects: Sequence[str]) -> Scene:
    """The scene without some of its effects.

    Raises:
        SceneError: The scene does not list one of the effects, or an effect that stays needs it.
    """
    for key in effects:
        if key not in scene.effect_names:
            raise SceneError(
                f"--without: expected an effect of the scene ({', '.join(scene.effect_names)}), found {key}"
            )
    for key in set(scene.effect_names).difference(effects):
        for needed in set(effects).intersection(getattr(scene.effects, key).requires):
            raise SceneError(
                f"--without {needed}: expected no effect that needs it, found {key}; --without {key} leaves it out too"
            )
    return scene.model_copy(update={"effects": scene.effects.model_copy(update=dict.fromkeys(effects))})


def meshed(scene: Scene, elements: int) -> Scene:
    """The scene with another number of elements."""
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"elements": elements})})


def refuse_time_dependent(scene: Scene) -> None:
    """Raise for an effect that depends on time itself.

    Raises:
        SceneError: There is one; the message says how to leave it out.
    """
    found = [key for key in scene.effect_names if key in TIME_DEPENDENT]
    if found:
        named = ", ".join(f"{key} ({TIME_DEPENDENT[key]})" for key in found)
        raise SceneError(
            f"{scene.name}: expected effects constant in a turning frame, found {named}; "
            f"{' '.join(f'--without {key}' for key in found)} leaves {'it' if len(found) == 1 else 'them'} out"
        )
    if scene.rig.block is not None:
        raise SceneError(
            f"{scene.name}: expected a weight set at the bit or the top, found a block that moves; take "
            "rig.weight_on_bit.at: top and no rig.block"
        )
    cutting = getattr(scene.effects, "bit_cutting", None)
    if cutting is not None and cutting.rock_stiffness is not None:
        raise SceneError(
            f"{scene.name}: expected a bit whose rock is at rest, found bit_cutting with a rock_stiffness, whose "
            "surface goes down while it drills; set the weight at the bit (rig.weight_on_bit.at: bit)"
        )


def moving_everywhere(scene: Scene) -> Scene:
    """The scene with lateral motion of the whole string, whatever its runs leave out."""
    if scene.numerics.lateral_from == 0.0:
        return scene
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"lateral_from": 0.0})})


class EquationsOfMotion(KernelArguments):
    """The compiled equations of a scene, for any position, velocity and acceleration of the string.

    The whole string moves laterally.

    Attributes:
        parameters: Parameters of drive and effects; replace numbers by `_replace`, arrays in place.
        free: Mask of the unknowns that are not constrained, shape (n + 1, k) with k unknowns a node.
        block_rows: Operations on block rows of the tangents.
        unknowns: Number m of free unknowns.
        columns: Columns of a node's unknowns in its row of seven.
        evaluations: How often they have been evaluated: the work of a search, whatever else the machine does.
    """

    def __init__(self, scene: Scene, rod: Rod | None = None) -> None:
        """Build the model and load or compile its equations.

        Args:
            scene: The scene.
            rod: Mesh of its string; None: the scene's mesh.

        Raises:
            SceneError: An effect depends on time, or the scene asks for an accuracy instead of elements.
        """
        refuse_time_dependent(scene)
        super().__init__(moving_everywhere(scene), rod)
        self._kernel = build_linearisation(self.effects, self.form, self.hole)
        self.parameters = self.parameters_for(self._kernel, self.scene)
        self.columns = COLUMNS[self.form]
        count, width = self.rod.length.size, self.columns.size
        self.free = np.ones((count + 1, width), dtype=bool)
        self.free[0], self.free[-1] = ~self.constrained[0, self.columns], ~self.constrained[1, self.columns]
        self._residual = np.zeros((count + 1, width))
        self._tangents = np.zeros((3, count + 1, width, 3 * width))
        self.unknowns = int(self.free.sum())
        self.block_rows = BlockRows(self.free, self.columns)
        self._entry: Any = None
        self.evaluations = 0
        arrays = [
            array
            for key, names in TURNING_ARRAYS.items()
            if (block := getattr(self.parameters, key, None)) is not None
            for array in (getattr(block, name) for name in names)
        ]
        self._imperfections = [(array, array.copy()) for array in arrays]
        self.set_imperfections(0.0)

    def set_imperfections(self, share: float) -> None:
        """Set bow and eccentricity to a share of the scene's bow and eccentricity."""
        for array, own in self._imperfections:
            array[:] = share * own

    def on_axis(self, command: Command) -> tuple[Array, Array]:
        """Position and velocity of the string on the axis of the hole, turning; rows of seven, shape (n + 1, 7)."""
        self._state.u[:] = 0.0
        set_initial_state(self._state, self.model, self.scene, command.weight_on_bit)
        u, v = self._state.u.copy(), np.zeros_like(self._state.v)
        v[:, SPIN] = command.rotation
        if (cutting := self._regeneration(command)) is not None:
            v[:, 2] = -cutting.rate
        return u, v

    def delay(self, command: Command) -> Delay | None:
        """Delayed force of a bit that drills what its last blade has left; None without one.

        Raises:
            SceneError: The hole is not straight.
        """
        cutting = self._regeneration(command)
        if cutting is None:
            return None
        if self.model.wellbore.axis is not None:
            raise SceneError(f"{self.scene.name}: expected a straight hole for the modes of bit_regenerative, found a "
                             "curved one; run it (drill-twin run)")  # fmt: skip
        force, arm = np.zeros(self.free.shape), np.zeros(self.free.shape)
        force[0, [2, SPIN]], arm[0, [2, SPIN]] = cutting.force, cutting.arm
        return Delay(cutting.delay, force[self.free], arm[self.free])

    def _regeneration(self, command: Command) -> Regeneration | None:
        rock = getattr(self.parameters, "bit_regenerative", None)
        return None if rock is None else regeneration(rock, self._bit_weight(command), command.rotation)

    def _bit_weight(self, command: Command) -> float:
        drive = self.parameters.drive
        return float(command.weight_on_bit + (drive.hanging if drive.from_top > 0.0 else 0.0))

    def evaluate(self, command: Command, u: Array, v: Array, a: Array) -> Linearised:
        """Residual and tangents at an instant.

        Args:
            command: Weight on bit [N] and speed of the top drive [rad/s].
            u: Rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            a: Their accelerations.
        """
        residual, tangents = self.blocks(command, u, v, a, self.constrained)
        return Linearised(residual[self.free], tangents.copy(), self.block_rows)

    def blocks(self, command: Command, u: Array, v: Array, a: Array, constrained: Mask) -> tuple[Array, Array]:
        """Residual and tangents by node, valid until the next call.

        Args:
            command: As of `evaluate`, and so the next three.
            u: Rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            a: Their accelerations.
            constrained: Mask of the unknowns of bit and top whose rows are cleared, shape (2, 7). Rows that are not
                cleared hold the reaction of the end.

        Returns:
            Residual, shape (n + 1, k), and mass, damping and stiffness as block rows [lower, own, upper], shape
            (3, n + 1, k, 3 k), with k unknowns a node; the unknowns of the bit are in its frame (`bit_frame`).
        """
        self.evaluations += 1
        self._work.command[:] = command
        drive = self.parameters.drive
        drive.memory[LAG] = -u[-1, SPIN]  # the angle that the drive's controller has integrated
        drive.bit.now[WEIGHT] = drive.bit.now[INITIAL] = self._bit_weight(command)
        if (rock := getattr(self.parameters, "bit_regenerative", None)) is not None:
            rock.memory[READY] = 0.0  # the surface is as steady drilling to this position leaves it
        arguments = (
            self.parameters, self.rod, self._work, constrained, self._state, u, v, a, self._residual, self._tangents,
        )  # fmt: skip
        self._entry = self._entry or undispatched(self._kernel.evaluate, *arguments)
        self._entry(*arguments)
        return self._residual, self._tangents

    @property
    def bit_frame(self) -> Array:
        """Frame of the hole at the bit, shape (3, 4) (`drill_twin.dynamics.solver.boundary`)."""
        return np.asarray(self._state.bit_frame)

    def rows(self, free: Any) -> Any:
        """Rows of seven, shape (..., n + 1, 7), from values of the free unknowns, shape (..., m); zero elsewhere."""
        result = np.zeros((*free.shape[:-1], self.free.shape[0], 7), free.dtype)
        own = np.zeros((*free.shape[:-1], *self.free.shape), free.dtype)
        own[..., self.free] = free
        result[..., self.columns] = own
        return result
