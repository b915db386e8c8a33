# SPDX-License-Identifier: Apache-2.0
"""Discrete model of a scene: string pieces as tubes, and the hole at points of the string."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.dynamics.solver.boundary.bit_frame import bit_frame
from drill_twin.physics.model.discrete_model import DiscreteModel, places
from drill_twin.physics.model.mesh import Rod, Tube
from drill_twin.physics.model.survey import Survey, survey
from drill_twin.physics.model.wellbore import Axis, Wellbore
from drill_twin.scene import Scene
from drill_twin.scene.blocks.section import Piece


def tubes_of(scene: Scene) -> list[Tube]:
    """Uniform pieces of the string from the bit up; tool joints are pieces of their own."""
    return [_tube(piece) for piece in scene.string.pieces]


def sections_of(scene: Scene) -> list[Tube]:
    """Sections of the string without their tool joints, for the choice of the resolution."""
    return [_tube(Piece(s.length, s.outer_diameter, s.contact_diameter, s)) for s in scene.string.sections]


def _tube(piece: Piece) -> Tube:
    of = piece.section
    density = of.density if of.adjusted_mass is None else of.adjusted_mass / of.area
    return Tube(piece.length, piece.outer_diameter, of.inner_diameter, of.youngs_modulus, of.poisson_ratio, density)


def discretise(scene: Scene, rod: Rod) -> DiscreteModel:
    """Make the discrete model of a meshed string in its hole."""
    at = places(rod)
    mud = getattr(scene.effects, "mud", None)
    numbers = _section_numbers(scene, rod)
    sections = scene.string.sections
    joints = np.array([0.0 if s.adjusted_mass is None else s.adjusted_mass / s.density - s.area for s in sections])
    fluid = (mud.density, mud.viscosity, mud.inside == "mud", joints[numbers]) if mud is not None else ()
    return DiscreteModel(
        rod,
        scene.hole.radius,
        scene.hole.top_inclination,
        bore_at(scene, at),
        contact_radius(scene, at),
        numbers,
        scene.numerics.seed,
        bit_frame(axis_at(scene, np.array([scene.length]))),
        tuple(section.yield_strength for section in sections),
        getattr(scene.effects, "bow", None),
        *fluid,
    )


def _section_numbers(scene: Scene, rod: Rod) -> NDArray[np.int64]:
    tops = np.cumsum([section.length for section in scene.string.sections])
    middle = 0.5 * (rod.arc[1:] + rod.arc[:-1])
    return np.minimum(np.searchsorted(tops, middle), tops.size - 1).astype(np.int64)


def bore_at(scene: Scene, distance_from_bit: Array) -> Wellbore:
    """Hole at points of the string [m], shape (p,), in its initial position."""
    depth = scene.length - np.asarray(distance_from_bit)
    radius = np.array([scene.hole.radius_at(float(d)) for d in depth])
    return Wellbore(radius - contact_radius(scene, distance_from_bit), axis_at(scene, depth))


def contact_radius(scene: Scene, distance_from_bit: Array) -> Array:
    """Radius in contact with the wall, blades and tool joints included [m], shape (p,)."""
    pieces = scene.string.pieces
    tops = np.cumsum([piece.length for piece in pieces])
    number = np.minimum(np.searchsorted(tops, distance_from_bit, side="right"), len(pieces) - 1)
    return np.array([0.5 * piece.contact_diameter for piece in pieces])[number]


def survey_of(scene: Scene) -> Survey | None:
    """Surveyed centre line; None for a straight hole."""
    if not scene.hole.survey:
        return None
    line = survey(*scene.hole.stations)
    return None if line.straight else line


def axis_at(scene: Scene, depth: Array) -> Axis | None:
    """Centre line of the hole at measured depths [m], shape (p,); None for a straight hole."""
    line = survey_of(scene)
    return None if line is None else line.at(depth)
