# SPDX-License-Identifier: Apache-2.0
"""Torque, drag and buckling without a run: capstan, soft string, tool joints in a bend, snaking."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse.linalg import eigsh

from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.torque_drag.analysis import OperationLoads, analyse
from drill_twin.dynamics.torque_drag.sliding_balance import BalancedString, SlidingBalance
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.physics.model.mesh import SPIN
from drill_twin.scene import Scene
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DIAMETER, EI, LINE_MASS, WALLED, quiet_scene
from drill_twin_evidence.verify.statics.curved_hole import bend

WEIGHT = LINE_MASS * 9.81
GRAVITY: dict[str, Any] = {"gravity": {"magnitude": 9.81}}
FRICTION = 0.3
JOHANCSIK, DAWSON = "Johancsik, Friesen and Dawson 1984", "Dawson and Paslay 1984"
OUT, IN = Operation("trip out", 0.0, 0.1, 0.0), Operation("trip in", 0.0, -0.1, 0.0)


def sliding(effects: dict[str, Any], **scene: Any) -> Scene:
    """The rod in its hole with friction on the wall."""
    return quiet_scene({"wall_friction": {"coefficient": FRICTION}} | effects, of=WALLED, marks=(), **scene)


def loads_in(scene: Scene, operation: Operation) -> OperationLoads:
    """Loads of a scene in one operation."""
    return analyse(scene, [operation]).operations[0]


@case()
def capstan() -> Iterator[Row]:
    """A weightless soft rod pulled through a bend of one radian; near its held ends it is off the wall: 1 %."""
    scene = sliding(
        {}, length=20.0, elements=80, sections=({"youngs_modulus": 2.3e8},),
        hole=bend(20.0, 20.0, hole=0.5e-3 + DIAMETER / 2),
    )  # fmt: skip
    found = loads_in(scene, OUT._replace(weight_on_bit=-100.0))
    exact = float(np.exp(FRICTION))
    yield Row("hookload over the pull at the bit [-]", "exp(mu theta)", "Euler 1769; Eytelwein 1808",
              exact, found.hookload / 100.0, 1e-2)  # fmt: skip
    yield Row("of the soft string [-]", "exp(mu theta)", "Euler 1769; Eytelwein 1808",
              exact, found.soft.hookload / 100.0, 1e-4)  # fmt: skip


@case()
def straight_inclined() -> Iterator[Row]:
    """A heavy rod in a straight hole of 60 deg: hoisted, lowered, rotated. A rotating rod climbs the wall to the angle
    of friction, which the soft string leaves out. Off the wall near its ends: 1 %.
    """
    length, angle = 60.0, np.pi / 3.0
    scene = sliding(
        GRAVITY, length=length, elements=120, radius=1e-3 + DIAMETER / 2, inclination=angle,
        sections=({"youngs_modulus": 2.3e7},),
    )  # fmt: skip
    across, along = WEIGHT * length * np.sin(angle), WEIGHT * length * np.cos(angle)
    for operation, sign in ((OUT, 1.0), (IN, -1.0)):
        found = loads_in(scene, operation)
        exact = along + sign * FRICTION * across
        formula = f"w L (cos(alpha) {'+' if sign > 0.0 else '-'} mu sin(alpha))"
        yield Row(f"hookload, {operation.name} [N]", formula, JOHANCSIK, exact, found.hookload, 1e-2)
        yield Row(f"hookload, {operation.name}, soft string [N]", formula, JOHANCSIK, exact, found.soft.hookload, 1e-6)
    found = loads_in(scene, Operation("off bottom", 0.0, 0.0, 1.0))
    torque = FRICTION * across * DIAMETER / 2
    yield Row("hookload, rotating [N]", "w L cos(alpha)", JOHANCSIK, along, found.hookload, 1e-6)
    yield Row("surface torque [N m]", "mu w L sin(alpha) r / sqrt(1 + mu^2)", "balance of an arc on a wall",
              torque / float(np.hypot(1.0, FRICTION)), found.surface_torque, 1e-2)  # fmt: skip
    yield Row("surface torque, soft string [N m]", "mu w L sin(alpha) r", JOHANCSIK,
              torque, found.soft.surface_torque, 1e-6)  # fmt: skip


@case()
def heavy_in_a_bend() -> Iterator[Row]:
    """A heavy soft rod hoisted through a bend of 0.5 rad, pulled so hard that it is on the high side: 1 %."""
    length, radius, pull, upper = 30.0, 60.0, 200.0, 0.7
    scene = sliding(
        GRAVITY, length=length, elements=120, sections=({"youngs_modulus": 2.3e8},),
        hole=bend(radius, length, upper, 0.4, hole=1e-3 + DIAMETER / 2),
    )  # fmt: skip
    found = loads_in(scene, OUT._replace(weight_on_bit=-pull))
    mu, line = FRICTION, WEIGHT * radius
    sine, cosine = -line * (1.0 - mu * mu) / (1.0 + mu * mu), -2.0 * mu * line / (1.0 + mu * mu)

    def particular(angle: float) -> float:
        return float(sine * np.sin(angle) + cosine * np.cos(angle))

    lower = upper + length / radius
    exact = (pull - particular(lower)) * float(np.exp(mu * (lower - upper))) + particular(upper)
    formula = "solution of dT/ds = w cos(alpha) + mu (T / R - w sin(alpha))"
    yield Row("hookload [N]", formula, JOHANCSIK, exact, found.hookload, 1e-2)
    yield Row("hookload, soft string [N]", formula, JOHANCSIK, exact, found.soft.hookload, 1e-3)


@case()
def tool_joints_in_a_bend() -> Iterator[Row]:
    """A weightless rod under tension in a dog-leg, held off the wall by its tool joints: between them it is straighter
    than the hole, at them bent more. 1 %.

    Between joints kappa'' = K^2 kappa; the mean over a joint and a pipe is the curvature of the hole.
    """
    pull, radius, spacing, joint, thicker = 100.0, 40.0, 1.0, 0.02, 8e-3
    scene = sliding(
        {}, length=20.0, elements=1020,
        sections=({"joints": {"spacing": spacing, "length": joint, "diameter": DIAMETER + thicker}},),
        hole=bend(radius, 20.0, hole=5e-3 + DIAMETER / 2),
    )  # fmt: skip
    found = loads_in(scene, Operation("pull", -pull, 0.0, 0.0))
    along, wave, half = found.along, float(np.sqrt(pull / EI)), 0.5 * (spacing - joint)
    thick = joint * (DIAMETER / (DIAMETER + thicker)) ** 4
    at_joint = spacing / (2.0 * float(np.tanh(wave * half)) / wave + thick)
    place = 20.0 - along.depth - 10.0  # from a joint's upper end
    element = float(along.length[np.argmin(np.abs(place - 0.5))])
    inner = half - 0.5 * (1.0 - 3.0**-0.5) * element  # outer Gauss point of the last element, from mid-span
    for name, where, away in (("middle between joints", half, 0.0), ("pipe beside a joint", 0.5 * element, inner)):
        curvature = along.bending_moment[np.argmin(np.abs(place - where))] / EI
        exact = at_joint * float(np.cosh(wave * away) / np.cosh(wave * half))
        yield Row(f"curvature over the hole's, {name} [-]", "K L cosh(K x) / sinh(K L), K = sqrt(T / EI)",
                  "Lubinski 1961", exact, radius * float(curvature), 1e-2)  # fmt: skip


@case()
def snaking() -> Iterator[Row]:
    """Load at which the balance of a long rod on the low side of a level hole becomes singular: the least eigenvalue of
    its stiffness, extrapolated to zero from two lower loads. 60 m hold 40 half waves, which fit by themselves: 2 %.
    """
    clearance = 0.02
    scene = quiet_scene(
        GRAVITY, of=WALLED, length=60.0, elements=200, radius=clearance + DIAMETER / 2, inclination=np.pi / 2, marks=(),
    )  # fmt: skip
    exact = 2.0 * float(np.sqrt(EI * WEIGHT / clearance))
    solver = SlidingBalance(EquationsOfMotion(scene))
    loads = 0.9 * exact, 0.95 * exact
    first, second = (_least_eigenvalue(solver, solver.solve(Operation("push", load, 0.0, 0.0))) for load in loads)
    yield Row("load [N]", "2 sqrt(EI w / r)", DAWSON, exact,
              loads[0] + (loads[1] - loads[0]) * first / (first - second), 2e-2)  # fmt: skip


def _least_eigenvalue(solver: SlidingBalance, balance: BalancedString) -> float:
    """Least eigenvalue of the stiffness against bending and stretch, which is symmetric without friction."""
    matrix = solver.rows.sparse(solver.stiffness(balance))
    moving = np.flatnonzero(np.nonzero(solver.rows.free)[1] != SPIN)
    matrix = matrix[moving][:, moving]
    return float(eigsh(matrix, k=1, sigma=0.0, which="LM", return_eigenvectors=False)[0])
