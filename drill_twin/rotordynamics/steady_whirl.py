# SPDX-License-Identifier: Apache-2.0
"""Steady whirl as an equilibrium in the frame that turns with it, found by Newton's method.

With J the quarter turn about the axis of the hole, ``u(t) = R(omega t) u`` has velocity omega J u and acceleration
-omega^2 u across the axis. The equations of motion M a + f(u, v) = 0 look the same from every direction, so they hold at
all times if they hold at one: m equations for the m unknowns of u and omega, and one condition that fixes the direction
in which the shape lies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.model.mesh import SPIN
from drill_twin.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.schedule.command import Command

ITERATIONS = 25
TOLERANCE = 1e-9
"""Size of the last Newton step: of a position over the clearance, of omega over the largest speed."""


def quarter_turn(rows: Array) -> Array:
    """J u: x to y and y to minus x, slopes likewise, zero along and about the axis; rows of seven."""
    turned = np.zeros_like(rows)
    turned[:, 0], turned[:, 1], turned[:, 3], turned[:, 4] = -rows[:, 1], rows[:, 0], -rows[:, 4], rows[:, 3]
    return turned


@dataclass(frozen=True)
class Whirl:
    """A steady whirl at one instant."""

    command: Command
    u: Array
    """Rows (r, r', psi), shape (n + 1, 7)."""
    omega: float
    """Whirl speed [rad/s], positive in the sense of rotation."""

    @property
    def motion(self) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration; rows of seven."""
        turned = quarter_turn(self.u)
        v = self.omega * turned
        v[:, SPIN] = self.command.rotation
        return self.u, v, self.omega**2 * quarter_turn(turned)


class TurningFrame:
    """Unknowns of a string in the frame that turns with its whirl: J and the projection across the axis on columns."""

    def __init__(self, equations: EquationsOfMotion) -> None:
        """Find the columns of x and y among the free unknowns."""
        free, columns = equations.free, equations.columns
        number = np.full(free.shape, -1)
        number[free] = np.arange(equations.unknowns)
        kind = np.broadcast_to(columns, free.shape)
        self.x = np.concatenate([number[(kind == 0) & free], number[(kind == 3) & free]])
        self.y = np.concatenate([number[(kind == 1) & free], number[(kind == 4) & free]])
        order = np.argsort(self.x)
        self.x, self.y = self.x[order], np.sort(self.y)
        self.equations = equations

    def times_j(self, matrix: Array) -> Array:
        """Matrix times J."""
        result = np.zeros_like(matrix)
        result[:, self.x], result[:, self.y] = matrix[:, self.y], -matrix[:, self.x]
        return result

    def across(self, matrix: Array) -> Array:
        """Matrix with the columns along and about the axis set to zero."""
        result = np.zeros_like(matrix)
        result[:, self.x], result[:, self.y] = matrix[:, self.x], matrix[:, self.y]
        return result

    def free(self, rows: Array) -> Array:
        """Values of the free unknowns of rows of seven."""
        values: Array = rows[:, self.equations.columns][self.equations.free]
        return values


def newton(equations: EquationsOfMotion, start: Whirl, clearance: float, iterations: int = ITERATIONS):
    frame = TurningFrame(equations)
    whirl = start
    fastest = max(abs(start.command.rotation), abs(start.omega), 1.0)
    for iteration in range(iterations):
        system = equations.evaluate(whirl.command, *whirl.motion)
        matrix, by_omega = jacobian(frame, system, whirl)
        # hold the direction of the point that is farthest out: its motion around is no unknown, omega takes its place
        far = frame.y[int(np.argmax(np.hypot(frame.free(whirl.u)[frame.x], frame.free(whirl.u)[frame.y])))]
        matrix[:, far] = by_omega
        try:
            step = np.linalg.solve(matrix, -system.residual)
        except np.linalg.LinAlgError:
            return None
        change, step[far] = step[far], 0.0
        size = max(np.abs(step).max() / clearance, abs(change) / fastest)
        if not np.isfinite(size) or size > 1e3:
            return None
        whirl = replace(whirl, u=whirl.u + equations.rows(step), omega=whirl.omega + float(change))
        if size < TOLERANCE:
            return whirl
    return None


def jacobian(frame: TurningFrame, system: Linearised, whirl: Whirl) -> tuple[Array, Array]:
    omega, turned = whirl.omega, quarter_turn(whirl.u)
    matrix = system.stiffness + omega * frame.times_j(system.damping) - omega**2 * frame.across(system.mass)
    by_omega = system.damping @ frame.free(turned) + 2.0 * omega * system.mass @ frame.free(quarter_turn(turned))
    return matrix, by_omega


def eigenvalues(frame: TurningFrame, system: Linearised, whirl: Whirl) -> ComplexArray:
    """Eigenvalues in the turning frame [rad/s]."""
    omega = whirl.omega
    gyro = system.damping + 2.0 * omega * frame.times_j(system.mass)
    stiff = system.stiffness + omega * frame.times_j(system.damping) - omega**2 * frame.across(system.mass)
    m = gyro.shape[0]
    inverse = np.linalg.inv(system.mass)
    state = np.zeros((2 * m, 2 * m))
    state[:m, m:] = np.eye(m)
    state[m:, :m], state[m:, m:] = -inverse @ stiff, -inverse @ gyro
    return np.linalg.eigvals(state)
