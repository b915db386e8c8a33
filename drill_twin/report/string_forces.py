# SPDX-License-Identifier: Apache-2.0
"""Forces along the string, from the recorded poses of its nodes: a bag holds forces at the two ends and at the marks.

The forces are elastic: what internal damping and the damping of the wall add is not in a pose.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError
from drill_twin.dynamics.discretisation.discretise import (
    axial_weight,
    axial_weight_of_discs,
    discretise,
    untwisted,
)
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.dynamics.torque_drag.along_string import hole_and_string
from drill_twin.physics.effects.wall import parameters as wall_parameters
from drill_twin.physics.model.mesh import SPIN, Rod, youngs_modulus
from drill_twin.physics.model.section_stress import curvature
from drill_twin.physics.model.wellbore import offsets
from drill_twin.report.recording import Recording

_ITERATIONS = 20
"""Repetitions of `_slopes`, each of which halves its error at least."""
_TURN = 4.0 * np.pi
"""Angle after which the orientation of a section repeats as a quaternion [rad]."""


class StringForces(NamedTuple):
    """Forces in the n elements at T poses; NaN where the scene does not have them."""

    depth: Array
    """Measured depth of the nodes, from the bit up [m], shape (n + 1,)."""
    tension: Array
    """Axial force [N], positive = tension, shape (T, n)."""
    torque: Array
    """Torque [N m], right-handed positive, shape (T, n); NaN in a scene without `torsion`."""
    side: Array
    """Normal force of the wall per length [N/m], shape (T, n); of the soft string where it follows the hole."""


def string_forces(recording: Recording, poses: slice | NDArray[np.int64] = slice(None)) -> StringForces | None:
    """Forces at the kept poses of a recording; None where they are none of a mesh of its scene."""
    scene, rod = recording.scene, _mesh(recording)
    if rod is None:
        return None
    model = discretise(scene, rod)
    position, spin = recording.poses.position[poses], recording.poses.spin[poses]
    strain, slopes = _strain(rod, position, recording.poses.tangent[poses])
    if scene.effects.torsion is None:
        own = axial_weight(scene, model, is_lumped=False)
        below = np.cumsum(own) - 0.5 * own + np.cumsum(axial_weight_of_discs(model)[:-1])
        rig, time = recording.rig, recording.poses.time[poses]
        load = np.interp(time, rig.time, rig.bit_force) if len(rig) else np.full(time.size, np.nan)
        tension = below - load[:, None]
        torque = np.full_like(tension, np.nan)
    else:
        tension, torque = rod.axial * strain, _torque(rod, position, slopes, spin)
    side = np.zeros_like(tension)
    if scene.effects.wall is not None:
        law = wall_parameters(scene.effects.wall, model)
        points = np.einsum("epi,teic->tepc", rod.shape[:, :, 0], _ends(position, slopes))
        places = points.reshape(len(points), -1, 3)  # the Gauss points of the elements, shape (T, 2 n, 3)
        off = places[..., :2] if law.bore.axis is None else offsets(law.bore.axis, places).off
        depth = np.maximum(np.linalg.norm(off, axis=-1) - law.bore.clearance, 0.0)
        side = (law.stiffness * depth ** (1.5 - 0.5 * law.linear)).reshape(*tension.shape, 2).mean(axis=-1)
    if joint := joint_of(scene):  # it has no lateral motion above: the force that presses the soft string
        above, soft = rod.arc[:-1] > joint - 1e-6, hole_and_string(scene, model)
        side[:, above] = np.stack([soft.pressing(row)[above] for row in tension])
    return StringForces(scene.length - rod.arc, tension, torque, side)


FIBRES = np.exp(-1j * np.pi * np.arange(12) / 12.0)
"""Directions of the fibres on half of the circumference, the other half of which has the same ranges: 15 degrees
apart, a range of stress in one plane is too small by 1 % at most."""


def fibre_stress(recording: Recording, poses: NDArray[np.int64]) -> tuple[float, float, Array] | None:
    """Fibre whose bending stress goes through the largest range over chosen poses, at an end of an element.

    Returns:
        Half of the range [Pa], distance from the bit [m], within the element, and stress at the poses [Pa], shape (k,),
        less what is constant in the turning material, as a bow; None where the poses are of no mesh.
    """
    if not len(poses) or (rod := _mesh(recording)) is None:
        return None
    u, n = _rows(recording, rod, poses), rod.length.size
    about, tangent = curvature(rod, u)[:, :, ::2], u[:, :, 3:6] / np.linalg.norm(u[:, :, 3:6], axis=-1, keepdims=True)
    ends = np.stack((np.arange(n), np.arange(n) + 1), axis=-1)  # nodes of the elements
    t, spin = tangent[:, ends], recording.poses.spin[poses][:, ends]
    along = about[..., 2] / (1.0 + t[..., 2])  # as in `section_stress.material_strain`
    bent = (about[..., 0] - t[..., 0] * along + 1j * (about[..., 1] - t[..., 1] * along)) * np.exp(-1j * spin)
    bent *= (youngs_modulus(rod) * rod.outer_radius)[:, None]
    half = np.stack([0.5 * np.ptp((bent * way).real, axis=0) for way in FIBRES], axis=-1)
    element, end, fibre = np.unravel_index(np.argmax(half), half.shape)
    stress = (bent[:, element, end] * FIBRES[fibre]).real
    place = rod.arc[element + end] + rod.length[element] * (0.5 - end) * INSIDE
    return float(half.max()), float(place), stress - stress.mean()


INSIDE = 1e-6
"""Share of an element by which a place at its end is moved into it, so that it is in no neighbouring section."""
JOINT = 9.144
"""Length of a joint of drill pipe [m], 30 ft, range 2 of API 5DP."""


def force_on_joint(recording: Recording, poses: NDArray[np.int64]) -> tuple[float, float]:
    """Largest mean force of the wall on the length of a joint at chosen poses [N], and where it is [m from the bit].

    The place is the centre of the force on the section that carries most of it. A shorter string counts as one joint.
    NaN where the poses are of no mesh.
    """
    if (found := string_forces(recording, poses)) is None:
        return math.nan, math.nan
    arc = found.depth[0] - found.depth
    side = found.side.mean(axis=0)
    total = np.append(0.0, np.cumsum(side * np.diff(arc)))
    lower = np.concatenate((arc, np.maximum(arc - JOINT, 0.0)))  # ends of joints at all nodes
    force = np.interp(lower + JOINT, arc, total) - np.interp(lower, arc, total)
    at = int(np.argmax(force))
    ends = np.clip(arc, lower[at], lower[at] + JOINT)
    middle, own = 0.5 * (ends[1:] + ends[:-1]), side * np.diff(ends) + 1e-9 * np.diff(ends)
    tops = np.cumsum([section.length for section in recording.scene.string.sections])
    section = np.searchsorted(tops[:-1], 0.5 * (arc[1:] + arc[:-1]))
    most = section == np.bincount(section, own).argmax()
    return float(force[at]), float(np.average(middle[most], weights=own[most]))


LEFT = 0.05
"""Torque to the left over the least make-up torque of the string from which a note tells it; a string of 3,000 m whose
top drive stops from 120 rpm keeps 0.01. Chosen, not measured."""


def left_torque(recording: Recording) -> Iterator[str]:
    """Sentence on joints on which torque to the left acted at two kept poses in a row or more."""
    made_up = [one.make_up_torque for one in recording.scene.string.sections if one.make_up_torque]
    if not made_up or (found := string_forces(recording)) is None:
        return
    left = np.where(np.isnan(found.torque), 0.0, -found.torque)
    lasting = np.minimum(left[1:], left[:-1])
    if lasting.size and lasting.max() > LEFT * min(made_up):
        at = int(lasting.max(axis=0).argmax())
        part = recording.scene.string.section_at(found.depth[0] - 0.5 * (found.depth[at] + found.depth[at + 1])).name
        during = np.diff(recording.poses.time)[lasting.max(axis=1) > LEFT * min(made_up)].sum()
        yield (
            f"torque turned joints to the left for {during:.2g} s, by up to "
            f"{recording.units.text(float(left[:, at].max()), 'torque')} at {part}: {recording.scene.string.backs_off}"
        )


def _rows(recording: Recording, rod: Rod, poses: NDArray[np.int64]) -> Array:
    """Node rows (r, r', 0) at chosen poses, shape (k, n + 1, 7)."""
    position = recording.poses.position[poses]
    slopes = _strain(rod, position, recording.poses.tangent[poses])[1]
    return np.concatenate([position, slopes, np.zeros((*position.shape[:2], 1))], axis=2)


def _mesh(recording: Recording) -> Rod | None:
    """Mesh with the nodes of the poses; None where the scene has none, or needs a record that is not at hand."""
    if recording.nodes < 2:
        return None
    try:
        rod = mesh(recording.scene, recording.nodes - 1)
    except TableError:
        return None
    return rod if rod.arc.size == recording.nodes else None


def _strain(rod: Rod, position: Array, tangent: Array) -> tuple[Array, Array]:
    """Axial strain at the elements' inner samples, which carries the force from node to node, and r' at the nodes.

    A pose has the direction of r' only. The length of r' at a node follows from balance: the strain there is the mean
    of the neighbouring elements' strains, weighted by EA and the weight of the end (the stationary point of
    `model.stretch`).
    """
    near = np.append(0.0, rod.axial * rod.samples[:, 1])
    far = np.append(rod.axial * rod.samples[:, 0], 0.0)
    length = np.ones(tangent.shape[:-1])
    for _ in range(_ITERATIONS):
        inner = np.linalg.norm(
            np.einsum("ei,teic->tec", rod.inner, _ends(position, length[..., None] * tangent)), axis=-1
        )
        below = np.concatenate((inner[:, :1], inner), axis=1)
        above = np.concatenate((inner, inner[:, -1:]), axis=1)
        length = (near * below + far * above) / (near + far)
    return inner - 1.0, length[..., None] * tangent


def _ends(position: Array, slopes: Array) -> Array:
    """Vectors r and r' at both ends of the elements, shape (T, n, 4, 3)."""
    return np.stack((position[:, :-1], slopes[:, :-1], position[:, 1:], slopes[:, 1:]), axis=2)


def _torque(rod: Rod, position: Array, slopes: Array, spin: Array) -> Array:
    """GJ times the mean twist of the elements."""
    u = np.zeros((*spin.shape, SPIN + 1))
    u[..., 0:3], u[..., 3:6] = position, slopes
    climb = np.diff(spin - np.stack([untwisted(rod, row) for row in u]), axis=1)
    climb -= _TURN * np.round(climb / _TURN)
    return np.asarray(rod.torsion / rod.length * climb)
