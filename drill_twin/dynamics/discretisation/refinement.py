# SPDX-License-Identifier: Apache-2.0
"""Mesh: by length; in long strings graded, fine in the assembly and coarse where pipe hangs straight."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import discretise, tubes_of
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.physics.model.mesh import Rod, build_rod, elements_per_section, rod_of
from drill_twin.scene import Scene
from drill_twin.scene.set_points import extremes

LONG = 1000.0
"""Length from which a mesh is graded [m]."""
PER_PITCH, PER_WAVE = 8, 6
"""Elements a pitch of the buckling helix, and a bending wave at the frequency of rotation (error 0.08 %)."""
LONGEST = 15.0
"""Longest element that the rule asks for [m]: half a stand."""
SAMPLES = 400
"""Elements of the mesh by length on which the rule is evaluated."""


def mesh(scene: Scene, elements: int) -> Rod:
    """Mesh of the string with a number of elements; changes of section fall on nodes.

    Raises:
        TableError: A long string whose record of set-points cannot be used.
    """
    tubes = tubes_of(scene)
    if scene.length < LONG:
        return build_rod(tubes, elements)
    return rod_of(tubes, elements_per_section(elements_needed(scene), elements))


def elements_needed(scene: Scene) -> Array:
    """Elements that each uniform piece of the string needs, for its tension T when rotating on bottom; shape (pieces,).

    Under compression F a pitch 2 pi sqrt(2 EI / F) has eight (Lubinski, Althouse and Logan 1962). Everywhere a bending
    wave at the frequency of rotation Omega has six: EI k^4 + T k^2 = m Omega^2.

    Raises:
        TableError: A record of set-points that cannot be used.
    """
    tubes, most = tubes_of(scene), extremes(scene)
    rod = build_rod(tubes, SAMPLES)
    weight = axial_weight(scene, discretise(scene, rod))
    tension = np.cumsum(weight) - 0.5 * weight - max(most.weight_on_bit, 0.0)
    inertia = 4.0 * rod.bending * rod.line_mass * most.rotation**2
    square = (np.hypot(tension, np.sqrt(inertia)) - tension) / (2.0 * rod.bending)
    density = PER_WAVE * np.sqrt(np.maximum(square, 0.0)) / (2.0 * np.pi)
    pitch = 2.0 * np.pi * np.sqrt(2.0 * rod.bending / np.maximum(-tension, 1e-9))
    density = np.maximum(np.maximum(density, PER_PITCH / pitch), 1.0 / LONGEST)
    middle = 0.5 * (rod.arc[1:] + rod.arc[:-1])
    piece = np.searchsorted(np.cumsum([tube.length for tube in tubes])[:-1], middle)
    return np.asarray(np.bincount(piece, weights=density * rod.length, minlength=len(tubes)), float)
