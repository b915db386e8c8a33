# SPDX-License-Identifier: Apache-2.0
"""The loaded string in static balance: straight, buckled, on the wall.

Pseudo-transient continuation (Kelley and Keyes 1998): backward Euler steps, each from rest, so that nothing swings.
From rest a step of h moves by ``(M / h^2 + K)^-1`` times the force out of balance: small steps go downhill in energy,
away from balances that do not hold, long ones are Newton's method. Steps grow as the force falls. A balance that a
nudge leaves (a straight string above its buckling load) is none, and is gone on from.
"""

from typing import NamedTuple, Protocol

import numpy as np

from drill_twin.audit.energy import element_unknowns
from drill_twin.base.arrays import Array
from drill_twin.errors import RunError
from drill_twin.model.mesh import Rod
from drill_twin.solver.spatial.assembly import FAR, NEAR

BALANCED = 1e-6  # force out of balance at a node, over the largest force there is
FIRST = 0.5  # first step over the growth time of buckling: shorter than 1, so that an unstable shape is left
LONGEST_FIRST = 1.0  # first step of a string that nothing can buckle [s]
FASTER = 1.5  # largest growth of the step
DRIFT = 1.2  # growth of the force by which steps neither grow nor shrink
LONGEST = 1e4  # longest step over the first
MOST_FAILURES = 200  # steps that Newton's method could not take, before the search is given up
MOST_LEAPS = 2000
PUSH, NUDGE = 0.1, 0.05  # sizes of the first disturbance and of the test, in radii of the string
TEST_LEAPS = 200
LEFT = 1.5  # a shape is left when the nudge has grown so much
WAVES = 5  # half waves of a disturbance


class StringAtRest(Protocol):
    """A string at rest that can be moved towards balance (`drill_twin.twin.Twin.pseudo_transient_step`)."""

    @property
    def unknowns(self) -> tuple[Array, Array]:
        """Node rows and their velocities."""

    @property
    def rod(self) -> Rod:
        """The meshed string."""

    def pseudo_transient_step(self, seconds: float) -> bool:
        """One backward Euler step from rest to rest; False, and nothing moved, where Newton's method fails."""


class Balance(NamedTuple):
    """How well a string is in balance."""

    force: float
    """Largest force out of balance at a node [N]."""
    leaps: int
    """Steps it took."""


def smooth_push(arc: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """A smooth random sideways shape of size 1, at rest at both ends, and its slope [1/m]; shapes (n + 1, 2)."""
    share = arc / arc[-1]
    place, slope = np.zeros((arc.size, 2)), np.zeros((arc.size, 2))
    for half_waves in range(1, WAVES + 1):
        wave = np.pi * half_waves
        for column in range(2):
            size = random.normal() / half_waves
            # sin^2 and its slope are zero at both ends, as every kind of end allows
            place[:, column] += size * np.sin(wave * share) ** 2
            slope[:, column] += size * wave / arc[-1] * np.sin(2.0 * wave * share)
    return place, slope


def settle(string: StringAtRest, growth: float, load: float, seed: int) -> Balance:
    """Move a string at rest into a balance that holds.

    Args:
        string: The string, at a first guess.
        growth: Time in which the fastest buckling wave grows e-fold [s] (`drill_twin.discretisation.resolution`).
        load: The largest force there is, by which balance is judged [N].
        seed: Of the disturbance that decides to which side a straight string buckles.

    Raises:
        RunError: No balance was found.
    """
    random = np.random.default_rng(seed)
    first = 2.0 * min(FIRST * growth, LONGEST_FIRST)  # a pseudo_transient_step is half a step of the midpoint rule
    radius = float(string.rod.outer_radius.min())
    leaps = 0
    _push(string, PUSH * radius, random)
    while True:
        force, used = _relax(string, first, BALANCED * load, MOST_LEAPS - leaps)
        leaps += used
        if _holds(string, first, NUDGE * radius, random):
            return Balance(force, leaps)
        leaps += TEST_LEAPS


def _push(string: StringAtRest, size: float, random: np.random.Generator) -> None:
    place, slope = smooth_push(string.rod.arc, random)
    u, _ = string.unknowns
    u[:, 0:2] += size * place
    u[:, 3:5] += size * slope


def _relax(string: StringAtRest, first: float, tolerance: float, most: int) -> tuple[float, int]:
    u, _ = string.unknowns
    step, last, force, failures = first, np.inf, np.inf, 0
    for count in range(1, most + 1):
        before = u.copy()
        if not string.pseudo_transient_step(step):
            step *= 0.25
            failures += 1
            if failures > MOST_FAILURES:
                break
            continue
        force = _force(string.rod, u - before, 0.5 * step)
        if force < (2.0 * tolerance if step <= first else tolerance):
            if step <= first:
                return force, count
            step, last = first, np.inf  # a long step may have gone far along a path that little opposes: look closely
            continue
        step = float(np.clip(step * np.clip(DRIFT * last / force, 0.5, FASTER), first, LONGEST * first))
        last = force
    u = string.unknowns[0]
    raise RunError(
        f"rig.start: expected a static equilibrium under the load, found none: {force:.3g} N are still out of balance "
        f"where {tolerance:.3g} N may be, largest lateral place {np.hypot(u[:, 0], u[:, 1]).max():.3g} m. Start from "
        "the axis instead (rig.start: axis), take a lower load, more elements, or list a wall that holds the string"
    )


def _force(rod: Rod, moved: Array, half: float) -> float:
    """Largest force out of balance at a node [N]: backward Euler from rest says M moved / h^2."""
    forces = np.einsum("eij,ejc->eic", rod.mass, element_unknowns(moved)) / half**2
    nodal = np.zeros((rod.length.size + 1, 3))
    nodal[:-1] += forces[:, 0]
    nodal[1:] += forces[:, 2]
    return float(np.linalg.norm(nodal, axis=1).max())


def _holds(string: StringAtRest, step: float, size: float, random: np.random.Generator) -> bool:
    """Whether the string comes back from a nudge, or at least does not go further; it is put back if so."""
    u, rod = string.unknowns[0], string.rod
    balance = u.copy()
    mass = np.append(rod.line_mass * rod.length, 0.0) + np.append(0.0, rod.line_mass * rod.length)

    def away() -> float:
        return float(np.sqrt(np.sum(mass[:, None] * (u[:, :2] - balance[:, :2]) ** 2)))  # in this norm it only shrinks

    _push(string, size, random)
    nudged = away()
    for _ in range(TEST_LEAPS):
        string.pseudo_transient_step(step)
        if away() > LEFT * nudged:
            return False
    u[:] = balance
    return True


def torques(rod: Rod, acceleration: Array) -> Array:
    """Torques at the nodes [N m] that spin the string up so [rad/s2]; both shape (n + 1,)."""
    torque = np.zeros(acceleration.size)
    torque[:-1] += rod.spin_mass * (NEAR * acceleration[:-1] + FAR * acceleration[1:])
    torque[1:] += rod.spin_mass * (FAR * acceleration[:-1] + NEAR * acceleration[1:])
    return torque


def wind_up(rod: Rod, torque: Array) -> Array:
    """Spin that torques at the nodes [N m] give a string held at the top [rad]; both shape (n + 1,)."""
    twist = np.cumsum(torque[:-1]) * rod.length / rod.torsion
    return np.append(np.cumsum(twist[::-1])[::-1], 0.0)
