# SPDX-License-Identifier: Apache-2.0
"""How finely to cut string and time when the scene says `auto`."""

import numpy as np

from drill_twin.rod.mesh import Tube, tube_constants

ELEMENTS_PER_PITCH = 8
FEWEST, MOST = 16, 400


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
        pitch = 2.0 * np.pi * np.sqrt(2.0 * bending / max(compression, 1e-9))
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
    growth = min(
        2.0 * np.sqrt(constants[1] * constants[3]) / max(compression, 1e-9)
        for constants in (tube_constants(tube) for tube in tubes)
    )
    turn = 2.0 * np.pi / max(abs(speed), 1e-9)
    return float(min(0.1 * growth, 0.01 * turn, frame))
