# SPDX-License-Identifier: Apache-2.0
"""Steady whirl as an equilibrium in the frame that turns with it, and its stability.

With J the quarter turn about the axis of the hole, ``u(t) = R(omega t) u`` has velocity omega J u and acceleration
-omega^2 u across the axis. The equations M a + f(u, v) = 0 look the same from every direction, so they hold at all
times if they hold at one: m equations for the m unknowns of u and omega, and one condition that fixes the direction in
which the shape lies. A small motion w(t) in the turning frame obeys

``M w'' + (C + 2 omega M J) w' + (K + omega C J + omega^2 M J J) w = 0``,

whose eigenvalues are constant; one is zero, the turn of the whole shape.

Deflation keeps Newton's method away from the steady whirls that are known (Farrell, Birkisson and Funke 2015): the
residual F is multiplied by m = prod(1 / d_i^2 + 1), d_i the distance from a known whirl. Newton's step for m F is that
for F times a number, so that deflation costs two products a step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, eigenvalues_only
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame, quarter_turn
from drill_twin.dynamics.solver.linearisation import DAMPING, MASS
from drill_twin.physics.model import SPIN
from drill_twin.scene.set_points.command import Command

ITERATIONS = 25
TOLERANCE = 1e-9
"""Size of the last Newton step: of a position over the clearance, of omega over the rotation."""
FARTHEST = 1e3
"""Size of a Newton step from which the iteration is given up."""
MARGIN = 1e-3
"""Growth below which a state counts as stable, over the speed of rotation."""
NEUTRAL = 0.02
"""Largest size of the zero eigenvalue as computed, over the speed of rotation."""


@dataclass(frozen=True, eq=False)
class SteadyWhirl:
    """Shape and speed of a whirl at one instant."""

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

    @property
    def radius(self) -> Array:
        """Distance of the nodes from the axis [m], shape (n + 1,)."""
        return np.asarray(np.hypot(self.u[:, 0], self.u[:, 1]))


StepFactor = Callable[[SteadyWhirl, Array, float], float]
"""Factor on a Newton step, from the whirl, the step of the free unknowns, and the step of omega."""


class TurningEquations:
    """The equations of a scene in the frame of a whirl.

    Attributes:
        equations: Of the scene.
        frame: Its unknowns across the axis.
        clearance: Smallest distance of the string on the axis from the wall [m].
    """

    def __init__(self, equations: EquationsOfMotion) -> None:
        """Take the equations of a scene with a wall."""
        self.equations, self.frame = equations, TurningFrame(equations)
        self.clearance = float(equations.model.wellbore.clearance.min())

    def at(self, whirl: SteadyWhirl) -> Linearised:
        """Residual and tangents at a whirl."""
        return self.equations.evaluate(whirl.command, *whirl.motion)

    def stiffness(self, system: Linearised, omega: float) -> Array:
        """Derivative of the residual by the shape, K + omega C J - omega^2 M across the axis, as block rows."""
        mass, damping, stiffness = system.tangents
        rows = system.rows
        return np.asarray(stiffness + omega * rows.times_j(damping) - omega**2 * rows.across(mass))

    def pencil(self, system: Linearised, omega: float) -> Pencil:
        """Mass, damping and stiffness of small motions in the frame of a whirl."""
        rows, (mass, damping, _) = system.rows, system.tangents
        gyroscopic = damping + 2.0 * omega * rows.times_j(mass)
        return Pencil(*map(rows.dense, (mass, gyroscopic, self.stiffness(system, omega))))

    def by_omega(self, system: Linearised, whirl: SteadyWhirl) -> Array:
        """Derivative of the residual by the whirl speed, C J u - 2 omega M u across the axis."""
        turned = quarter_turn(whirl.u)
        damped = system.rows.times(system.tangents[DAMPING], self.frame.values(turned))
        moved = system.rows.times(system.tangents[MASS], self.frame.values(quarter_turn(turned)))
        return np.asarray(damped + 2.0 * whirl.omega * moved)

    def newton(
        self, start: SteadyWhirl, away: StepFactor | None = None, iterations: int = ITERATIONS
    ) -> SteadyWhirl | None:
        """Steady whirl near a first guess; None if Newton's method does not converge.

        The direction of the node farthest from the axis is held: its motion around is no unknown, and omega takes its
        place.

        Args:
            start: First guess.
            away: Factor on each step, such as `deflation` away from the whirls that are known.
            iterations: Most steps.
        """
        whirl, fastest = start, max(abs(start.command.rotation), 1e-3)
        for _ in range(iterations):
            system = self.at(whirl)
            matrix = self.stiffness(system, whirl.omega)
            held = self.frame.farthest(self.frame.values(whirl.u))
            step = system.rows.solve(matrix, -system.residual, held, self.by_omega(system, whirl))
            change, step[held] = float(step[held]), 0.0
            size = max(float(np.abs(step).max()) / self.clearance, abs(change) / fastest)
            if not size < FARTHEST:
                return None
            if away is not None:
                factor = away(whirl, step, change)
                change, step = factor * change, factor * step
            whirl = replace(whirl, u=whirl.u + self.equations.rows(step), omega=whirl.omega + change)
            if size < TOLERANCE:
                return whirl
        return None

    def spectrum(self, whirl: SteadyWhirl, *, is_locked: bool = False) -> ComplexArray:
        """Eigenvalues in the turning frame [rad/s], fastest growth first; an eigenvalue of zero is left out."""
        values = eigenvalues_only(self.pencil(self.at(whirl), whirl.omega))
        if not is_locked:
            values = np.delete(values, int(np.argmin(np.abs(values))))
        return np.asarray(values[np.argsort(-values.real)], np.complex128)


LARGEST_MOVE = 0.3
"""Step over the clearance that is taken back, to go on with a quarter of the pseudo-time."""
FORCE_RATIO, LEAST_RATIO, MOST_RATIO = 1.5, 0.5, 3.0
"""Growth of the pseudo-time by the fall of the largest force, and its bounds."""


class Pace(NamedTuple):
    """Steps of a pseudo-transient continuation, in pseudo-time [s2]."""

    steps: int
    """Most steps."""
    first: float
    bounds: tuple[float, float]
    """Least and largest step."""
    tolerance: float
    """Step of the shape over the clearance at which it is in balance."""
    settled: float
    """Step from which it may be."""


def settled(
    turning: TurningEquations, whirl: SteadyWhirl, pace: Pace, *, driven: bool = False
) -> tuple[SteadyWhirl, float] | None:
    """Shape in balance at the speed of a whirl, near its own, by pseudo-transient continuation (Kelley and Keyes 1998).

    Args:
        turning: The equations.
        whirl: First shape, and the speed.
        pace: The steps.
        driven: An extra force along the path holds the shape, and the direction of its node farthest from the axis is
            held in place of it.

    Returns:
        The shape, and the extra force per momentum [1/s2]; None if there is none.
    """
    frame, drive, length, last = turning.frame, 0.0, pace.first, np.inf
    for _ in range(pace.steps):
        system = turning.at(whirl)
        mass, rows, residual = system.tangents[MASS], system.rows, system.residual
        matrix = turning.stiffness(system, whirl.omega) + mass / length
        if driven:
            along = rows.times(mass, frame.values(quarter_turn(whirl.u)))
            if last == np.inf:
                drive = -float(along @ residual) / max(float(along @ along), 1e-300)
            held, residual = frame.farthest(frame.values(whirl.u)), residual + drive * along
            step = rows.solve(matrix + drive * rows.times_j(mass), -residual, held, along)
            change, step[held] = float(step[held]), 0.0
        else:
            step, change = rows.solve(matrix, -residual), 0.0
        size = float(np.abs(step).max()) / turning.clearance
        if not np.isfinite(size):
            return None
        if size > LARGEST_MOVE:
            length *= 0.25
            continue
        whirl, drive = replace(whirl, u=whirl.u + turning.equations.rows(step)), drive + change
        if size < pace.tolerance and length > pace.settled:
            return whirl, drive
        force = float(np.abs(residual).max())
        growth = float(np.clip(FORCE_RATIO * last / max(force, 1e-300), LEAST_RATIO, MOST_RATIO))
        length, last = float(np.clip(length * growth, *pace.bounds)), force
    return None


def solve(matrix: Array, right: Array) -> Array:
    """Solution of linear equations; not finite where they have none."""
    try:
        return np.asarray(np.linalg.solve(matrix, right), np.float64)
    except np.linalg.LinAlgError:
        return np.full(right.shape, np.nan)


LARGEST_FACTOR = 4.0
"""Largest factor on a step; deflated steps may be of any length and sign."""


def deflation(
    turning: TurningEquations, known: Sequence[SteadyWhirl], whirl: SteadyWhirl, step: Array, change: float
) -> float:
    """Factor on Newton's step of the free unknowns, shape (m,), and of omega, by the distance from known whirls.

    From m F with step d of F: 1 / (1 - m' d / m) (Sherman and Morrison). A whirl turned about the axis is the same
    whirl: the distance is the least over all turns, shapes over the clearance (root mean square) and whirl speeds over
    the rotation together.
    """
    speed, clearance = max(abs(whirl.command.rotation), 1e-3), turning.clearance
    z, moved, slope = _line(whirl.u), _line(turning.equations.rows(step)), 0.0
    for other in known:
        own = _line(other.u)
        overlap = complex(np.vdot(own, z))
        away = (z - own * (overlap / max(abs(overlap), 1e-300))) / clearance
        ahead = (whirl.omega - other.omega) / speed
        square = max(float(np.mean(np.abs(away) ** 2)) + ahead**2, 1e-24)
        along = 2.0 * (float(np.mean((away.conj() * moved).real)) / clearance + ahead * change / speed)
        slope -= along / (square * (1.0 + square))
    factor = 1.0 / (1.0 - slope) if abs(1.0 - slope) > 1e-12 else LARGEST_FACTOR
    return float(np.clip(factor, -LARGEST_FACTOR, LARGEST_FACTOR))


def _line(u: Array) -> ComplexArray:
    """Positions x + i y of the nodes."""
    return np.asarray(u[:, 0] + 1j * u[:, 1], np.complex128)
