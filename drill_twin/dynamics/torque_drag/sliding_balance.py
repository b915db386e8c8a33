# SPDX-License-Identifier: Apache-2.0
"""Balance of forces of the string while all of it slides along the hole and turns at constant speeds.

The equations are the equations of the time loop (`drill_twin.dynamics.rotordynamics.equations`), with every effect of
the scene: rod, wall, mud, friction. The velocity is prescribed, along the axis of the hole and about it, so that
friction has its full size and the direction of the operation; position is the unknown.

Newton's method begins where the soft string lies (`soft_string`): on the side of the hole to which weight and tension
press it. As in `drill_twin.dynamics.equilibrium` the mass over the square of a step holds the first
changes small (Kelley and Keyes 1998); the step grows as the residual falls, until the change is Newton's. The system is
banded, seven unknowns a node.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.discretisation.discretise import BIT_ENDS, axis_at, kept, untwisted
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.dynamics.discretisation.resolution import MOST, resolution_of
from drill_twin.dynamics.rotordynamics.block_rows import BlockRows
from drill_twin.dynamics.rotordynamics.equations import TIME_DEPENDENT, EquationsOfMotion
from drill_twin.dynamics.solver.linearisation import MASS, STIFFNESS
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.physics.effects.bit_torque_stribeck import BitTorqueStribeck
from drill_twin.physics.effects.gravity import line_weight
from drill_twin.physics.effects.stretch import Stretch
from drill_twin.physics.effects.torsion import Torsion
from drill_twin.physics.model.mesh import SPIN, Rod
from drill_twin.scene import Scene
from drill_twin.scene.blocks.top_drive import TopDrive
from drill_twin.scene.set_points.command import Command

IMPERFECTIONS = ("bow", "eccentricity", "rock_floor", "lateral_kick", *TIME_DEPENDENT)
"""Effects that a steady balance leaves out; the weight on bit takes the place of the rock."""

NODE = 7
"""Unknowns of a node."""
TOLERANCE = 1e-7
"""Residual force at a node over the largest load; residual torque over the same at the string's radius."""
FIRST_STEP, SHORTEST_STEP, LONGEST_STEP = 0.02, 5e-3, 1e3
"""Step of the regularisation: the first, and its bounds [s]."""
GROWTH, SHRINKAGE = 3.0, 0.5
"""Largest and least change of the step."""
LARGEST_MOVE = 0.5
"""Largest change across the hole in a step, over the largest clearance."""
MOST_STEPS = 400
SMALLEST_LOAD = 1e-3
"""Reference of the residual for a string without weight or load [N]."""
HELD = 3.0
"""Length over which the first guess goes from the hole's axis at an end to the wall, in lengths (EI / w)^(1/3)."""


class BalancedString(NamedTuple):
    """String in balance during an operation."""

    operation: Operation
    u: Array
    """Rows (r, r', psi), shape (n + 1, 7)."""
    bit: Array
    """Reaction on the bit's row in the frame of the hole there: force [N], moments on r', torque [N m]; shape (7,)."""
    top: Array
    """Reaction on the top's row, shape (7,)."""
    steps: int
    """Newton steps."""

    @property
    def hookload(self) -> float:
        """Tension at the top clamp [N]."""
        return float(self.top[2])

    @property
    def surface_torque(self) -> float:
        """Torque of the top drive on the string [N m]."""
        return float(self.top[SPIN])

    @property
    def bit_side_force(self) -> float:
        """Force of the hole's wall on the bit, across the hole [N]; 0 for a bit that is free to move across."""
        return float(np.hypot(self.bit[0], self.bit[1]))


class SlidingBalance:
    """Balances of one string for any operation."""

    def __init__(self, equations: EquationsOfMotion) -> None:
        """Number the free unknowns.

        Args:
            equations: Of a scene in the spatial form with the weight applied at the bit.
        """
        self.equations = equations
        scene, model = equations.scene, equations.model
        fixed = np.zeros((model.rod.arc.size, NODE), bool)
        fixed[0], fixed[-1] = BIT_ENDS[scene.string.bit_end], equations.constrained[1]
        self.fixed = fixed
        self.rows = BlockRows(~fixed, np.arange(NODE))
        """Numbers of the free unknowns, and the solution of their banded systems."""
        self._none = np.zeros((2, NODE), bool)
        axis = axis_at(scene, scene.length - model.rod.arc)
        self.tangent = np.array([0.0, 0.0, 1.0]) if axis is None else axis.tangent
        """Direction of the hole at the nodes, shape (n + 1, 3), or (3,) for a straight hole."""
        self.bend = np.zeros(3) if axis is None else axis.curvature[:, None] * axis.normal
        """Curvature of the hole times its normal [1/m], of the same shape."""
        self.room = float(model.wellbore.clearance.max())
        gravity = scene.effects.gravity
        self.weight = 0.0 if gravity is None else float(np.abs(line_weight(gravity, model) * model.rod.length).sum())
        """Weight of the string, discs included and less buoyancy, whatever the direction of the hole [N]."""

    def velocity(self, operation: Operation) -> Array:
        """Velocities of the rows (r, r', psi) in an operation, along the hole; shape (n + 1, 7)."""
        v = np.zeros_like(self.fixed, dtype=float)
        v[:, 0:3] = operation.axial_speed * self.tangent
        v[:, 3:6] = operation.axial_speed * self.bend
        v[:, SPIN] = operation.rotation
        return v

    def solve(self, operation: Operation, guess: Array | None = None) -> BalancedString:
        """Find the balance in an operation.

        Args:
            operation: The operation.
            guess: Rows to start from, such as the balance of another operation; None: where the soft string lies.

        Raises:
            RunError: Newton's method does not converge.
        """
        equations = self.equations
        command, v = Command(operation.weight_on_bit, operation.rotation), self.velocity(operation)
        u = (self._soft_shape(command) if guess is None else guess).copy()
        still = np.zeros_like(u)
        load = max(self.weight, abs(operation.weight_on_bit), SMALLEST_LOAD)
        lever = float(equations.model.rod.outer_radius.max())
        step, last = FIRST_STEP, np.inf
        for count in range(MOST_STEPS):
            residual, tangents = equations.blocks(command, u, v, still, self._none)
            free = np.where(self.fixed, 0.0, residual)
            force = max(float(np.abs(free[:, 0:3]).max()), float(np.abs(free[:, SPIN]).max()) / lever)
            if not np.isfinite(force):
                break
            if force < TOLERANCE * load:
                return BalancedString(operation, u, residual[0].copy(), residual[-1].copy(), count)
            step = float(np.clip(step * np.clip(last / force, SHRINKAGE, GROWTH), SHORTEST_STEP, LONGEST_STEP))
            last = force
            tangents[MASS, :, SPIN] = 0.0  # torsion is linear while all of the string slides
            change = self._change(free, tangents[STIFFNESS] + tangents[MASS] / step**2)
            while self._across(change) > LARGEST_MOVE * self.room and step > SHORTEST_STEP:
                step *= 0.5 * SHRINKAGE
                change = self._change(free, tangents[STIFFNESS] + tangents[MASS] / step**2)
            u = u + change
        remedy = "Try more elements (--set numerics.elements=...), a softer wall or a lower weight on bit"
        if load == SMALLEST_LOAD:
            remedy = "A string without weight has no loads to balance there: list effects.gravity, and its own density"
        raise RunError(
            f'{equations.scene.name}: expected a balance in the operation "{operation.name}", found none: '
            f"residual {last:.3g} N of a load of {load:.3g} N after {count} steps. {remedy}"
        )

    def stiffness(self, balance: BalancedString) -> Array:
        """Tangent by position at a balance as block rows, shape (n + 1, 7, 21)."""
        operation = balance.operation
        _, tangents = self.equations.blocks(
            Command(operation.weight_on_bit, operation.rotation), balance.u, self.velocity(operation),
            np.zeros_like(balance.u), self._none,
        )  # fmt: skip
        return np.asarray(tangents[STIFFNESS])

    def _change(self, residual: Array, blocks: Array) -> Array:
        """Newton's change of the rows."""
        change = np.zeros_like(residual)
        change[self.rows.free] = self.rows.solve(blocks, -residual[self.rows.free])
        turn = self.equations.bit_frame[:, :3]
        change[0, 0:3], change[0, 3:6] = change[0, 0:3] @ turn, change[0, 3:6] @ turn
        return change

    def _across(self, change: Array) -> float:
        """Largest part of a change across the hole [m]."""
        return float(np.linalg.norm(np.cross(change[:, 0:3], self.tangent), axis=1).max())

    def _soft_shape(self, command: Command) -> Array:
        """String where weight and tension press a string without bending stiffness, on the axis at its ends."""
        equations, model = self.equations, self.equations.model
        rod, wall = model.rod, getattr(equations.parameters, "wall", None)
        u, _ = equations.on_axis(command)
        force = self.transverse_load(u)
        size = np.linalg.norm(force, axis=1)
        if wall is None or not size.max() > 0.0:
            return u
        clearance = np.interp(rod.arc, model.places, model.wellbore.clearance)
        depth = clearance + (size / wall.stiffness) ** (1.0 if wall.linear else 2.0 / 3.0)
        typical, bending = float(np.median(size[size > 1e-3 * size.max()])), np.append(rod.bending, rod.bending[-1])
        run = HELD * float(np.median(bending / typical)) ** (1.0 / 3.0)
        rise = np.clip(np.minimum(rod.arc, rod.arc[-1] - rod.arc) / run, 0.0, 1.0)
        share = (rise**2 * (3.0 - 2.0 * rise)) * -np.expm1(-size / (0.2 * typical))
        off = force / np.maximum(size, 1e-9 * typical)[:, None] * (depth * share)[:, None]
        u[:, 0:3] += off
        u[1:-1, 3:6] += np.gradient(off, rod.arc, axis=0)[1:-1]
        return u

    def transverse_load(self, u: Array) -> Array:
        """Load across the hole at the nodes of a string along its axis: weight, and tension times curvature [N/m]."""
        model, gravity = self.equations.model, getattr(self.equations.parameters, "gravity", None)
        weight = np.zeros((model.rod.arc.size, 3))
        if gravity is not None:
            weight[:-1] = gravity.weight[::2]
            weight[-1] = weight[-2]
        tension = (np.linalg.norm(u[:, 3:6], axis=1) - 1.0) * np.append(model.rod.axial, model.rod.axial[-1])
        across = weight - np.sum(weight * self.tangent, axis=1)[:, None] * self.tangent
        return np.asarray(across + tension[:, None] * self.bend)


def steady(scene: Scene) -> Scene:
    """The scene in space, weight at the bit, turned at a prescribed speed, without what depends on time."""
    effects, rig = scene.effects, scene.rig
    changes: dict[str, object] = dict.fromkeys(key for key in IMPERFECTIONS if getattr(effects, key, None) is not None)
    changes |= {"stretch": effects.stretch or Stretch(), "torsion": effects.torsion or Torsion()}
    cutting = getattr(effects, "bit_cutting", None)
    if cutting is not None:
        changes["bit_cutting"] = cutting.model_copy(update={"rock_stiffness": None})
    if (regenerative := getattr(effects, "bit_regenerative", None)) is not None:
        arm = regenerative.torque_arm(rig.weight_on_bit.value)
        changes |= {
            "bit_regenerative": None,
            "bit_torque_stribeck": BitTorqueStribeck(radius=arm, sliding=1.0, sticking=1.0, decay=0.0) if arm else None,
        }
    weight = rig.weight_on_bit.model_copy(update={"at": "bit"})
    still = rig.model_copy(update={"weight_on_bit": weight, "top_drive": TopDrive(), "start": "axis", "block": None})
    elements = min(resolution_of(scene)[0], MOST) if scene.numerics.elements == "auto" else scene.numerics.elements
    numerics = scene.numerics.model_copy(update={"elements": elements})
    return scene.model_copy(update={"effects": effects.model_copy(update=changes), "rig": still, "numerics": numerics})


@kept
def rotating_rows(scene: Scene, rod: Rod) -> Array:
    """Rows (r, r', psi) on a mesh of the untwisted string that turns in balance at the first set-points; (n + 1, 7).

    Above a joint the string is on the axis, and the string below moves along the hole to meet it. Where no balance is
    found, all of the string is on the axis.
    """
    (weight, rotation), joint = scene.rig.first, joint_of(scene)
    string = SlidingBalance(EquationsOfMotion(steady(scene), rod))
    if scene.rig.weight_on_bit.at == "top":
        weight += string.equations.parameters.drive.hanging
    u, _ = string.equations.on_axis(Command(weight, rotation))
    try:
        shape = string.solve(Operation("start", weight, 0.0, rotation)).u
    except RunError:
        return u
    top = rod.arc.size - 1 if joint is None else int(np.searchsorted(rod.arc, joint - 1e-6))
    tangent, bend = (np.broadcast_to(each, (rod.arc.size, 3)) for each in (string.tangent, string.bend))
    ahead = float((u[top, :3] - shape[top, :3]) @ tangent[top])
    shape[:, 0:3] += ahead * tangent
    shape[:, 3:6] += ahead * bend
    u[: top + 1, :SPIN] = shape[: top + 1, :SPIN]
    u[:, SPIN] = untwisted(rod, u)
    return u
