# SPDX-License-Identifier: Apache-2.0
"""Discrete model of a scene: string as tubes, the hole at points of the string, boundary conditions, initial state.

The string starts on the axis of the hole, at rest, untwisted and in axial equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Mask
from drill_twin.dynamics.solver.boundary import bit_frame
from drill_twin.dynamics.solver.state import State
from drill_twin.physics.effects.discs import Bodies
from drill_twin.physics.effects.gravity import line_weight
from drill_twin.physics.model import SPIN, Axis, DiscreteModel, Rod, Tube, Wellbore, element_unknowns, places
from drill_twin.physics.model.survey import Survey, survey
from drill_twin.scene import Scene
from drill_twin.scene.blocks.hole import Hole
from drill_twin.scene.blocks.string import Piece
from drill_twin.scene.set_points import extremes

P = ParamSpec("P")
T = TypeVar("T")


def kept(function: Callable[P, T]) -> Callable[P, T]:
    """Keep the results of a pure function, which the set-up of a twin calls many times.

    Arguments that have no hash, such as a scene with a list in an effect of another package, are computed each time.
    """
    known = lru_cache(maxsize=8)(function)

    @wraps(function)
    def call(*arguments: P.args, **named: P.kwargs) -> T:
        try:
            hash(arguments)
        except TypeError:
            return function(*arguments, **named)
        return known(*arguments, **named)  # type: ignore[arg-type]

    return call


NO_LENGTH, NO_DIAMETER = 3e-4, 0.1
"""Length, over the string's and over the least diameter, below which a cut of the mesh is none: a disc so near to a
joint of two sections, or to another part, is put there. Of a rotor, `modes` is off by more than its band from 2e-4 of
the length down, and at 2e-5 it loses the lowest mode (measured on test_exact_rotors' stepped shaft)."""


def tubes_of(scene: Scene) -> list[Tube]:
    """Uniform pieces of the string from the bit up; tool joints are pieces of their own, discs and supports end one."""
    tubes = [_tube(piece) for piece in scene.string.pieces]
    least = min(NO_LENGTH * scene.length, NO_DIAMETER * min(tube.outer_diameter for tube in tubes))
    for place in scene.string.stations:
        below, above = cut(tubes, place)
        if min(sum(tube.length for tube in end) for end in (below, above)) > least:
            tubes = below + above if min(below[-1].length, above[0].length) > least else tubes
    return tubes


def cut(tubes: list[Tube], at: float) -> tuple[list[Tube], list[Tube]]:
    """Cut the pieces of a string at a distance from the bit [m]: pieces below the cut, and pieces above."""
    below, above, start = [], [], 0.0
    for tube in tubes:
        inside = min(max(at - start, 0.0), tube.length)
        start += tube.length
        below += [tube._replace(length=inside)] if inside > 0.0 else []
        above += [tube._replace(length=tube.length - inside)] if inside < tube.length else []
    return below, above


def sections_of(scene: Scene) -> list[Tube]:
    """Sections of the string without their tool joints, for the choice of the resolution."""
    return [_tube(Piece(s.length, s.outer_diameter, s.contact_diameter, s)) for s in scene.string.sections]


def _tube(piece: Piece) -> Tube:
    own = piece.section
    density = own.density if own.adjusted_mass is None else own.adjusted_mass / own.area
    return Tube(piece.length, piece.outer_diameter, own.inner_diameter, own.youngs_modulus, own.poisson_ratio, density)


def discretise(scene: Scene, rod: Rod) -> DiscreteModel:
    """Make the discrete model of a meshed string in its hole."""
    at = places(rod)
    mud = getattr(scene.effects, "mud", None)
    numbers = sections_at(scene, 0.5 * (rod.arc[1:] + rod.arc[:-1]))
    sections = scene.string.sections
    joints = np.array([0.0 if s.adjusted_mass is None else s.adjusted_mass / s.density - s.area for s in sections])
    model = DiscreteModel(
        rod, scene.hole.radius, scene.hole.top_inclination, bore_at(scene, at), contact_radius(scene, at), numbers,
        scene.numerics.seed, bit_frame(axis_at(scene, np.array([scene.length]))),
        tuple(section.yield_strength for section in sections), getattr(scene.effects, "bow", None),
    )  # fmt: skip
    if mud is not None:
        model = model._replace(
            fluid_density=mud.density, fluid_inside=mud.inside == "mud", joint_area=joints[numbers], fluid=mud,
            fastest_rotation=extremes(scene).rotation,
        )  # fmt: skip
    if not scene.string.discs and not scene.string.supports:
        return model
    model = model._replace(nodes=axis_at(scene, scene.length - rod.arc))
    return model._replace(bodies=_bodies(scene, model)) if scene.string.discs else model


def _bodies(scene: Scene, model: DiscreteModel) -> Bodies:
    discs, gravity = scene.string.discs, scene.effects.gravity
    node = model.nodes_at(np.array([disc.distance_from_bit for disc in discs]))
    mass, polar, diametral, volume = np.array([scene.string.body_of(disc) for disc in discs], float).T.copy()
    weight = (0.0 if gravity is None else gravity.magnitude) * (mass - model.fluid_density * volume)
    return Bodies(node, mass, polar, diametral, weight)


def sections_at(scene: Scene, distance_from_bit: Array) -> NDArray[np.int64]:
    """Index of the section at points of the string [m], shape (p,)."""
    tops = np.cumsum([section.length for section in scene.string.sections])
    return np.minimum(np.searchsorted(tops, distance_from_bit), tops.size - 1).astype(np.int64)


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


@kept
def survey_of(hole: Hole) -> Survey | None:
    """Surveyed centre line; None for a straight hole."""
    if not hole.survey:
        return None
    line = survey(*hole.stations)
    return None if line.straight else line


def axis_at(scene: Scene, depth: Array) -> Axis | None:
    """Centre line of the hole at measured depths [m], shape (p,); None for a straight hole."""
    line = survey_of(scene.hole)
    return None if line is None else line.at(depth)


# Constrained unknowns of an end, by its key in the scene: x, y, z, x', y', z', psi.
BIT_ENDS = {
    "guided": (True, True, False, True, True, False, False),
    "pinned": (True, True, False, False, False, False, False),
    "sliding": (False, False, False, True, True, False, False),
    "free": (False, False, False, False, False, False, False),
    "stabilised": (False, False, False, False, False, False, False),
}
CLAMPED_TOP = (True, True, True, True, True, False, True)


class BoundaryConditions(NamedTuple):
    """Boundary conditions of bit and top that depend on rig and effects."""

    weight_at_top: bool
    """True if the weight on bit is set at the top, which is then free axially."""
    bit_on_rock: bool
    """True if an effect supports the bit of such a string; otherwise it is constrained axially."""
    torque_driven: bool
    """True if a torque drives the top; otherwise its rotation is prescribed."""
    hoisted: bool = False
    """True if the top hangs in the travelling block, free axially."""
    top_end: str = "clamped"
    """`string.top_end`."""

    @classmethod
    def of(cls, scene: Scene) -> BoundaryConditions:
        """Boundary conditions of a scene."""
        weight_at_top = scene.rig.weight_on_bit.at == "top"
        hoisted = scene.rig.weight_on_bit.at == "block"
        bit_on_rock = (weight_at_top or hoisted) and bool(scene.effects.providing("weight"))
        return cls(
            weight_at_top,
            bit_on_rock,
            scene.rig.top_drive.model != "prescribed",
            hoisted,
            scene.string.top_end,
        )

    def constrained(self, bit_end: str) -> Mask:
        """Mask of the constrained unknowns (r, r', psi) at bit and top, for `string.bit_end`; shape (2, 7)."""
        constrained = np.array([BIT_ENDS[bit_end], CLAMPED_TOP])
        if self.weight_at_top:
            constrained[0, 2], constrained[1, 2] = not self.bit_on_rock, False
        if self.hoisted:
            constrained[1, 2] = False
        if self.top_end != "clamped":
            constrained[1, 3:5] = False
        if self.top_end == "free":
            constrained[1, 0:2] = False
        constrained[1, 6] = not self.torque_driven
        return constrained


def axial_weight(scene: Scene, model: DiscreteModel, *, is_lumped: bool = True) -> Array:
    """Weight of each element along the hole [N], shape (n,); if lumped, a disc's is in the element below it."""
    rod, gravity = model.rod, scene.effects.gravity
    if gravity is None:
        return np.zeros(rod.length.size)
    axis = axis_at(scene, rod.arc[-1] - 0.5 * (rod.arc[1:] + rod.arc[:-1]))
    up = np.array([-np.sin(model.inclination), 0.0, np.cos(model.inclination)])
    share = up[2] if axis is None else axis.tangent @ up
    return np.asarray(line_weight(gravity, model, is_lumped=is_lumped) * rod.length * share)


def axial_weight_of_discs(model: DiscreteModel) -> Array:
    """Weight of the discs at each node along the hole [N], shape (n + 1,)."""
    discs = np.zeros(model.rod.arc.size)
    if model.bodies is not None:
        down = np.array([np.sin(model.inclination), 0.0, -np.cos(model.inclination)])
        np.add.at(discs, model.bodies.node, -model.bodies.weight * (model.directions @ down)[model.bodies.node])
    return discs


def set_initial_state(state: State, model: DiscreteModel, scene: Scene, weight_on_bit: float) -> None:
    """Set the string on the hole's axis, stretched by weight and load, so that no axial waves start at t = 0."""
    rod, weight = model.rod, axial_weight(scene, model, is_lumped=False)
    below = np.concatenate([[0.0], np.cumsum(weight)])
    discs = axial_weight_of_discs(model)
    above = below + np.cumsum(discs)
    hanging = above[-1] if scene.rig.weight_on_bit.at == "top" else 0.0
    tension, under = (each - hanging - weight_on_bit for each in (above, above - discs))
    strain, elongation = _balanced(rod, tension[:-1], under[1:], weight)
    stretch = np.cumsum(elongation)
    along = rod.arc - rod.arc[-1] + np.concatenate([[0.0], stretch]) - stretch[-1]
    slope = 1.0 + strain
    axis = axis_at(scene, -along)
    if axis is None:
        state.u[:, 2], state.u[:, 5] = along, slope
        return
    state.u[:, 0:3], state.u[:, 3:6] = axis.centre, slope[:, None] * axis.tangent
    state.u[:, SPIN] = untwisted(rod, state.u)


def _balanced(rod: Rod, lower: Array, upper: Array, weight: Array) -> tuple[Array, Array]:
    """Strain at the nodes and elongation of the elements [m] for which the samples of stretch are in balance.

    In the elements at a change of section, and at a disc with weight, both values differ from the continuous string's,
    whose strain jumps there.

    Args:
        rod: The string.
        lower: Tension at the lower end of each element [N], shape (n,).
        upper: At its upper end.
        weight: Axial weight of the elements [N], shape (n,).
    """
    middle = 0.5 * (upper + lower)
    below, above, twelfth = rod.samples[:-1, 1], rod.samples[1:, 0], weight * rod.length / 12.0
    shared = below * middle[:-1] + above * middle[1:] + twelfth[:-1] - twelfth[1:]
    shared /= below * rod.axial[:-1] + above * rod.axial[1:]
    strain = np.append(lower, upper[-1]) / np.append(rod.axial, rod.axial[-1])
    jumps = (np.diff(rod.axial) != 0.0) | (lower[1:] != upper[:-1])
    strain[1:-1] = np.where(jumps, shared, strain[1:-1])
    elongation = middle / rod.axial * rod.length
    elongation -= 0.5 * (upper - lower) / rod.axial * (rod.samples[:, 0] - rod.samples[:, 1])
    for end, tension, at in ((0, lower, slice(None, -1)), (1, upper, slice(1, None))):
        elongation += rod.samples[:, end] * (strain[at] - tension / rod.axial)
    return strain, elongation


def untwisted(rod: Rod, u: Array) -> Array:
    """Spin at the nodes with zero mean twist in each element, 0 at the top [rad], shape (n + 1,).

    Twist is psi' + A, with A the twist of the reference frame (`drill_twin.physics.model.strain`).
    """
    nodal = element_unknowns(u)
    a, b = (np.einsum("epi,eic->epc", rod.shape[:, :, order], nodal) for order in (1, 2))
    g = np.linalg.norm(a, axis=-1)
    reference = -(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) / (g * (g + a[..., 2]))
    climb = -reference.mean(axis=1) * rod.length
    return np.asarray(np.concatenate([[0.0], np.cumsum(climb)]) - climb.sum())
