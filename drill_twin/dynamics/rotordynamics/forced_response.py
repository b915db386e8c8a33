# SPDX-License-Identifier: Apache-2.0
"""Forced response of an assembly to mass unbalance and to a bend, over the speed of rotation.

Both turn with the string: f(t) = Re(F exp(i Omega t)) with F of low - i side. The response about the balance is the
solution of (K + i Omega C - Omega^2 M) q = F with the equations at that speed: small motions, in which every contact
holds. Where an amplitude is larger than the clearance, or a side force changes by more than it is, the string hits the
wall or lifts off it: the speed is right then, the amplitude is not.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.audit.energy import gauss_positions, off_axis
from drill_twin.dynamics.rotordynamics.assembly import Assembly
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import Mode, balance
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model import SPIN, element_unknowns, locate
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

OFFSET = 1e-3
"""Distance of the mass centre from the centre line, all along the assembly [m]."""
BEND, JOINT = 1e-3, 9.0
"""Bend of the lowest joint, or of half a shorter string: deflection at the middle of a joint of that length [m]."""
SPEEDS, SLOWEST = 120, 0.05
"""Speeds, and the lowest over the fastest."""
BESIDE = (-3.0, -1.0, 0.0, 1.0, 3.0)
"""Speeds about each critical one, in half widths of its peak."""
POINTS, INTERPOLATED, TOGETHER = 16, 1e-8, 16
"""Number of points of the interpolation in speed, its error over the diagonal up to which it is taken, and number of
speeds at a time (memory). It was 1e-9 in wells, and the response off by 1e-7 of its largest at most; chosen."""
SPAN = 5.0
"""Length of a contact that is looked at, from its lower end [m]."""


class ForcedResponse(NamedTuple):
    """Amplitudes over p speeds, for each cause: unbalance, bend."""

    speeds: Array
    """[rad/s], shape (p,)."""
    marks: dict[str, float]
    """Marks of the scene below the cut and their distance from the bit [m]."""
    contacts: tuple[tuple[float, float], ...]
    """Ends of the parts that touch the wall, at most `SPAN` of each, from the bit [m]; c of them."""
    static: Array
    """Side force of each in the balance [N], shape (c,)."""
    amplitude: Array
    """Largest distance from the balance at the marks, and the largest of the assembly [m]; (p, 2, marks + 1)."""
    side_force: Array
    """Sum of the amplitudes of each contact's side force [N], shape (p, 2, c)."""


def forced_response(assembly: Assembly, modes: list[Mode], fastest: float) -> ForcedResponse:
    """Response of an assembly up to a speed [rad/s], finer about the critical speeds of its modes."""
    equations, model = assembly.equations, assembly.equations.model
    places = np.linspace(SLOWEST * fastest, fastest, SPEEDS)
    near = [abs(mode.eigenvalue.imag) - share * mode.growth for mode in modes for share in BESIDE]
    speeds = np.unique(np.concatenate([places, [one for one in near if SLOWEST * fastest < one < fastest]]))
    own = ((mark.name, mark.distance_from_bit) for mark in equations.scene.string.marks)
    marks = {name: place for name, place in own if place < assembly.extent.cut}
    at, inside = locate(model.rod, list(marks.values())), model.rod.arc <= assembly.extent.assembly
    wall = getattr(equations.parameters, "wall", None)
    contacts, static, gradient = _contacts(assembly, wall)
    amplitude, force = np.zeros((speeds.size, 2, len(marks) + 1)), np.zeros((speeds.size, 2, len(contacts)))
    done = 0
    for values in _responses(assembly, speeds, fastest):
        rows, block = equations.rows(values), slice(done, done := done + len(values))
        local = assembly.frame.local(rows)
        shown = np.einsum("pi,...pic->...pc", at.shape[:, 0], element_unknowns(local)[..., at.element, :, :])
        amplitude[block] = np.concatenate([_radius(shown), _radius(local)[..., inside].max(-1, keepdims=True)], -1)
        moved = (gauss_positions(model.rod, assembly.frame.fixed(rows)) * gradient).sum(axis=-1)
        changes = np.abs(moved).reshape(*moved.shape[:2], -1, 2).sum(axis=-1)
        for k, elements in enumerate(contacts.values()):
            force[block, :, k] = changes[..., elements].sum(axis=-1)
    return ForcedResponse(speeds, marks, tuple(contacts), static, amplitude, force)


def _radius(local: ComplexArray) -> Array:
    """Largest distance in an elliptic motion of components low and side, the first two columns [m]."""
    low, side = local[..., 0], local[..., 1]
    return np.asarray(0.5 * (np.abs(low + 1j * side) + np.abs(low - 1j * side)))


def _responses(assembly: Assembly, speeds: Array, fastest: float) -> Iterator[ComplexArray]:
    """Values of the unknowns by speed and cause, some speeds at a time; shape (b, 2, unknowns).

    The entries of K + i Omega C - Omega^2 M are smooth in the speed: interpolated over its logarithm through Chebyshev
    points. Where they are not, by the entries at both ends, at which an interpolation is least exact, each speed's are
    computed.
    """

    def exact(speed: float) -> ComplexArray:
        mass, damping, stiffness = assembly.entries(speed, fastest)
        return np.asarray(stiffness - speed**2 * mass + 1j * speed * damping)

    row, column, loads, x = assembly.rows.row, assembly.rows.column, _loads(assembly), np.log(speeds)
    points = np.cos(np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    given = np.array([exact(speed) for speed in np.exp(0.5 * (x[0] + x[-1] + np.ptp(x) * points))])
    basis = chebvander((2.0 * x - x[0] - x[-1]) / np.ptp(x), POINTS - 1)
    weights = basis @ np.linalg.inv(chebvander(points, POINTS - 1))
    ends, size = np.array([exact(speeds[0]), exact(speeds[-1])]), np.zeros(assembly.part.size)
    size[column[row == column]] = np.abs(ends[:, row == column]).max(axis=0)
    off = np.abs(weights[[0, -1]] @ given - ends) / np.sqrt(size[row] * size[column])
    smooth = off.max() <= INTERPOLATED
    for block in np.array_split(np.arange(speeds.size), -(-speeds.size // TOGETHER)):
        found = weights[block] @ given.view(float) if smooth else np.array([exact(speed) for speed in speeds[block]])
        whole = np.zeros((block.size, 2, assembly.equations.unknowns), complex)
        for own, speed, entries in zip(whole, speeds[block], found.view(complex), strict=True):
            own[:, assembly.part] = assembly.rows.solver(entries, loads * np.array([speed**2, 1.0])).T
        yield whole


def unbalance_response(scene: Scene, speeds: Array, weight_on_bit: float = 0.0) -> ComplexArray:
    """Steady response at the marks to one unbalance of each disc, per unit of unbalance, over the speed of rotation.

    Entries X of shape (p, discs, marks, 2) [m/(kg m)] are of the centre line across the hole, to its low side (x) and
    level (y): an unbalance U at the angle phi moves a mark by Re(U exp(i phi) X exp(i Omega t)), where at t = 0 the
    zero of the spin is at x. Small motions about the balance at the first speed, as of `forced_response`; the wall is
    not touched beyond its contacts there. Effects as in modes: bow and eccentricity are left out.

    >>> x = unbalance_response(load_scene("rotor_kit"), np.array([100.0, 105.0]))
    >>> 12e-6 * np.abs(x[0, 0, :, 0])  # amplitudes in x at 100 rad/s by 12 g mm on the first disc [m]

    Args:
        scene: A scene; of a mapping `Scene.model_validate(mapping)`, with numbers in SI or text with units.
        speeds: [rad/s], shape (p,).
        weight_on_bit: [N].

    Raises:
        SceneError: The string has no disc, or an effect depends on time.
        RunError: No balance is found from the string on the axis.
    """
    if not scene.string.discs:
        raise SceneError(f"{scene.name}: expected a disc in string.discs, whose unbalance acts, found none")
    equations = EquationsOfMotion(scene)
    model, frame = equations.model, HoleFrame.of(equations)
    held = balance(equations, Command(weight_on_bit, float(speeds[0])), lambda command: equations.on_axis(command)[0])
    nodal = np.zeros((len(model.bodies.node), model.rod.arc.size, 2))
    nodal[np.arange(len(nodal)), model.bodies.node, 0] = 1.0
    loads = _turning(equations, frame, nodal)
    at = locate(model.rod, [mark.distance_from_bit for mark in scene.string.marks])
    found = np.zeros((speeds.size, loads.shape[1], at.element.size, 2), complex)
    v = np.zeros_like(held.u)
    for number, speed in enumerate(speeds):
        v[:, SPIN] = speed
        system = equations.evaluate(Command(weight_on_bit, float(speed)), held.u, v, np.zeros_like(v))
        mass, damping, stiffness = (system.rows.entries(tangent) for tangent in system.tangents)
        entries = stiffness - speed**2 * mass + 1j * speed * damping
        moved = system.rows.solver(entries, speed**2 * loads)
        near = element_unknowns(frame.local(equations.rows(moved.T)))[:, at.element]
        found[number] = np.einsum("pi,kpic->kpc", at.shape[:, 0], near)[..., :2]
    return found


def _loads(assembly: Assembly) -> ComplexArray:
    """Loads by unknown of the part: unbalance over the square of the speed, and bend; shape (m, 2).

    Unbalance m e Omega^2 with the consistent mass of the element; a bend of curvature k acts with the moment EI k on
    the slopes at both ends of an element.
    """
    rod = assembly.equations.model.rod
    nodal = np.zeros((2, rod.arc.size, 2))  # by cause, node, position or slope
    curvature, bent = 8.0 * BEND / JOINT**2, min(JOINT, 0.5 * rod.arc[-1])
    for element in np.flatnonzero(rod.arc[1:] <= assembly.extent.assembly + 1e-6):
        weights = OFFSET * rod.mass[element][:, [0, 2]].sum(axis=1)
        nodal[0, element : element + 2] += weights.reshape(2, 2)
        if rod.arc[element + 1] <= bent:
            moment = rod.bending[element] * curvature
            nodal[1, element : element + 2, 1] += [-moment, moment]
    return _turning(assembly.equations, assembly.frame, nodal)[assembly.part]


def _turning(equations: EquationsOfMotion, frame: HoleFrame, nodal: Array) -> ComplexArray:
    """Loads by unknown that turn with the string, from their sizes by cause, node, force or moment; shape (m, k)."""
    rows = np.zeros((*nodal.shape[:2], 7), complex)
    for own, (force, moment) in zip(rows, nodal.transpose(0, 2, 1), strict=True):
        own[:, 0:3], own[:, 3:6] = frame.forces(force), frame.forces(moment)
    return np.asarray(rows[..., equations.columns][:, equations.free].T)


def _contacts(assembly: Assembly, wall: Wall | None) -> tuple[dict[tuple[float, float], Array], Array, Array]:
    """Parts in contact and their elements, their side force [N], and its gradient at the Gauss points; (2 n, 3)."""
    model = assembly.equations.model
    rod, bore = model.rod, model.wellbore
    if wall is None:
        return {}, np.zeros(0), np.zeros((2 * rod.length.size, 3))
    off = off_axis(model, assembly.u)
    radius = np.linalg.norm(off, axis=1)
    depth, power = np.maximum(radius - bore.clearance, 0.0), 1.0 if wall.linear else 1.5
    weight = 0.5 * np.repeat(rod.length, 2) * wall.stiffness
    force = (weight * depth**power).reshape(-1, 2).sum(axis=1)
    slope = weight * power * np.where(depth > 0.0, depth ** (power - 1.0), 0.0)
    gradient = (slope / np.maximum(radius, 1e-12))[:, None] * off
    touching = np.flatnonzero((force > 0.0) & (rod.arc[1:] <= assembly.extent.assembly))
    found: dict[tuple[float, float], Array] = {}
    for part in np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1):
        if part.size:
            lower = part[rod.arc[part] < rod.arc[part[0]] + SPAN]
            found[float(rod.arc[lower[0]]), float(rod.arc[lower[-1] + 1])] = lower
    return found, np.array([force[part].sum() for part in found.values()]), gradient
