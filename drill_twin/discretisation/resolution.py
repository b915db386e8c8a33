# SPDX-License-Identifier: Apache-2.0
"""How finely to cut string and time when the scene says `auto`."""

import math

import numpy as np

from drill_twin.effects.wall import Parameters as Wall
from drill_twin.model.mesh import Rod, Tube, tube_constants

ELEMENTS_PER_PITCH = 8
FEWEST, MOST = 16, 400
IMPACT, OF_DEPTH = 0.1, 2e-3
"""Speed of a gentle impact [m/s], and the share of its depth in the wall that Newton's method may leave undone."""


def auto_elements(tubes: list[Tube], compression: float) -> int:
    """Eight elements to the pitch of the helix that the load would buckle each section into.

    The pitch 2 pi sqrt(2 EI / F) (Lubinski, Althouse and Logan 1962) is the shortest wave the load itself makes.

    Args:
        tubes: Sections.
        compression: Largest axial compression expected [N].
    """
    count = 0.0
    for tube in tubes:
        bending = tube_constants(tube)[1]
        pitch = math.tau * np.sqrt(2.0 * bending / max(compression, 1e-9))
        count += tube.length / min(pitch, tube.length * 4.0) * ELEMENTS_PER_PITCH
    return int(np.clip(np.ceil(count), FEWEST, MOST))


def auto_step(tubes: list[Tube], compression: float, speed: float, frame: float) -> float:
    """Step that resolves what moves the string: its growth when buckled and its rotation.

    A tenth of the time 2 sqrt(EI m) / F in which the fastest buckling wave grows e-fold without damping, a hundredth
    of a turn, and the time between two published frames; the smallest of them. The scheme is stable far beyond.

    Args:
        tubes: Sections.
        compression: Largest axial compression expected [N].
        speed: Fastest rotation expected [rad/s].
        frame: Time between two published frames [s].
    """
    turn = math.tau / max(abs(speed), 1e-9)
    return float(min(0.1 * growth_time(tubes, compression), 0.01 * turn, frame))


def growth_time(tubes: list[Tube], compression: float) -> float:
    """Time 2 sqrt(EI m) / F in which the fastest buckling wave grows e-fold without damping [s], under a load [N]."""
    least = min(constants[1] * constants[3] for constants in map(tube_constants, tubes))
    return float(2.0 * np.sqrt(least) / max(compression, 1e-9))


def newton_place(tolerance: float, rod: Rod, wall: Wall | None) -> float:
    """Last change of a place with which Newton's method is content [m].

    A share of the string's radius; on a hard wall no more than a share of the depth at which a slice that meets it
    gently comes to rest: what is lost there is energy.

    Args:
        tolerance: The share of the radius, `numerics.tolerance`.
        rod: The string.
        wall: Its wall; None where the scene lists none.
    """
    place = tolerance * float(rod.outer_radius.min())
    if wall is None:
        return place
    return min(place, OF_DEPTH * impact_depth(wall, float(rod.line_mass.min()), IMPACT))


def impact_depth(wall: Wall, line_mass: float, speed: float) -> float:
    """Depth at which a slice that meets the wall comes to rest, K d^(p+1) / (p+1) = m v^2 / 2 [m].

    Args:
        wall: Law of the wall.
        line_mass: Mass per length m [kg/m].
        speed: Towards the wall, v [m/s].
    """
    power = 1.0 if wall.linear else 1.5
    return float((0.5 * (power + 1.0) * line_mass * speed**2 / wall.stiffness) ** (1.0 / (power + 1.0)))
