# SPDX-License-Identifier: Apache-2.0
"""Forces, moments and stresses along the string in a balance, at the middle of each element."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.audit.energy import element_unknowns, gauss_positions
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.wellbore import offsets
from drill_twin.scene import Scene


class AlongString(NamedTuple):
    """Loads at the middle of the elements from the bit up, shape (n,) each."""

    length: Array
    """Of the elements [m]."""
    depth: Array
    """Measured depth of their middle from the top clamp [m]."""
    tension: Array
    """Effective axial force, positive in tension [N]."""
    torque: Array
    """[N m]."""
    bending_moment: Array
    """Largest of the element's integration points [N m]."""
    side_force: Array
    """Force of the wall on the string per length [N/m]."""
    stress: Array
    """Largest equivalent stress of the pipe body (von Mises, at the outer fibre) [Pa]."""
    strain: Array
    """Axial strain of the inner sample, whose force the element carries from node to node [-]."""
    twist: Array
    """Twist per length [rad/m]."""


def along_string(scene: Scene, model: DiscreteModel, wall: Wall | None, u: Array) -> AlongString:
    """Loads of a string in a position.

    Mud of the same density inside and outside presses alike on all faces and adds nothing to the equivalent stress:
    the axial part of it is the effective tension over the area.

    Args:
        scene: The scene, for diameters.
        model: Its discrete model.
        wall: Law of the wall; None without one.
        u: Rows (r, r', psi), shape (n + 1, 7).
    """
    rod, nodal = model.rod, element_unknowns(u)
    strain = np.linalg.norm(np.einsum("ei,eic->ec", rod.inner, nodal), axis=1) - 1.0
    a, b = (np.einsum("epi,eic->epc", rod.shape[:, :, order], nodal) for order in (1, 2))
    g = np.linalg.norm(a, axis=-1)
    bend = np.linalg.norm(np.cross(a, b), axis=-1) / g**2
    reference = -(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) / (g * (g + a[..., 2]))
    twist = (u[1:, 6] - u[:-1, 6]) / rod.length + reference.mean(axis=1)
    tension, torque = rod.axial * strain, rod.torsion * twist
    moment = rod.bending * bend.max(axis=1)
    young = np.array([section.youngs_modulus for section in scene.string.sections])[model.section]
    second, area = rod.bending / young, rod.axial / young
    fibre = np.abs(tension) / area + moment * rod.outer_radius / second
    shear = torque * rod.outer_radius / (2.0 * second)
    return AlongString(
        rod.length, rod.arc[-1] - 0.5 * (rod.arc[1:] + rod.arc[:-1]), tension, torque, moment,
        side_force(model, wall, u), np.sqrt(fibre**2 + 3.0 * shear**2), strain, twist,
    )  # fmt: skip


def side_force(model: DiscreteModel, wall: Wall | None, u: Array) -> Array:
    """Force of the wall per length, mean over each element [N/m], shape (n,)."""
    if wall is None:
        return np.zeros(model.rod.length.size)
    places, bore = gauss_positions(model.rod, u), model.wellbore
    off = places[:, :2] if bore.axis is None else offsets(bore.axis, places).off
    depth = np.maximum(np.linalg.norm(off, axis=1) - bore.clearance, 0.0)
    force = wall.stiffness * depth ** (1.0 if wall.linear else 1.5)
    return np.asarray(force.reshape(-1, 2).mean(axis=1))
