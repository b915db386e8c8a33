# SPDX-License-Identifier: Apache-2.0
"""Bow and eccentricity: the modulation of a steady whirl that they cause, and states locked to the rotation.

Bow and eccentricity turn with the string. In the frame of a whirl omega their force is periodic at Omega - omega,
and to first order the string answers with a motion w(t) = Re(W exp(i (Omega - omega) t)) about the state: a linear
solve in that frame. A motion that turns with the rotation itself (ratio 1) is an equilibrium in the frame of the
string, with the imperfections in it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.shape_search import ShapeSearch
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import (
    TOLERANCE,
    Pace,
    SteadyWhirl,
    TurningEquations,
    settled,
)
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState, state_of
from drill_twin.physics.model import SPIN
from drill_twin.scene.set_points.command import Command

QUARTERS = 4
"""Directions of the imperfections from which their force is taken."""
STEPS, LONGEST_STEP, SETTLED, FIRST_STEP = 200, 1e6, 100.0, 1e6
"""Most steps of Newton's method with pseudo-time; its longest step over the first; step over the inverse square of
the rotation from which it may end; first step from the axis [s2]."""
STARTS = 0.02, 0.97
"""Sizes of the first shapes over the clearance."""


@contextmanager
def imperfect(equations: EquationsOfMotion, share: float = 1.0) -> Iterator[None]:
    """The equations with a share of bow and eccentricity, inside the block."""
    equations.set_imperfections(share)
    try:
        yield
    finally:
        equations.set_imperfections(0.0)


@dataclass(frozen=True, eq=False)
class Modulation:
    """First-order motion about a steady whirl, Re(amplitude exp(i rate t)) in its frame."""

    whirl: SteadyWhirl
    rate: float
    """Rotation less whirl speed [rad/s]."""
    amplitude: ComplexArray
    """Rows of seven, shape (n + 1, 7)."""

    @property
    def size(self) -> float:
        """Root mean square of the motion of the node that moves most [m]."""
        return float(np.sqrt(0.5 * np.sum(np.abs(self.amplitude[:, :2]) ** 2, axis=1).max()))

    def line(self, times: Array) -> ComplexArray:
        """X + i y of the nodes in the hole over time, shape (T, n + 1)."""
        moved = np.real(np.exp(1j * self.rate * times)[:, None, None] * self.amplitude[:, :2])
        place = self.whirl.u[:, :2] + moved
        turn = np.exp(1j * self.whirl.omega * times)
        return np.asarray(turn[:, None] * (place[..., 0] + 1j * place[..., 1]), np.complex128)


def modulation(turning: TurningEquations, whirl: SteadyWhirl) -> Modulation:
    """Modulation of a steady whirl by bow and eccentricity; zero in a scene without them."""
    equations, system = turning.equations, turning.at(whirl)
    force = np.zeros(equations.unknowns, dtype=complex)
    u, v, a = whirl.motion
    for k in range(QUARTERS):
        angle = 2.0 * np.pi * k / QUARTERS
        turned = u.copy()
        turned[:, SPIN] += angle
        with imperfect(equations):
            residual = equations.evaluate(whirl.command, turned, v, a).residual
        force += 2.0 / QUARTERS * np.exp(-1j * angle) * (residual - system.residual)
    rate = whirl.command.rotation - whirl.omega
    mass, gyroscopic, stiffness = turning.pencil(system, whirl.omega)
    values = np.linalg.solve(stiffness + 1j * rate * gyroscopic - rate**2 * mass, -force)
    amplitude = equations.rows(np.real(values)) + 1j * equations.rows(np.imag(values))
    return Modulation(whirl, rate, np.asarray(amplitude, np.complex128))


def locked_states(turning: TurningEquations, command: Command) -> tuple[WhirlState, ...]:
    """States locked to the rotation, from the axis and from its lowest modes near it and near the wall."""
    equations, found = turning.equations, list[SteadyWhirl]()
    search = ShapeSearch(turning, command)
    with imperfect(equations):
        shortest = 0.1 / max(command.rotation**2, 1.0)
        for number, start in enumerate(_starts(search)):
            # plain Newton from the axis, which may be unstable
            first = shortest if number else FIRST_STEP
            whirl = _relaxed(turning, SteadyWhirl(command, start, command.rotation), first)
            same = 1e-3 * turning.clearance
            if whirl is not None and not any(np.hypot(*(whirl.u - other.u)[:, :2].T).max() < same for other in found):
                found.append(whirl)
        return tuple(state_of(turning, whirl, is_locked=True) for whirl in found)


def locked_near(turning: TurningEquations, whirl: SteadyWhirl) -> WhirlState | None:
    """State locked to the rotation near a shape, such as a shape of another mesh; None if there is no such state."""
    with imperfect(turning.equations):
        found = _relaxed(turning, whirl, FIRST_STEP)
        return None if found is None else state_of(turning, found, is_locked=True)


def _starts(search: ShapeSearch) -> Iterator[Array]:
    """First shapes: the axis, and the lowest modes in four directions."""
    yield search.axis
    for mode in search.starts(0, 0):
        line, slope = (moved[:, 0] + 1j * moved[:, 1] for moved in np.split((mode - search.axis)[:, :6], 2, axis=1))
        for size in STARTS:
            scale = size * search.turning.clearance / np.abs(line).max()
            for turn in scale * 1j ** np.arange(4):
                u = search.axis.copy()
                u[:, 0], u[:, 1] = (turn * line).real, (turn * line).imag
                u[:, 3], u[:, 4] = (turn * slope).real, (turn * slope).imag
                yield u


def _relaxed(turning: TurningEquations, whirl: SteadyWhirl, shortest: float) -> SteadyWhirl | None:
    """Equilibrium in the frame of the string near a first shape, by pseudo-transient continuation."""
    pace = Pace(STEPS, shortest, (0.0, LONGEST_STEP * shortest), TOLERANCE, SETTLED / max(whirl.omega**2, 1e-300))
    found = settled(turning, whirl, pace)
    return None if found is None else found[0]
