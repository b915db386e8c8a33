# SPDX-License-Identifier: Apache-2.0
"""First guesses of slow whirls: damped steps in time from helices and plane shapes.

A string with much load lies on the wall as a helix, and creeps around with a hundredth of the rotation. No plane shape
at a whirl speed leads there, but long steps of the linearly implicit Euler method do, which damp all that is fast.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from drill_twin.core.arrays import Array
from drill_twin.dynamics.rotordynamics.steady.shape_search import ShapeSearch
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl
from drill_twin.physics.model.mesh import SPIN

TURNS = (-1.0, 1.0)
"""Turns of the helices over the length, from the bit up, positive in the sense of rotation."""
RADIUS, RUN_IN = 0.97, 0.3
"""Radius of a helix over the clearance, and share of the length in which it leaves an end held on the axis."""
STEP, STEPS, SHORTEST = 0.02, 500, 1e-6
"""Longest step [s], most steps, and the step at which a start is given up [s]."""
LARGEST_MOVE, LARGEST_CORRECTION = 0.1, 0.05
"""Of a step, over the clearance."""
STEADY = 1e-4
"""Velocity in the frame of the whirl, over clearance and rotation, at which a motion is steady."""
ACROSS = (0, 1, 3, 4)


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
    slope = CubicSpline(arc, place)(arc, 1)
    u[:, 0], u[:, 1], u[:, 3], u[:, 4] = place.real, place.imag, slope.real, slope.imag
    return search.on_constraints(u)


def damped(search: ShapeSearch, start: Array) -> SteadyWhirl | None:
    """Whirl that damped steps from a shape at rest settle in; None if they settle in none."""
    turning, command = search.turning, search.command
    equations, length = turning.equations, STEP
    u, v = start.copy(), np.zeros_like(start)
    v[:, SPIN] = command.rotation
    for _ in range(STEPS):
        ahead = u.copy()
        ahead[:, ACROSS] += length * v[:, ACROSS]
        system = equations.evaluate(command, ahead, v, np.zeros_like(u))
        mass, damping, stiffness = system.tangents
        change = system.rows.solve(mass / length + damping + length * stiffness, -system.residual)
        corrected = v + equations.rows(change)
        move = length * float(np.abs(corrected[:, :2]).max()) / turning.clearance
        correction = length * float(np.abs(change).max()) / turning.clearance
        if not (move <= LARGEST_MOVE and correction <= LARGEST_CORRECTION):
            length *= 0.5
            if length < SHORTEST:
                return None
            continue
        u[:, ACROSS] += length * corrected[:, ACROSS]
        v, length = corrected, min(1.3 * length, STEP)
        place, speed = u[:, 0] + 1j * u[:, 1], v[:, 0] + 1j * v[:, 1]
        omega = float((np.vdot(place, speed) / max(float(np.vdot(place, place).real), 1e-300)).imag)
        moving = float(np.abs(speed - 1j * omega * place).max())
        if moving < STEADY * turning.clearance * abs(command.rotation):
            return SteadyWhirl(command, u, omega)
    return None
