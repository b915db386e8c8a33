# SPDX-License-Identifier: Apache-2.0
"""Elements of a string in its hole; forces, moments and stresses along it in a balance, at the middle of each."""

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.audit.energy import off_axis
from drill_twin.dynamics.discretisation.discretise import axis_at, contact_radius
from drill_twin.dynamics.torque_drag.soft_string import HoleAndString, Operation, soft_string
from drill_twin.physics.effects.gravity import line_weight
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model import element_unknowns
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

BEND_PLACES = 32
"""Places in an element at which direction, bend and friction of the hole are taken, which may change between nodes."""


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
    depth = np.maximum(np.linalg.norm(off_axis(model, u), axis=1) - model.wellbore.clearance, 0.0)
    force = wall.stiffness * depth ** (1.0 if wall.linear else 1.5)
    return np.asarray(force.reshape(-1, 2).mean(axis=1))


def hole_and_string(scene: Scene, model: DiscreteModel, bit_depth: float | None = None) -> HoleAndString:
    """The elements of a string in its hole, for the soft string; of its lower part, with the bit at a depth [m]."""
    rod = model.rod
    bit_depth = scene.length if bit_depth is None else bit_depth
    ends = np.minimum(rod.arc, bit_depth)
    middle, length = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)
    depth, inside = bit_depth - middle, length > 0.0
    axis = axis_at(scene, depth)
    down = np.array([math.sin(model.inclination), 0.0, -math.cos(model.inclination)])
    gravity, friction = scene.effects.gravity, getattr(scene.effects, "wall_friction", None)
    weight = (np.zeros(middle.size) if gravity is None else line_weight(gravity, model))[:, None] * down
    tangent = np.tile([0.0, 0.0, 1.0], (middle.size, 1)) if axis is None else axis.tangent
    along = -np.sum(weight * tangent, axis=1)
    within = depth[:, None] + length[:, None] * ((np.arange(BEND_PLACES) + 0.5) / BEND_PLACES - 0.5)
    inner = axis_at(scene, within.ravel())
    tangents = np.tile([0.0, 0.0, 1.0], (within.size, 1)) if inner is None else inner.tangent
    bends = np.zeros((within.size, 3)) if inner is None else inner.curvature[:, None] * inner.normal
    own, tangents, bend = weight[:, None], *(part.reshape(-1, BEND_PLACES, 3) for part in (tangents, bends))
    across = own - np.sum(own * tangents, axis=2, keepdims=True) * tangents
    contact = contact_radius(scene, 0.5 * (rod.arc[1:] + rod.arc[:-1]))
    hole = contact + model.wellbore.clearance.reshape(-1, 2).mean(axis=1)  # radius, from the bottom up
    own_depth = scene.length - 0.5 * (rod.arc[1:] + rod.arc[:-1])
    parts = HoleAndString(
        length, along, across, bend, rod.bending,
        contact, np.interp(depth, own_depth[::-1], hole[::-1]) - contact,
        np.zeros(middle.size) if friction is None else friction.coefficient * friction.scale_at(within).mean(axis=1),
    )  # fmt: skip
    return HoleAndString(*(part[inside] for part in parts))


STOPS = 100
"""Depths of the bit that are tried; chosen."""


def stop_text(scene: Scene, model: DiscreteModel, operation: Operation) -> str:
    """Words on the first of `STOPS` depths of the bit at which the soft string does not slide in by its own weight.

    Empty where it slides at all of them.
    """
    for depth in np.linspace(0.0, scene.length, STOPS + 1)[1:].tolist():
        soft = soft_string(hole_and_string(scene, model, depth), operation._replace(weight_on_bit=0.0))
        if not soft.hookload > 0.0:
            return (
                ": by the soft string friction holds its pipe, which does not slide in by its own weight with the bit "
                f"from {scene.unit_system.text(depth, 'length')} on"
            )
    return ""
