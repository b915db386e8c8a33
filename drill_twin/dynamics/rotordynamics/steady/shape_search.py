# SPDX-License-Identifier: Apache-2.0
"""First guesses of steady whirls: shapes in balance at a whirl speed, and the speeds at which nothing drives them.

At a whirl speed omega that is not the string's own, an extra force tau M J u along the path keeps the shape in
whirl. The shape and tau follow by pseudo-transient continuation (Kelley and Keyes 1998), whose short first steps
descend in energy as in `drill_twin.dynamics.equilibrium`, so that it ends on the wall and not on the
axis. Where tau(omega) changes its sign, a steady whirl is near. Each shape is the first guess of the next speed.

A string with much load lies on the wall as a helix, and creeps around with a hundredth of the rotation. No plane shape
at a whirl speed leads there. Damped steps in time do, from helices and plane shapes at rest: long steps of the linearly
implicit Euler method damp all that is fast.

Friction with a steep regularisation is entered in stages: its slip is proportional to the regularisation where the
string rolls, so each stage is foreseen by a straight line through the last two.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.equilibrium import random_shape
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, undamped_basis
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import Pace, SteadyWhirl, TurningEquations, settled
from drill_twin.physics.model import SPIN
from drill_twin.scene.set_points.command import Command

SPEEDS = 43
"""Whirl speeds tried between backward and forward whirl at the speed of rotation; more where rolling is faster."""
RANGE = 1.05
"""Largest whirl speed tried, over the rotation; backward over the speed of rolling, where that is larger."""
STEPS, FOLLOWING_STEPS, RESTART_STEPS = 250, 30, 80
"""Most pseudo-transient steps from a first shape, from the shape at the speed before, and from a first shape again."""
CONVERGED = 1e-7
"""Step of the shape over the clearance at which a shape is in balance."""
FIRST_STEP, LONGEST_STEP = 0.3, 1e3
"""Of the pseudo-transient steps: over the growth of buckling, and over the first."""
REFINEMENTS = 3
"""Shapes computed between two with drives of different sign."""
START_SIZE = 0.3
"""Of a first random shape over the clearance."""
SOFT_CREEP, CREEP_FACTOR = 1e-2, 5.0
"""Slip of regularisation at which shapes are sought [m/s], and its ratio from stage to stage."""
TURNS = (-1.0, 1.0)
"""Turns of the helices over the length, from the bit up, positive in the sense of rotation."""
RADIUS, RUN_IN = 0.97, 0.3
"""Radius of a helix over the clearance, and share of the length in which it leaves an end held on the axis."""
DAMPED_STEP, DAMPED_STEPS, SHORTEST = 0.02, 500, 1e-6
"""Longest damped step [s], most of them, and the step at which a start is given up [s]."""
DAMPED_MOVE, CORRECTION = 0.1, 0.05
"""Largest move and largest correction in a damped step, over the clearance."""
STEADY = 1e-4
"""Velocity in the frame of the whirl, over clearance and rotation, at which a motion is steady."""
ACROSS = (0, 1, 3, 4)


class Shape(NamedTuple):
    """Shape in balance at a whirl speed, and the extra force per momentum that holds it there [1/s2]."""

    whirl: SteadyWhirl
    drive: float


class ShapeSearch:
    """Search for steady whirls under one command.

    Attributes:
        turning: The equations.
        command: Weight on bit and rotation.
        axis: Rows of the string on the axis, shape (n + 1, 7).
    """

    def __init__(self, turning: TurningEquations, command: Command) -> None:
        """Find the fastest growth of buckling, which sets the first step."""
        self.turning, self.command = turning, command
        self.axis, _ = turning.equations.on_axis(command)
        system = turning.at(SteadyWhirl(command, self.axis, 0.0))
        x = np.ix_(turning.frame.x, turning.frame.x)
        pencil = Pencil(*(matrix[x] for matrix in system.matrices))
        self._modes = undamped_basis(pencil, 4)
        self._lowest = float(np.einsum("ik,ij,jk->k", self._modes, pencil.stiffness, self._modes).min())

    def starts(self, seed: int, random: int) -> Iterator[Array]:
        """First shapes: random shapes, then the lowest modes in one plane."""
        equations, size = self.turning.equations, START_SIZE * self.turning.clearance
        generator = np.random.default_rng(seed)
        for _ in range(random):
            u = self.axis.copy()
            place, slope = random_shape(equations.model.rod.arc, generator)
            u[:, 0:2] += size * place
            u[:, 3:5] += size * slope
            yield self.on_constraints(u)
        for mode in self._modes.T:
            values = np.zeros(equations.unknowns)
            values[self.turning.frame.x] = mode
            rows = equations.rows(values)
            yield self.axis + rows * (size / np.abs(rows[:, 0]).max())

    def on_constraints(self, u: Array) -> Array:
        """The axis, with the free unknowns of u."""
        return np.asarray(self.axis + self.turning.equations.rows(self.turning.frame.values(u - self.axis)))

    def family(self, start: Array) -> list[Shape]:
        """Shapes over whirl speeds, from the fastest forward whirl down; each begins from the shape before."""
        fastest = RANGE * max(abs(self.command.rotation), 1e-3)
        model = self.turning.equations.model
        rolling = max(1.0, float((model.contact_radius / model.wellbore.clearance).max()))
        count = 1 + round((SPEEDS - 1) * (1.0 + rolling) / 2.0)
        shapes: list[Shape] = []
        last, tries = start, STEPS
        for omega in np.linspace(fastest, -rolling * fastest, count):
            found = self.relax(last, float(omega), tries)
            if found is None and last is not start:
                found = self.relax(start, float(omega), RESTART_STEPS)
            if found is not None:
                shapes.append(found)
                last = found.whirl.u
            tries = FOLLOWING_STEPS if shapes else RESTART_STEPS
        return shapes

    def relax(self, start: Array, omega: float, steps: int = STEPS) -> Shape | None:
        """Shape in balance at a whirl speed, near a first shape; None if there is none."""
        first = FIRST_STEP / max(1.0, omega**2 - self._lowest)
        pace = Pace(steps, first, (first, math.inf), CONVERGED, LONGEST_STEP * first)
        found = settled(self.turning, SteadyWhirl(self.command, start, omega), pace, driven=True)
        if found is None or float(found[0].radius.max()) <= 0.9 * self.turning.clearance:
            return None
        return Shape(*found)

    def crossings(self, shapes: list[Shape]) -> Iterator[SteadyWhirl]:
        """Guesses of steady whirls: shapes between two with drives of different sign (false position)."""
        for first, second in pairwise(shapes):
            one, other = first, second
            if one.drive * other.drive > 0.0:
                continue
            for _ in range(REFINEMENTS):
                share = one.drive / (one.drive - other.drive) if one.drive != other.drive else 0.0
                omega = one.whirl.omega + share * (other.whirl.omega - one.whirl.omega)
                near = min(one, other, key=lambda shape: abs(shape.drive))
                between = self.relax(near.whirl.u, omega, RESTART_STEPS)
                if between is None:
                    break
                one, other = (between, other) if between.drive * other.drive <= 0.0 else (one, between)
            yield min(one, other, key=lambda shape: abs(shape.drive)).whirl


def stiffen_friction(turning: TurningEquations, whirl: SteadyWhirl, real: float) -> SteadyWhirl | None:
    """Follow a steady whirl from `SOFT_CREEP` to the real regularisation of the friction [m/s]; None if it is lost."""
    creep, before = SOFT_CREEP, None
    while creep > real * (1.0 + 1e-9):
        following = max(creep / CREEP_FACTOR, real)
        set_creep(turning, following)
        guess = whirl
        if before is not None:
            at, other = before
            share = (following - creep) / (creep - at)
            omega = whirl.omega + share * (whirl.omega - other.omega)
            guess = replace(whirl, u=whirl.u + share * (whirl.u - other.u), omega=omega)
        before = creep, whirl
        found = turning.newton(guess) or turning.newton(whirl)
        if found is None:
            return None
        whirl, creep = found, following
    return whirl


def set_creep(turning: TurningEquations, creep: float) -> None:
    """Set the regularisation of the wall's friction [m/s], where the scene lists it."""
    parameters = turning.equations.parameters
    if hasattr(parameters, "wall_friction"):
        friction = parameters.wall_friction._replace(creep=creep)
        turning.equations.parameters = parameters._replace(wall_friction=friction)


def slow_whirls(search: ShapeSearch) -> Iterator[SteadyWhirl]:
    """Guesses of steady whirls from helices and from the lowest modes."""
    for start in (*(helix(search, turns) for turns in TURNS), *search.starts(0, 0)):
        found = damped(search, start)
        if found is not None:
            yield found


def helix(search: ShapeSearch, turns: float) -> Array:
    """Rows of a helix near the wall, which leaves the ends that are held on the axis as a sine, shape (n + 1, 7)."""
    equations, u = search.turning.equations, search.axis.copy()
    arc = equations.model.rod.arc
    along = (arc - arc[0]) / (arc[-1] - arc[0])
    radius = np.full(arc.size, RADIUS * search.turning.clearance)
    for held, distance in zip(~equations.free[[0, -1], 0], (along, 1.0 - along), strict=True):
        if held:
            radius *= np.sin(0.5 * math.pi * np.minimum(distance / RUN_IN, 1.0))
    place = radius * np.exp(1j * math.tau * turns * along)
    from scipy.interpolate import CubicSpline  # takes 0.3 s, which modes do not need

    slope = CubicSpline(arc, place)(arc, 1)
    u[:, 0], u[:, 1], u[:, 3], u[:, 4] = place.real, place.imag, slope.real, slope.imag
    return search.on_constraints(u)


def damped(search: ShapeSearch, start: Array) -> SteadyWhirl | None:
    """Whirl that damped steps from a shape at rest settle in; None if they settle in none."""
    turning, command = search.turning, search.command
    equations, length = turning.equations, DAMPED_STEP
    u, v = start.copy(), np.zeros_like(start)
    v[:, SPIN] = command.rotation
    for _ in range(DAMPED_STEPS):
        ahead = u.copy()
        ahead[:, ACROSS] += length * v[:, ACROSS]
        system = equations.evaluate(command, ahead, v, np.zeros_like(u))
        mass, damping, stiffness = system.tangents
        change = system.rows.solve(mass / length + damping + length * stiffness, -system.residual)
        corrected = v + equations.rows(change)
        move = length * float(np.abs(corrected[:, :2]).max()) / turning.clearance
        correction = length * float(np.abs(change).max()) / turning.clearance
        if not (move <= DAMPED_MOVE and correction <= CORRECTION):
            length *= 0.5
            if length < SHORTEST:
                return None
            continue
        u[:, ACROSS] += length * corrected[:, ACROSS]
        v, length = corrected, min(1.3 * length, DAMPED_STEP)
        place, speed = u[:, 0] + 1j * u[:, 1], v[:, 0] + 1j * v[:, 1]
        omega = float((np.vdot(place, speed) / max(float(np.vdot(place, place).real), 1e-300)).imag)
        moving = float(np.abs(speed - 1j * omega * place).max())
        if moving < STEADY * turning.clearance * abs(command.rotation):
            return SteadyWhirl(command, u, omega)
    return None
