# SPDX-License-Identifier: Apache-2.0
"""The block-tridiagonal system with four unknowns per node (x, y, x', y'): factored once, solved often.

With D_i the pivot block of node i, L and U its neighbours: keep D_i^-1, D_i^-1 L_i-1 and D_i^-1 U_i. Then a solve is
``z_i = D_i^-1 b_i - (D_i^-1 L) z_i-1`` upwards and ``x_i = z_i - (D_i^-1 U) x_i+1`` downwards: two chains of one small
product per node. Rows of four doubles fill a vector register.

Without contact the tangent changes slowly: its factors serve many steps, as in codes for stiff equations (Hairer and
Wanner 1996, IV.8). The factors are renewed where the step changed or Newton's method slows down.

Work arrays are allocated once: no kernel allocates.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.section import RESULTANTS

NODE = 4  # unknowns per node: x, y, x', y'
SMALLEST_PIVOT = 1e-300

Row = tuple[float, float, float, float]


@kernel
def load(m: Array, r: int) -> Row:
    """Row r of a block."""
    return m[r, 0], m[r, 1], m[r, 2], m[r, 3]


@kernel
def store(m: Array, r: int, x: Row) -> None:
    """Overwrite row r."""
    m[r, 0], m[r, 1], m[r, 2], m[r, 3] = x


@kernel
def plus(x: Row, factor: float, y: Row) -> Row:
    """Row x and a multiple of row y."""
    return x[0] + factor * y[0], x[1] + factor * y[1], x[2] + factor * y[2], x[3] + factor * y[3]


@kernel
def times(factor: float, x: Row) -> Row:
    """A row scaled."""
    return factor * x[0], factor * x[1], factor * x[2], factor * x[3]


@kernel
def invert(d: Array, out: Array) -> bool:
    """Inverse of a block by Gauss-Jordan elimination, which destroys d; false if a pivot vanishes."""
    for r in range(NODE):
        for c in range(NODE):
            out[r, c] = 1.0 if r == c else 0.0
    for k in range(NODE):
        if not abs(d[k, k]) > SMALLEST_PIVOT:
            return False
        inverse = 1.0 / d[k, k]
        x, y = times(inverse, load(d, k)), times(inverse, load(out, k))
        store(d, k, x)
        store(out, k, y)
        for r in range(NODE):
            if r != k:
                factor = -d[r, k]
                store(d, r, plus(load(d, r), factor, x))
                store(out, r, plus(load(out, r), factor, y))
    return True


@kernel
def multiply(a: Array, b: Array) -> None:
    """Overwrite b with a b."""
    b0, b1, b2, b3 = load(b, 0), load(b, 1), load(b, 2), load(b, 3)
    for r in range(NODE):
        store(b, r, plus(plus(plus(times(a[r, 0], b0), a[r, 1], b1), a[r, 2], b2), a[r, 3], b3))


@kernel
def factor_blocks(lower: Array, diagonal: Array, upper: Array, inverse: Array) -> bool:
    """Factor in place.

    Args:
        lower: Block (i + 1, i), shape (n, 4, 4); becomes D_i+1^-1 L_i.
        diagonal: Block (i, i), shape (n + 1, 4, 4); destroyed.
        upper: Block (i, i + 1), shape (n, 4, 4); becomes D_i^-1 U_i.
        inverse: Result D_i^-1, shape (n + 1, 4, 4).

    Returns:
        Whether every pivot was usable.
    """
    last = diagonal.shape[0] - 1
    for i in range(last + 1):
        d = diagonal[i]
        if i > 0:
            low, above = lower[i - 1], upper[i - 1]
            a0, a1, a2, a3 = load(above, 0), load(above, 1), load(above, 2), load(above, 3)
            for r in range(NODE):
                row = plus(plus(load(d, r), -low[r, 0], a0), -low[r, 1], a1)
                store(d, r, plus(plus(row, -low[r, 2], a2), -low[r, 3], a3))
        if not invert(d, inverse[i]):
            return False
        if i > 0:
            multiply(inverse[i], lower[i - 1])
        if i < last:
            multiply(inverse[i], upper[i])
    return True


@kernel
def dot(m: Array, r: int, x: Row) -> float:
    """Row r of a block times a vector."""
    total: float = m[r, 0] * x[0] + m[r, 1] * x[1] + m[r, 2] * x[2] + m[r, 3] * x[3]
    return total


@kernel
def solve_blocks(lower: Array, upper: Array, inverse: Array, right: Array) -> None:
    """Overwrite the right-hand side, shape (n + 1, 4), with the solution, by the factors of `factor_blocks`."""
    last = right.shape[0] - 1
    z = (0.0, 0.0, 0.0, 0.0)
    for i in range(last + 1):
        d, b = inverse[i], load(right, i)
        y = dot(d, 0, b), dot(d, 1, b), dot(d, 2, b), dot(d, 3, b)
        if i > 0:
            low = lower[i - 1]
            y = y[0] - dot(low, 0, z), y[1] - dot(low, 1, z), y[2] - dot(low, 2, z), y[3] - dot(low, 3, z)
        store(right, i, y)
        z = y
    for i in range(last - 1, -1, -1):
        u, y = upper[i], load(right, i)
        z = y[0] - dot(u, 0, z), y[1] - dot(u, 1, z), y[2] - dot(u, 2, z), y[3] - dot(u, 3, z)
        store(right, i, z)


# Indices into Workspace.reuse: half step of the factors [s] (0: there are none, negative: assembled, not yet factored),
# 1 if they must be renewed, steps for which they are renewed at once, size of the last Newton step, stiffness and
# damping that the effects had added to them [N s/m].
HALF_STEP, RENEW, RENEW_STEPS, LAST_SIZE, ADDED = 0, 1, 2, 3, 4
CONTRACTION = 0.1  # the factors are kept while each Newton step is this much smaller than the last
CHANGE = 0.1  # and while stiffness and damping of the effects, mostly of the wall, have changed by less than this share
SAME_STEP = 1e-9  # steps of one length differ by rounding
STEPS_AFTER_CHANGE = 8.0  # steps of renewing at once, after factors that were not good enough


@kernel
def outdated(reuse: Array, half_step: float, first_iteration: bool) -> bool:
    """True if the tangent must be assembled and factored again; `first_iteration`: in the first iteration of a step."""
    if first_iteration:
        reuse[LAST_SIZE] = 0.0
        reuse[RENEW_STEPS] = max(reuse[RENEW_STEPS] - 1.0, 0.0)
    if reuse[RENEW_STEPS] > 0.0:
        reuse[RENEW] = 1.0
    other_step: bool = abs(reuse[HALF_STEP] - half_step) > SAME_STEP * half_step
    return other_step or reuse[RENEW] > 0.0


@kernel
def check_contraction(reuse: Array, size: float) -> None:
    """Have the factors renewed if a Newton step of this size is not much smaller than the last."""
    if reuse[LAST_SIZE] > 0.0 and not size < CONTRACTION * reuse[LAST_SIZE]:
        reuse[RENEW] = 1.0
        reuse[RENEW_STEPS] = STEPS_AFTER_CHANGE
    reuse[LAST_SIZE] = size


# Indices into Workspace.axial: force at the bit and at the top [N], load on the string along the axis [N], torque of
# the top drive [N m].
AT_BIT, AT_TOP, WEIGHT, TORQUE = 0, 1, 2, 3


class Workspace(NamedTuple):
    """The block system, and the small matrices of the current element."""

    lower: Array  # (n, 4, 4)
    diagonal: Array  # (n + 1, 4, 4)
    upper: Array  # (n, 4, 4)
    inverse: Array  # (n + 1, 4, 4) of the pivot blocks; with it, lower and upper are factors
    right: Array  # (n + 1, 4)
    reuse: Array  # (5,) see drill_twin.dynamics.solver.lateral.linear_solver
    ends: Array  # (2, 7, 8) loads on bit and top, as in space
    command: Array  # (3,) set-points: weight on bit [N], rotation [rad/s], speed of a block [m/s]
    lever: Array  # (n + 1, 4) change of the torque below by the unknowns' velocities
    axial: Array  # (4,) see AT_BIT
    resultants: Array  # (7,) see drill_twin.physics.model.section
    load: Array  # (4,)
    stiff: Array  # (4, 4)
    ke: Array  # (4, 16) element tangent: component pair xx, xy, yx, yy, then shape pair
    re: Array  # (2, 4) element residual: component, shape
    ue: Array  # (2, 4) element unknowns: component, shape
    ve: Array  # (2, 4) velocities
    dv: Array  # (2, 4) velocity changes
    rows: Array  # (3, n + 1, 7) rows at mid-step, velocities then and at the start, as in space; (3, 0, 7): no loads
    nodes: Array  # (n + 1, 7, 8) loads on the nodes, as in space; (0, 7, 8): none


def make_workspace(elements: int, loaded: int = 0) -> Workspace:
    """Arrays of zeros for a string of so many elements; `loaded` nodes with loads, all or none."""
    n = elements
    return Workspace(
        lower=np.zeros((n, 4, 4)),
        diagonal=np.zeros((n + 1, 4, 4)),
        upper=np.zeros((n, 4, 4)),
        inverse=np.zeros((n + 1, 4, 4)),
        right=np.zeros((n + 1, 4)),
        reuse=np.zeros(5),
        ends=np.zeros((2, 7, 8)),
        command=np.zeros(3),
        lever=np.zeros((n + 1, 4)),
        axial=np.zeros(4),
        resultants=np.zeros(RESULTANTS),
        load=np.zeros(4),
        stiff=np.zeros((4, 4)),
        ke=np.zeros((4, 16)),
        re=np.zeros((2, 4)),
        ue=np.zeros((2, 4)),
        ve=np.zeros((2, 4)),
        dv=np.zeros((2, 4)),
        rows=np.zeros((3, loaded, 7)),
        nodes=np.zeros((loaded, 7, 8)),
    )
