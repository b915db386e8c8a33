# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium of the loaded string, and the initial state of `rig.start: equilibrium` from it.

The string is straight, buckled or on the wall. Pseudo-transient continuation (Kelley and Keyes 1998) finds the
equilibrium: backward Euler steps, each from rest, so that nothing oscillates. From rest a step of h moves by
``(M / h^2 + K)^-1`` times the residual force: small steps descend in energy, away from unstable equilibria; long steps
are Newton's method. Steps grow as the residual decreases. An equilibrium that a perturbation leaves (a straight string
above its buckling load) is unstable, and the search continues from there.

Friction, torque of the rock and excitation are left out of the search for the shape; the torques on the string rotating
in this shape then twist it. A rotating buckled string in a straight vertical hole has no equilibrium: its transition to
whirl is part of the run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.discretisation.discretise import axial_weight, sections_of
from drill_twin.dynamics.discretisation.resolution import growth_time
from drill_twin.dynamics.solver.boundary import LAG
from drill_twin.dynamics.solver.spatial.assembly import FAR, NEAR
from drill_twin.physics.model import element_unknowns
from drill_twin.physics.model.mesh import SPIN, Rod
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

if TYPE_CHECKING:
    from drill_twin.dynamics.twin.dynamics import Dynamics

TOLERANCE = 1e-6  # residual force at a node over the largest load
FIRST_STEP = 0.5  # over the growth time of buckling: below 1, so that an unstable shape is left
LARGEST_FIRST_STEP = 1.0  # of a string without a buckling load [s]
LARGEST_GROWTH = 1.5  # of the step
FORCE_GROWTH = 1.2  # growth of the residual force at which the step is constant
LARGEST_STEP = 1e4  # over the first step
MAX_FAILED_STEPS = 200  # without convergence of Newton's method
MAX_STEPS = 2000
PERTURBATION, TEST_PERTURBATION = 0.1, 0.05  # initial, and in the test of stability, in radii of the string
TEST_STEPS = 200
UNSTABLE_GROWTH = 1.5  # growth of the perturbation from which an equilibrium is unstable
HALF_WAVES = 5  # of a perturbation


def random_shape(arc: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """Smooth random lateral shape of size 1, zero at both ends, and its slope [1/m]; shape (n + 1, 2) each."""
    share = arc / arc[-1]
    place, slope = np.zeros((arc.size, 2)), np.zeros((arc.size, 2))
    for half_waves in range(1, HALF_WAVES + 1):
        wave = np.pi * half_waves
        for column in range(2):
            size = random.normal() / half_waves
            # sin^2 and its slope are zero at both ends, compatible with all boundary conditions
            place[:, column] += size * np.sin(wave * share) ** 2
            slope[:, column] += size * wave / arc[-1] * np.sin(2.0 * wave * share)
    return place, slope


def find_equilibrium(string: Dynamics, growth: float, load: float, seed: int) -> None:
    """Move a string at rest to a stable equilibrium.

    Args:
        string: The string, in an initial guess.
        growth: Time in which the fastest buckling wave grows e-fold [s]
            (`drill_twin.dynamics.discretisation.resolution`).
        load: Largest load, the reference of the residual force [N].
        seed: Seed of the perturbation, which selects the direction of buckling.

    Raises:
        RunError: No equilibrium was found.
    """
    random = np.random.default_rng(seed)
    first = 2.0 * min(FIRST_STEP * growth, LARGEST_FIRST_STEP)  # twice the step of backward Euler
    radius = float(string.rod.outer_radius.min())
    steps = 0
    _perturb(string, PERTURBATION * radius, random)
    while True:
        steps += _converge(string, first, TOLERANCE * load, MAX_STEPS - steps)
        if _is_stable(string, first, TEST_PERTURBATION * radius, random):
            return
        steps += TEST_STEPS


def _perturb(string: Dynamics, size: float, random: np.random.Generator) -> None:
    place, slope = random_shape(string.rod.arc, random)
    u, _ = string.unknowns
    u[:, 0:2] += size * place
    u[:, 3:5] += size * slope


def _converge(string: Dynamics, first: float, tolerance: float, most: int) -> int:
    """Step until the residual force is below a tolerance [N]; returns the number of steps."""
    u, _ = string.unknowns
    step, last, force, failures = first, np.inf, np.inf, 0
    for count in range(1, most + 1):
        before = u.copy()
        if not string.pseudo_transient_step(step):
            step *= 0.25
            failures += 1
            if failures > MAX_FAILED_STEPS:
                break
            continue
        force = _residual_force(string, u - before, 0.5 * step)
        if force < (2.0 * tolerance if step <= first else tolerance):
            if step <= first:
                return count
            step, last = first, np.inf  # confirm with short steps: a long one may go far along a soft direction
            continue
        factor = np.clip(FORCE_GROWTH * last / force, 0.5, LARGEST_GROWTH)
        step = float(np.clip(step * factor, first, LARGEST_STEP * first))
        last = force
    u = string.unknowns[0]
    raise RunError(
        f"rig.start: expected a static equilibrium under the load, found none: residual force {force:.3g} N, "
        f"tolerance {tolerance:.3g} N, largest lateral displacement {np.hypot(u[:, 0], u[:, 1]).max():.3g} m. Start "
        "from the axis instead (rig.start: axis), take a lower load, more elements, or list a wall"
    )


def _residual_force(string: Dynamics, moved: Array, half: float) -> float:
    """Largest residual force at a node [N], M moved / h^2 by backward Euler from rest."""
    forces = np.einsum("eij,ejc->eic", string.rod.mass, element_unknowns(moved)) / half**2
    nodal = np.pad(forces[:, 0], ((0, 1), (0, 0))) + np.pad(forces[:, 2], ((1, 0), (0, 0)))
    if (discs := string.model.bodies) is not None:
        np.add.at(nodal, discs.node, discs.mass[:, None] * moved[discs.node, :3] / half**2)
    return float(np.linalg.norm(nodal, axis=1).max())


def _is_stable(string: Dynamics, step: float, size: float, random: np.random.Generator) -> bool:
    """Test whether a perturbation of the string does not grow; if so, the equilibrium is restored."""
    u, rod = string.unknowns[0], string.rod
    balance = u.copy()
    mass = np.append(rod.line_mass * rod.length, 0.0) + np.append(0.0, rod.line_mass * rod.length)

    def away() -> float:
        return float(np.sqrt(np.sum(mass[:, None] * (u[:, :2] - balance[:, :2]) ** 2)))  # monotonic if stable

    _perturb(string, size, random)
    perturbed = away()
    for _ in range(TEST_STEPS):
        string.pseudo_transient_step(step)
        if away() > UNSTABLE_GROWTH * perturbed:
            return False
    u[:] = balance
    return True


def inertia_torques(rod: Rod, acceleration: Array) -> Array:
    """Torques at the nodes [N m] for an angular acceleration [rad/s2]; both shape (n + 1,)."""
    lower, upper = acceleration[:-1], acceleration[1:]
    of_lower, of_upper = rod.spin_mass * (NEAR * lower + FAR * upper), rod.spin_mass * (FAR * lower + NEAR * upper)
    torques: Array = np.append(of_lower, 0.0) + np.append(0.0, of_upper)
    return torques


def twist_under(rod: Rod, torque: Array) -> Array:
    """Spin under torques at the nodes [N m] of a string fixed at the top [rad]; both shape (n + 1,)."""
    twist = np.cumsum(torque[:-1]) * rod.length / rod.torsion
    return np.append(np.cumsum(twist[::-1])[::-1], 0.0)


SMALLEST_LOAD = 1e-3  # reference of the residual force for a string without weight or load [N]
NEWTON_TOLERANCE = 1e-6  # of Newton's method in the search, as `numerics.tolerance`
INSTANT = 1e-3  # over the travel time of a torsional wave through an element


def static_scene(scene: Scene) -> Scene:
    """Scene with its load, without rotation, excitation and friction, starting from the axis."""
    rig, effects = scene.rig, scene.effects
    stilled = {
        key: block.model_copy(update=dict.fromkeys(block.disabled_for_static, 0.0))
        for key, block in effects.blocks.items()
        if block.disabled_for_static
    }
    weight = rig.weight_on_bit.model_copy(update={"initial": rig.weight_on_bit.value})
    turn = rig.rotation.model_copy(update={"initial": 0.0, "value": 0.0})
    still = rig.model_copy(update={"weight_on_bit": weight, "rotation": turn, "start": "axis"})
    numerics = scene.numerics.model_copy(update={"tolerance": min(scene.tolerance, NEWTON_TOLERANCE)})
    return scene.model_copy(update={"rig": still, "effects": effects.model_copy(update=stilled), "numerics": numerics})


def rotating_scene(scene: Scene) -> Scene:
    """Scene with its first set-points before the first instant too, starting from the axis."""
    rig = scene.rig
    points = zip(("weight_on_bit", "rotation"), rig.first, strict=True)
    begun = {key: getattr(rig, key).model_copy(update={"initial": first}) for key, first in points}
    return scene.model_copy(update={"rig": rig.model_copy(update={**begun, "start": "axis"})})


def start_in_equilibrium(dynamics: Dynamics, make: Callable[[Scene, Rod], Dynamics]) -> None:
    """Set the dynamics to static equilibrium under the first command, in rigid rotation.

    Args:
        dynamics: Dynamics at the first instant.
        make: Constructor of the dynamics of a scene with the mesh of `dynamics`, whatever the set-points.

    Raises:
        RunError: No equilibrium was found.
    """
    scene = dynamics.scene
    weight, _ = scene.rig.first
    hanging = float(np.abs(axial_weight(scene, dynamics.model)).sum())
    growth = growth_time(sections_of(scene), max(abs(weight), 1.0))
    still = make(static_scene(scene), dynamics.rod)
    find_equilibrium(still, growth, max(abs(weight), hanging, SMALLEST_LOAD), scene.numerics.seed)
    begin_turning(dynamics, make, still.unknowns[0])


def begin_turning(dynamics: Dynamics, make: Callable[[Scene, Rod], Dynamics], u: Array) -> None:
    """Set the dynamics to a shape in rigid rotation at the first command, twisted by the torques that resist.

    Args:
        dynamics: Dynamics at the first instant.
        make: As of `start_in_equilibrium`.
        u: Rows of the untwisted string, shape (n + 1, 7); the twist is added to them.

    Raises:
        RunError: The first step of the rotating string does not converge.
    """
    scene, command = dynamics.scene, Command(*dynamics.scene.rig.first)
    v = np.zeros_like(u)
    v[:, SPIN] = command.rotation
    if scene.effects.torsion is not None:
        torque = _resisting_torque(make(rotating_scene(scene), dynamics.rod), u, v, command)
        u[:, SPIN] += twist_under(dynamics.rod, torque)
        drive = dynamics.parameters.drive
        if drive.driven and drive.integral > 0.0:
            drive.memory[LAG] = -torque.sum() / drive.integral
    dynamics.begin(u, v, command)


def _resisting_torque(dynamics: Dynamics, u: Array, v: Array, command: Command) -> Array:
    """Torques on the nodes of the rotating string [N m], the drive's friction included; shape (n + 1,).

    They follow from the acceleration in a short step.
    """
    rod = dynamics.rod
    waves = np.sqrt(rod.torsion * rod.length / rod.spin_mass)
    instant = INSTANT * float((rod.length / waves).min())
    dynamics.begin(u, v, command)
    if not dynamics.advance(command.array(), instant):
        raise RunError(
            "rig.start: expected a step of the rotating string to converge, found no solution of its equations. "
            "Start from the axis instead (rig.start: axis)"
        )
    acceleration = (dynamics.unknowns[1][:, SPIN] - v[:, SPIN]) / instant
    torque = inertia_torques(rod, acceleration)
    body = dynamics.scene.effects.bit_mass
    if body is not None:
        torque[0] += body.inertia * acceleration[0]
    if (discs := dynamics.model.bodies) is not None:
        np.add.at(torque, discs.node, discs.polar * acceleration[discs.node])
    drive = dynamics.parameters.drive
    torque[-1] += (drive.inertia - drive.cancelled) * acceleration[-1]
    return torque
