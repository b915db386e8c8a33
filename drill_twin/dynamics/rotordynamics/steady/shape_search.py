# SPDX-License-Identifier: Apache-2.0
"""First guesses of steady whirls: shapes in balance at a whirl speed, and the speeds at which nothing drives them.

At a whirl speed omega that is not one of the string's own, an extra force tau M J u along the path keeps the shape in
whirl. The shape and tau follow by pseudo-transient continuation (Kelley and Keyes 1998), whose short first steps
descend in energy as in `drill_twin.dynamics.equilibrium`, so that it ends on the wall and not on the
axis. Where tau(omega) changes its sign, a steady whirl is near. Each shape is the first guess of the next speed.

Friction with a steep regularisation is entered in stages: its slip is proportional to the regularisation where the
string rolls, so each stage is foreseen by a straight line through the last two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.equilibrium import random_shape
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, undamped_basis
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations
from drill_twin.dynamics.rotordynamics.turning_frame import quarter_turn
from drill_twin.dynamics.solver.linearisation import MASS
from drill_twin.scene.set_points.command import Command

SPEEDS = 43
"""Whirl speeds tried between backward and forward whirl at the speed of rotation; more where rolling is faster."""
RANGE = 1.05
"""Largest whirl speed tried, over the rotation; backward over the speed of rolling, where that is larger."""
STEPS, FOLLOWING_STEPS, RESTART_STEPS = 250, 30, 80
"""Most pseudo-transient steps from a first shape, from the shape at the speed before, and from a first shape again."""
CONVERGED = 1e-7
"""Step of the shape over the clearance at which a shape is in balance."""
LARGEST_MOVE = 0.3
"""Step over the clearance that is taken back."""
FIRST_STEP, LONGEST_STEP = 0.3, 1e3
"""Of the pseudo-transient steps: over the growth of buckling, and over the first."""
REFINEMENTS = 3
"""Shapes computed between two with drives of different sign."""
START_SIZE = 0.3
"""Of a first random shape over the clearance."""
SOFT_CREEP, CREEP_FACTOR = 1e-2, 5.0
"""Slip of regularisation at which shapes are sought [m/s], and its ratio from stage to stage."""


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
        pencil = Pencil(system.mass[x], system.damping[x], system.stiffness[x])
        self._modes = undamped_basis(pencil, 4)
        lowest = float(np.einsum("ik,ij,jk->k", self._modes, pencil.stiffness, self._modes).min())
        self._lowest = lowest

    def starts(self, seed: int, random: int) -> Iterator[Array]:
        """First shapes: random ones, then the lowest modes in one plane."""
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
        moved = self.turning.frame.values(u - self.axis)
        return np.asarray(self.axis + self.turning.equations.rows(moved))

    def family(self, start: Array) -> list[Shape]:
        """Shapes over whirl speeds, from the fastest forward whirl down; each begins from the one before."""
        fastest = RANGE * max(abs(self.command.rotation), 1e-3)
        model = self.turning.equations.model
        rolling = max(1.0, float((model.contact_radius / model.wellbore.clearance).max()))
        count = 1 + round((SPEEDS - 1) * (1.0 + rolling) / 2.0)
        shapes: list[Shape] = []
        last = start
        tries = STEPS
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
        turning, frame = self.turning, self.turning.frame
        first = FIRST_STEP / max(1.0, omega**2 - self._lowest)
        whirl, drive, length, last = SteadyWhirl(self.command, start, omega), 0.0, first, np.inf
        for _ in range(steps):
            system = turning.at(whirl)
            mass, rows = system.tangents[MASS], system.rows
            along = rows.times(mass, frame.values(quarter_turn(whirl.u)))
            if last == np.inf:
                drive = -float(along @ system.residual) / max(float(along @ along), 1e-300)
            matrix = turning.stiffness(system, omega) + drive * rows.times_j(mass) + mass / length
            held = frame.farthest(frame.values(whirl.u))
            residual = system.residual + drive * along
            step = rows.solve(matrix, -residual, held, along)
            change, step[held] = float(step[held]), 0.0
            size = float(np.abs(step).max()) / turning.clearance
            if not np.isfinite(size):
                return None
            if size > LARGEST_MOVE:
                length *= 0.25
                continue
            whirl, drive = replace(whirl, u=whirl.u + turning.equations.rows(step)), drive + change
            if size < CONVERGED and length > LONGEST_STEP * first:
                on_wall = float(whirl.radius.max()) > 0.9 * turning.clearance
                return Shape(whirl, drive) if on_wall else None
            force = float(np.abs(residual).max())
            length = max(length * float(np.clip(1.5 * last / max(force, 1e-300), 0.5, 3.0)), first)
            last = force
        return None

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
