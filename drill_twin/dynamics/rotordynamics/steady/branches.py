# SPDX-License-Identifier: Apache-2.0
"""Branches of steady whirl over a parameter, by pseudo-arclength continuation (Keller 1977).

Shape, whirl speed and parameter move together along the branch, so that it is followed around folds, where it turns
back in the parameter. A branch ends where it leaves the range, where the string leaves the wall, or where Newton's
method does not converge; the reason is kept.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations, solve
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState, state_of
from drill_twin.scene.load import override
from drill_twin.scene.set_points.command import Command

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 0.02, 0.1, 1e-5
"""Steps along the branch, in clearances, rotations and ranges of the parameter together."""
CORRECTIONS, EASY = 8, 4
"""Most iterations of a corrector, and the number of iterations up to which the next step grows."""
GROWTH, TOLERANCE, DIFFERENCE = 1.4, 1e-8, 1e-6
MOST_POINTS = 400
SAME_RATIO, SAME_RADIUS = 3e-3, 0.02
"""Differences of whirl over rotation, and of radii over the clearance, between a state and a point of its branch."""
ON_WALL = 0.99
"""Least radius over the clearance of a whirl on the wall."""


class BranchParameter(NamedTuple):
    """A number that a branch is followed in."""

    name: str
    """`load` [N], `speed` [rad/s], or a key of the scene, in SI."""
    low: float
    high: float
    at: Callable[[float], tuple[TurningEquations, Command]]
    """Equations and command for a value."""


@dataclass(frozen=True, eq=False)
class Branch:
    """Steady whirls along a branch."""

    parameter: str
    values: Array
    """Values of the parameter, shape (p,)."""
    states: tuple[WhirlState, ...]
    folds: tuple[int, ...]
    """Points next to which the branch turns back in the parameter."""
    hopf: tuple[int, ...]
    """First points after a change of stability by an oscillation in the turning frame."""
    ends: tuple[str, str]
    """Reasons for the ends: at the first point and at the last."""


def load_of(turning: TurningEquations, command: Command, low: float, high: float) -> BranchParameter:
    """Weight on bit as parameter [N]."""
    return BranchParameter("wob", low, high, lambda value: (turning, Command(value, command.rotation)))


def speed_of(turning: TurningEquations, command: Command, low: float, high: float) -> BranchParameter:
    """Rotation as parameter [rad/s]."""
    return BranchParameter("rpm", low, high, lambda value: (turning, Command(command.weight_on_bit, value)))


def key_of(turning: TurningEquations, command: Command, key: str, low: float, high: float) -> BranchParameter:
    """Number of the scene as parameter, by its key, such as `effects.wall_friction.coefficient`; SI."""
    scene = turning.equations.scene
    elements = turning.equations.model.rod.length.size

    def at(value: float) -> tuple[TurningEquations, Command]:
        changed = override(scene, {"numerics.elements": elements, key: value})
        return TurningEquations(EquationsOfMotion(changed)), command

    return BranchParameter(key, low, high, at)


class _Point(NamedTuple):
    whirl: SteadyWhirl
    value: float
    tangent: Array  # of the free unknowns over the clearance, omega over the rotation, parameter over its range


class _Follower:
    """Continuation from one state."""

    def __init__(self, parameter: BranchParameter, start: SteadyWhirl, value: float) -> None:
        turning, _ = parameter.at(value)
        self.parameter, self.turning = parameter, turning
        self.held = turning.frame.farthest(turning.frame.values(start.u))
        self.range = parameter.high - parameter.low
        rotation = abs(start.command.rotation)
        self.scale = np.concatenate([np.full(turning.equations.unknowns, turning.clearance), [self.range]])
        self.scale[self.held] = rotation

    def system(self, whirl: SteadyWhirl, value: float) -> tuple[Array, Array]:
        """Residual, and its derivatives by the scaled unknowns and the parameter, shape (m,) and (m, m + 1)."""
        turning, command = self.parameter.at(value)
        own = replace(whirl, command=command)
        system = turning.at(own)
        residual = system.residual
        matrix = system.rows.dense(turning.stiffness(system, own.omega))
        matrix[:, self.held] = turning.by_omega(system, own)
        step = DIFFERENCE * self.range
        beside, other = self.parameter.at(value + step)
        by_value = (beside.at(replace(whirl, command=other)).residual - residual) / step
        return residual, np.column_stack([matrix, by_value]) * self.scale

    def tangent(self, matrix: Array, last: Array) -> Array:
        """Unit tangent in the sense of the last tangent."""
        whole = np.vstack([matrix, last])
        right = np.zeros(last.size)
        right[-1] = 1.0
        found = solve(whole, right)
        return np.asarray(found / np.linalg.norm(found))

    def moved(self, whirl: SteadyWhirl, value: float, step: Array) -> tuple[SteadyWhirl, float]:
        """Whirl and value after a step of the scaled unknowns."""
        change = step * self.scale
        omega, change[self.held] = change[self.held], 0.0
        following = value + float(change[-1])
        _, command = self.parameter.at(following)
        u = whirl.u + self.turning.equations.rows(change[:-1])
        return SteadyWhirl(command, u, whirl.omega + float(omega)), following

    def correct(self, whirl: SteadyWhirl, value: float, tangent: Array) -> tuple[_Point, int] | None:
        """Point of the branch in the plane normal to the tangent, and iterations used; None without convergence."""
        for iteration in range(CORRECTIONS):
            residual, matrix = self.system(whirl, value)
            step = solve(np.vstack([matrix, tangent]), -np.append(residual, 0.0))
            size = float(np.abs(step).max())
            if not size < 1.0:
                return None
            whirl, value = self.moved(whirl, value, step)
            if size < TOLERANCE:
                return _Point(whirl, value, self.tangent(matrix, tangent)), iteration + 1
        return None

    def follow(self, start: SteadyWhirl, value: float, sense: float) -> tuple[list[_Point], str]:
        """Points from a state on, in the sense of growing (1) or falling (-1) values, and the reason of the end."""
        first = np.zeros(self.scale.size)
        first[-1] = sense
        _, matrix = self.system(start, value)
        point = _Point(start, value, self.tangent(matrix, first))
        points, length = [point], FIRST_STEP
        while len(points) < MOST_POINTS:
            guess, at = self.moved(point.whirl, point.value, length * point.tangent)
            found = self.correct(guess, at, point.tangent)
            if found is None:
                length *= 0.5
                if length < SMALLEST_STEP:
                    return points, "Newton's method did not converge"
                continue
            point, iterations = found
            if not self.parameter.low <= point.value <= self.parameter.high:
                return points, "end of the range"
            points.append(point)
            if float(point.whirl.radius.max()) < ON_WALL * self.turning.clearance:
                return points, "the string leaves the wall"
            length = min(length * (GROWTH if iterations <= EASY else 0.7), LARGEST_STEP)
        return points, f"{MOST_POINTS} points"


def branch(parameter: BranchParameter, start: SteadyWhirl, value: float) -> Branch:
    """Follow a steady whirl both ways in a parameter.

    Args:
        parameter: Number and range.
        start: A steady whirl.
        value: Value of the parameter at it.
    """
    follower = _Follower(parameter, start, value)
    down, first = follower.follow(start, value, -1.0)
    up, last = follower.follow(start, value, 1.0)
    # tangents of the first half point backwards along the whole branch
    points = [point._replace(tangent=-point.tangent) for point in reversed(down[1:])] + up
    states = tuple(state_of(parameter.at(point.value)[0], point.whirl) for point in points)
    ahead = np.array([point.tangent[-1] for point in points])
    folds = np.flatnonzero(ahead[:-1] * ahead[1:] < 0.0)
    changed = [k for k in range(1, len(states)) if states[k].is_stable != states[k - 1].is_stable]
    hopf = [k for k in changed if max(states[k], states[k - 1], key=lambda one: one.growth).growth_frequency > 0.0]
    values = np.array([point.value for point in points])
    return Branch(parameter.name, values, states, tuple(map(int, folds)), tuple(hopf), (first, last))


def passes(one: Branch, state: WhirlState, value: float) -> bool:
    """True if a branch passes through a state at a value of its parameter, by its whirl speed and radii."""
    clearance = float(state.whirl.radius.max())
    for k in np.flatnonzero((one.values[:-1] - value) * (one.values[1:] - value) <= 0.0):
        near = one.states[k] if abs(one.values[k] - value) < abs(one.values[k + 1] - value) else one.states[k + 1]
        apart = float(np.abs(near.whirl.radius - state.whirl.radius).max())
        if abs(near.ratio - state.ratio) < SAME_RATIO and apart < SAME_RADIUS * clearance:
            return True
    return False
