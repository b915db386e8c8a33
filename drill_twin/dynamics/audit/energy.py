# SPDX-License-Identifier: Apache-2.0
"""Energy of a state, in numpy."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.solver.joined.linear_solver import Workspace
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import SPIN, Rod, element_unknowns, locate, part_of
from drill_twin.physics.model.wellbore import offsets


class Energy(NamedTuple):
    """Parts of the rod's energy [J]."""

    kinetic: float
    bending: float
    stretch: float
    torsion: float

    @property
    def total(self) -> float:
        """Sum of the parts [J]."""
        return sum(self)


def energy(rod: Rod, u: Array, v: Array) -> Energy:
    """Energy of the rod, sampled as the kernel samples it.

    Args:
        rod: The string.
        u: Node rows (r, r', psi), shape (n + 1, 7).
        v: Their velocities, shape (n + 1, 7).
    """
    q, dq = element_unknowns(u), element_unknowns(v)
    kinetic = 0.5 * np.einsum("eic,eij,ejc->", dq, rod.mass, dq)
    s0, s1 = v[:-1, 6], v[1:, 6]
    kinetic += 0.5 * float(np.sum(rod.spin_mass / 12.0 * (5 * s0**2 + 2 * s0 * s1 + 5 * s1**2)))
    a = np.einsum("epi,eic->epc", rod.shape[:, :, 1], q)
    b = np.einsum("epi,eic->epc", rod.shape[:, :, 2], q)
    g2 = np.sum(a * a, -1)
    bend2 = np.sum(b * b, -1) / g2 - (np.sum(a * b, -1) / g2) ** 2
    weight = 0.5 * rod.length[:, None]
    bending = 0.5 * float(np.sum(weight * rod.bending[:, None] * bend2))
    g = np.sqrt(g2)
    twist = ((u[1:, 6] - u[:-1, 6]) / rod.length)[:, None] - (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) / (
        g * (g + a[..., 2])
    )
    torsion = 0.5 * float(np.sum(weight * rod.torsion[:, None] * twist**2))
    inner = np.einsum("ei,eic->ec", rod.inner, q)
    strain = np.linalg.norm(u[:, 3:6], axis=1) - 1.0
    square = np.stack([strain[:-1], strain[1:], np.linalg.norm(inner, axis=1) - 1.0], -1) ** 2
    stretch = 0.5 * float(np.sum(rod.axial[:, None] * rod.samples * square))
    return Energy(float(kinetic), bending, stretch, torsion)


def lateral_energy(rod: Rod, u: Array, v: Array) -> Energy:
    """Energy of a string in the lateral form, sampled as its kernel samples it.

    Args:
        rod: The string.
        u: Node rows (r, r', psi), shape (n + 1, 7).
        v: Their velocities, shape (n + 1, 7).
    """
    q, dq = element_unknowns(u)[:, :, :2], element_unknowns(v)[:, :, :2]
    kinetic = 0.5 * np.einsum("eic,eij,ejc->", dq, rod.mass, dq) + 0.5 * float(rod.spin_mass.sum()) * v[-1, 6] ** 2
    b = np.einsum("epi,eic->epc", rod.shape[:, :, 2], q)
    bending = 0.25 * float(np.sum((rod.length * rod.bending)[:, None, None] * b**2))
    return Energy(float(kinetic), bending, 0.0, 0.0)


def joined_energy(rod: Rod, work: Workspace, u: Array, v: Array) -> Energy:
    """Energy of a string that follows the hole above a joint, without the energy of bending above the joint.

    Args:
        rod: The string.
        work: Workspace of the joined form.
        u: Node rows (r, r', psi), shape (n + 1, 7).
        v: Their velocities, shape (n + 1, 7).
    """
    axis, twist, first = work.nodes, work.twist, work.rod.length.size
    above = part_of(rod, first, rod.length.size)
    rows, rates = np.zeros((2, twist.size + 1, 7))
    rows[:, SPIN] = u[first:, SPIN] - np.append(0.0, np.cumsum(twist * above.length))
    rates[:, SPIN] = v[first:, SPIN]
    if axis is None:
        along, tangent, nearer = u[first:, 2], np.array([0.0, 0.0, 1.0]), np.ones(1)
    else:
        at = offsets(axis, u[first:, :3])
        along, tangent = at.along, at.tangent
        # nearer to the centre of curvature, z grows faster than the string moves
        nearer = 1.0 / (1.0 - axis.curvature * (at.off * axis.normal).sum(-1))
    rows[:, 2], rows[:, 5] = along, (u[first:, 3:6] * tangent).sum(-1)
    rates[:, 2], rates[:, 5] = nearer * (v[first:, :3] * tangent).sum(-1), (v[first:, 3:6] * tangent).sum(-1)
    parts = energy(work.rod, u[: first + 1], v[: first + 1]), energy(above, rows, rates)
    return Energy(*(sum(pair) for pair in zip(*parts, strict=True)))


def wall_energy(model: DiscreteModel, wall: Wall, u: Array) -> float:
    """Energy in the wall's spring [J]: K d^q / q per length at the Gauss points, q = 5/2 or 2."""
    depth = np.maximum(np.linalg.norm(off_axis(model, u), axis=1) - model.wellbore.clearance, 0.0)
    power, length = 2.0 if wall.linear else 2.5, model.at_places(model.rod.length)
    return float(np.sum(0.5 * length * wall.stiffness * depth**power / power))


def off_axis(model: DiscreteModel, u: Array) -> Array:
    """Vectors from the axis of the hole, across it, to the centre line at the Gauss points [m], shape (2 n, 3)."""
    places, axis = gauss_positions(model.rod, u), model.wellbore.axis
    return places * [1.0, 1.0, 0.0] if axis is None else offsets(axis, places).off


def gauss_positions(rod: Rod, u: Array) -> Array:
    """Centre line at the Gauss points [m], shape (..., 2 n, 3)."""
    places: Array = np.einsum("epi,...eic->...epc", rod.shape[:, :, 0], element_unknowns(u))
    return places.reshape(*u.shape[:-2], -1, 3)


def rows_at(rod: Rod, rows: Array, arc: Array) -> Array:
    """Node rows (r, r', psi) at other places from the bit [m], by the shape functions; shape (p, 7)."""
    element, _, shape = locate(rod, arc)
    nodal = np.einsum("pdi,pic->pdc", shape[:, :2], element_unknowns(rows)[element]).reshape(-1, SPIN)
    return np.column_stack([nodal, np.interp(arc, rod.arc, rows[:, SPIN])])
