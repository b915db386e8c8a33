# SPDX-License-Identifier: Apache-2.0
"""Number of elements, time step and Newton tolerance of a scene, chosen where it says `auto`; the mesh.

A mesh is by length; in long strings graded, fine in the assembly and coarse where pipe hangs straight.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.discretisation.discretise import axial_weight, cut, discretise, sections_of, tubes_of
from drill_twin.dynamics.discretisation.joint import SAMPLES, counts_above, joint_of
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model import Rod, Tube, build_rod, elements_per_section, rod_of, tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.set_points import extremes

LONG = 1000.0
"""Length from which a mesh is graded [m]."""
PER_PITCH, PER_WAVE = 8, 6
"""Elements a pitch of the buckling helix, and a bending wave at the frequency of rotation (error 0.08 %)."""
LONGEST_ELEMENT = 15.0
"""Longest element that the rule asks for [m]: half a stand."""
IN_TORSION, MOST_FINER = 500, 10.0
"""Steps in a period of torsion where the bit may stick and slip; most of them in place of one for all else."""


def mesh(scene: Scene, elements: int) -> Rod:
    """Mesh of the string with a number of elements; changes of section fall on nodes.

    Raises:
        TableError: A long string whose record of set-points cannot be used.
    """
    joint, below, above = _parts(scene)
    wanted, counts = np.array([tube.length for tube in below]), counts_above(above)
    if scene.length >= LONG:
        wanted = elements_needed(scene, joint)[: len(below)]
        counts = counts_above(above, elements / (max(math.ceil(wanted.sum()), FEWEST) + sum(counts)))
    return rod_of([*below, *above], elements_per_section(wanted, elements - sum(counts)) + counts)


def _parts(scene: Scene) -> tuple[float, list[Tube], list[Tube]]:
    """Distance of the joint from the bit [m], infinite without one, and the uniform pieces below it and above it."""
    joint = joint_of(scene)
    joint = math.inf if joint is None else joint
    return joint, *cut(tubes_of(scene), joint)


def elements_needed(scene: Scene, up_to: float = math.inf) -> Array:
    """Elements that each uniform piece of the string needs up to a distance from the bit [m]; shape (pieces,).

    By its tension T when rotating on bottom. Under compression F a pitch 2 pi sqrt(2 EI / F) has eight (Lubinski,
    Althouse and Logan 1962). Everywhere a bending wave at the frequency of rotation Omega has six:
    EI k^4 + T k^2 = m Omega^2.

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
    density = np.maximum(np.maximum(density, PER_PITCH / pitch), 1.0 / LONGEST_ELEMENT)
    middle = 0.5 * (rod.arc[1:] + rod.arc[:-1])
    density[middle > up_to] = 0.0
    piece = np.searchsorted(np.cumsum([tube.length for tube in tubes])[:-1], middle)
    return np.asarray(np.bincount(piece, weights=density * rod.length, minlength=len(tubes)), float)


FEWEST, MOST, MOST_LONG = 16, 400, 1000
IMPACT, OF_DEPTH = 0.1, 2e-3
"""Speed of a slow impact [m/s], and the Newton tolerance as a share of its depth in the wall."""


def resolution_of(scene: Scene) -> tuple[int, float]:
    """Number of elements and time step [s] of a scene, as given or chosen for `auto`.

    Raises:
        SceneError: The scene asks for an accuracy instead.
        TableError: One is to be chosen for a record that cannot be used.
    """
    numerics = scene.numerics
    if numerics.accuracy is not None:
        raise SceneError(
            f"{scene.name}: expected numerics.elements and numerics.step, found numerics.accuracy, which only "
            "drill-twin run and the simulator node turn into them (drill_twin.studies.accuracy.resolve)"
        )
    if "auto" not in (numerics.elements, numerics.step):
        return int(numerics.elements), float(numerics.step)
    elements = (
        int(numerics.elements) if numerics.elements != "auto" else min(wanted_elements(scene), most_elements(scene))
    )
    if numerics.step != "auto":
        return elements, float(numerics.step)
    step, wanted = step_of_motion(scene), stick_slip_step(scene)
    return elements, wanted if step > wanted >= step / MOST_FINER else step


def most_elements(scene: Scene) -> int:
    """Most elements that `auto` takes; `notes.notes_on` says so."""
    return MOST_LONG if scene.length >= LONG else MOST


def wanted_elements(scene: Scene) -> int:
    """Elements for eight per pitch of the buckling helix of each section, without an upper limit.

    The pitch 2 pi sqrt(2 EI / F) (Lubinski, Althouse and Logan 1962) is the shortest wave caused by the load. In a long
    string the local load counts, and the mesh is graded (`elements_needed`).
    """
    if scene.length >= LONG:
        joint, _, above = _parts(scene)
        return max(math.ceil(float(elements_needed(scene, joint).sum())), FEWEST) + sum(counts_above(above))
    count, compression = 0.0, max(extremes(scene).weight_on_bit, 1.0)
    for tube in sections_of(scene):
        bending = tube_constants(tube)[1]
        pitch = math.tau * np.sqrt(2.0 * bending / compression)
        count += tube.length / min(pitch, tube.length * 4.0) * PER_PITCH
    return int(max(np.ceil(count), FEWEST))


def step_of_motion(scene: Scene) -> float:
    """Time step that resolves the growth of buckling and the rotation [s].

    A tenth of the time 2 sqrt(EI m) / F in which the fastest buckling wave grows e-fold without damping, a hundredth
    of a revolution, and the frame interval; the smallest of them. The scheme is stable far beyond.
    """
    most = extremes(scene)
    turn = math.tau / max(abs(most.rotation), 1e-9)
    growth = growth_time(sections_of(scene), max(most.weight_on_bit, 1.0))
    return float(min(0.1 * growth, 0.01 * turn, scene.numerics.frame_period))


def stick_slip_step(scene: Scene) -> float:
    """Time step that resolves stick-slip, a `IN_TORSION`th of the period of torsion [s]; infinite without such a law.

    The bit's inertia J on the string's stiffness k with the top held has the period 2 pi sqrt(J / k), in which the
    string moves as if twisted by a couple at the bit (Rayleigh). The midpoint rule makes the period of a wave of
    frequency w too long by (w h)^2 / 12: of the 27th harmonic, a wave in a 27th of the string, by 1 %.
    """
    if not any("torsion" in scene.effects.blocks[law].requires for law in scene.effects.providing("torque")):
        return math.inf
    tubes, body = sections_of(scene)[::-1], getattr(scene.effects, "bit_mass", None)
    length = np.array([tube.length for tube in tubes])
    _, _, torsion, _, polar = np.array([tube_constants(tube) for tube in tubes]).T
    twist = np.cumsum(length / torsion)  # at the lower end of each section, by a couple of 1 N m
    above = twist - length / torsion
    moved = polar @ (length * (above**2 + above * twist + twist**2)) / 3.0
    moved += 0.0 if body is None else body.inertia * twist[-1] ** 2
    return float(math.tau * np.sqrt(moved / twist[-1]) / IN_TORSION)


def growth_time(tubes: list[Tube], compression: float) -> float:
    """Time 2 sqrt(EI m) / F in which the fastest buckling wave grows e-fold without damping [s], under a load [N]."""
    least = min(constants[1] * constants[3] for constants in map(tube_constants, tubes))
    return float(2.0 * np.sqrt(least) / max(compression, 1e-9))


def newton_place(tolerance: float, rod: Rod, wall: Wall | None, blades: float = 0.0) -> float:
    """Newton tolerance for positions [m].

    A share of the string's radius, and with a stiff wall or stabiliser at most a share of the depth of a slow impact: a
    larger error there changes the energy.

    Args:
        tolerance: Share of the radius, `numerics.tolerance`.
        rod: Meshed string.
        wall: Law of the wall; None if the scene lists none.
        blades: Stiffness of the stabiliser at the bit [N/m]; 0 without one.
    """
    place = tolerance * float(rod.outer_radius.min())
    if blades > 0.0:  # K d^2 = m v^2 for the mass at the bit's node
        mass = 0.5 * float(rod.line_mass[0] * rod.length[0])
        place = min(place, OF_DEPTH * IMPACT * math.sqrt(mass / blades))
    if wall is None:
        return place
    return min(place, OF_DEPTH * impact_depth(wall, float(rod.line_mass.min()), IMPACT))


def impact_depth(wall: Wall, line_mass: float, speed: float) -> float:
    """Depth of an impact of a free slice of the string in the wall, K d^(p+1) / (p+1) = m v^2 / 2 [m].

    Args:
        wall: Law of the wall.
        line_mass: Mass per length m [kg/m].
        speed: Towards the wall, v [m/s].
    """
    power = 1.0 if wall.linear else 1.5
    return float((0.5 * (power + 1.0) * line_mass * speed**2 / wall.stiffness) ** (1.0 / (power + 1.0)))
