# SPDX-License-Identifier: Apache-2.0
"""Regularised signs and limits of dry friction, and its dual variable.

With the dual variable Newton's method converges where the slip changes its sign.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel


def no_iterate() -> Array:
    """Memory of `dual_variable` before the first iterate, and middle and half length of its step [s]; shape (8,)."""
    return np.array([0.0, 0.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0])


@kernel
def dual_variable(
    memory: Array, first_iteration: bool, count: float, across: float, along: float, size: float, bend: float
) -> Pair:
    """Dual variable of the primal-dual Newton method: direction and share of the friction limit, norm at most 1.

    Newton's method oscillates at the kink of s / |s|. With ``dual |s| = s``, linearised in both unknowns, it converges
    (Chan, Golub and Mulet 1999); the dual follows from the last iteration's slip alone. `bend` is the size
    times its slope over the slip, 1 for the square root.
    """
    dx, dy = 0.0, 0.0
    if not first_iteration and memory[5] == count - 1.0:
        change = bend * (memory[0] * (across - memory[0]) + memory[1] * (along - memory[1])) / memory[2]
        dx = (across - memory[3] * change) / memory[2]
        dy = (along - memory[4] * change) / memory[2]
        long = np.sqrt(dx * dx + dy * dy)
        if long > 1.0:
            dx, dy = dx / long, dy / long
    memory[0], memory[1], memory[2], memory[3], memory[4], memory[5] = across, along, size, dx, dy, count
    return dx, dy


@kernel
def arctan_size(law: Any, slip: float) -> Pair:
    """Size by which the slip s is divided for the paper's sign [m/s], and that size times its slope over s [-]."""
    steep = 0.5 * np.pi * slip / law.creep
    if steep < 1e-4:
        return law.creep, np.pi * np.pi / 6.0
    sign = 2.0 / np.pi * np.arctan(steep)
    return slip / sign, (1.0 - slip / (law.creep * (1.0 + steep * steep) * sign)) / (sign * sign)


@kernel
def step_size(law: Any, slip: float) -> Pair:
    """As `arctan_size` for the STEP from -mu to mu, (3 x - x^3) / 2 at x = v / v_s up to 1."""
    square = (slip / law.low) ** 2
    if square >= 1.0:
        return slip, 1.0
    left = 3.0 - square
    return 2.0 * law.low / left, 8.0 / (left * left * left)


@kernel
def step_limit(law: Any, slip: float) -> Pair:
    """Friction coefficient from v_s on, mu falling to mu_d by a STEP, and its fall over slip speed [s/m]."""
    t = min(max((slip - law.low) / (law.high - law.low), 0.0), 1.0)
    drop = law.coefficient - law.sliding
    return law.coefficient - drop * t * t * (3.0 - 2.0 * t), drop * 6.0 * t * (1.0 - t) / (law.high - law.low)
