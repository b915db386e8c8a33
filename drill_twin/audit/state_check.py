# SPDX-License-Identifier: Apache-2.0
"""Whether a state can be meant at all: one compiled pass over the nodes, cheap enough for every published frame."""

from functools import cache
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.model.mesh import Rod
from drill_twin.solver.kernel_cache import load_generated

# Places in the result: node that is not finite (-1: none), largest speed of the string's surface [m/s] and its node,
# largest strain in size [-] and its node, how far a tangent leans, 1 - t_z (0: along z, 2: folded back), and its node.
BROKEN, SPEED, SPEED_AT, STRAIN, STRAIN_AT, LEAN, LEAN_AT = range(7)
VITALS = 7
LARGEST = 1e300


@kernel
def read(radius: Array, u: Array, v: Array, out: Array) -> None:
    """Fill `out` from node rows u, v (r, r', psi)."""
    out[:] = 0.0
    out[BROKEN] = -1.0
    last = u.shape[0] - 1
    for i in range(last + 1):
        total = 0.0
        for c in range(7):
            total += abs(u[i, c]) + abs(v[i, c])
        if not total <= LARGEST:  # compared, not asked: of a sum, reassociated, x - x is 0 and np.isfinite is true
            out[BROKEN] = i
            return
        turn = radius[min(i, last - 1)] * v[i, 6]
        speed = np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2 + turn * turn)
        g = np.sqrt(u[i, 3] ** 2 + u[i, 4] ** 2 + u[i, 5] ** 2)
        strain = abs(g - 1.0)
        lean = 1.0 - u[i, 5] / max(g, 1e-12)
        if speed > out[SPEED]:
            out[SPEED], out[SPEED_AT] = speed, i
        if strain > out[STRAIN]:
            out[STRAIN], out[STRAIN_AT] = strain, i
        if lean > out[LEAN]:
            out[LEAN], out[LEAN_AT] = lean, i


_MODULE = '''"""A look at the string's state. Written by drill_twin; do not edit."""
from numba import njit

from drill_twin.base.jit import FLAGS
from drill_twin.audit import state_check


@njit(cache=True, **FLAGS)
def read(radius, u, v, out):
    state_check.read(radius, u, v, out)
'''


def look(rod: Rod, u: Array, v: Array, out: Array) -> None:
    """Fill `out`, shape (7,), from node rows u and v, shape (n + 1, 7) each."""
    _compiled()(rod.outer_radius, u, v, out)


@cache
def _compiled() -> Any:
    return load_generated("state_check", _MODULE).read
