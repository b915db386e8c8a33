# SPDX-License-Identifier: Apache-2.0
"""Dual variable of dry friction, with which Newton's method converges where the slip changes its sign."""

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
