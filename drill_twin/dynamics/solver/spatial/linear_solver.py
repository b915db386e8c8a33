# SPDX-License-Identifier: Apache-2.0
"""The block-tridiagonal system of one Newton step, solved in place without pivoting.

A node has seven unknowns (r, r', psi), so a row of blocks is ``lower (7x7) | diagonal (7x7) | upper (7x7)``. Rows are
padded to eight columns and the eighth column of the diagonal block carries the right-hand side, so that elimination
works on whole rows of eight doubles. A row is loaded, combined and only then stored: no store can alias a later load,
so the compiler uses vector instructions, which more than halves the time of the solve.

Pivoting is not needed: the mass term keeps the pivots away from zero, and a step for which it does not is halved
(`drill_twin.dynamics.solver.midpoint`).

Work arrays are allocated once: no kernel allocates.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.section import RESULTANTS

NODE = 7  # unknowns per node: r (3), r' (3), psi
ROW = 8  # padded row
SMALLEST_PIVOT = 1e-300

Row = tuple[float, float, float, float, float, float, float, float]


@kernel
def load_row(m: Array, r: int) -> Row:
    """Row r of a block."""
    return m[r, 0], m[r, 1], m[r, 2], m[r, 3], m[r, 4], m[r, 5], m[r, 6], m[r, 7]


@kernel
def subtract_row(m: Array, r: int, factor: float, x: Row) -> None:
    """Row r less a multiple of another row."""
    x0, x1, x2, x3, x4, x5, x6, x7 = x
    y0, y1, y2, y3 = m[r, 0] - factor * x0, m[r, 1] - factor * x1, m[r, 2] - factor * x2, m[r, 3] - factor * x3
    y4, y5, y6, y7 = m[r, 4] - factor * x4, m[r, 5] - factor * x5, m[r, 6] - factor * x6, m[r, 7] - factor * x7
    m[r, 0], m[r, 1], m[r, 2], m[r, 3] = y0, y1, y2, y3
    m[r, 4], m[r, 5], m[r, 6], m[r, 7] = y4, y5, y6, y7


@kernel
def scale_row(m: Array, r: int, factor: float) -> None:
    """Row r times a factor."""
    y0, y1, y2, y3 = m[r, 0] * factor, m[r, 1] * factor, m[r, 2] * factor, m[r, 3] * factor
    y4, y5, y6, y7 = m[r, 4] * factor, m[r, 5] * factor, m[r, 6] * factor, m[r, 7] * factor
    m[r, 0], m[r, 1], m[r, 2], m[r, 3] = y0, y1, y2, y3
    m[r, 4], m[r, 5], m[r, 6], m[r, 7] = y4, y5, y6, y7


@kernel
def eliminate(d: Array, u: Array) -> bool:
    """Overwrite u with the solution of d x = u by Gaussian elimination; false if a pivot vanishes."""
    for k in range(NODE):
        if not abs(d[k, k]) > SMALLEST_PIVOT:
            return False
        inverse = 1.0 / d[k, k]
        x, y = load_row(d, k), load_row(u, k)
        for r in range(k + 1, NODE):
            factor = d[r, k] * inverse
            subtract_row(d, r, factor, x)
            subtract_row(u, r, factor, y)
        d[k, k] = inverse
    for k in range(NODE - 1, -1, -1):
        scale_row(u, k, d[k, k])
        y = load_row(u, k)
        for r in range(k):
            subtract_row(u, r, d[r, k], y)
    return True


@kernel
def solve_blocks(lower: Array, diagonal: Array, upper: Array, spare: Array) -> bool:
    """Solve in place; the solution ends in ``diagonal[:, :, 7]``.

    Args:
        lower: Block (i + 1, i), shape (n, 7, 8).
        diagonal: Block (i, i) and right-hand side, shape (n + 1, 7, 8); overwritten.
        upper: Block (i, i + 1), shape (n, 7, 8); overwritten.
        spare: Scratch, shape (7, 8).

    Returns:
        Whether every pivot was usable.
    """
    last = diagonal.shape[0] - 1
    for i in range(last + 1):
        d = diagonal[i]
        if i > 0:
            low, above = lower[i - 1], upper[i - 1]
            for k in range(NODE):
                x = load_row(above, k)
                for r in range(NODE):
                    subtract_row(d, r, low[r, k], x)
        u = upper[i] if i < last else spare
        for r in range(NODE):
            u[r, NODE] = d[r, NODE]
        if not eliminate(d, u):
            return False
    for r in range(NODE):
        diagonal[last, r, NODE] = spare[r, NODE]
    for i in range(last - 1, -1, -1):
        u, below = upper[i], diagonal[i + 1]
        for r in range(NODE):
            total = u[r, NODE]
            for c in range(NODE):
                total -= u[r, c] * below[c, NODE]
            diagonal[i, r, NODE] = total
    return True


class Workspace(NamedTuple):
    """The block system, and the small matrices of the current element and Gauss point."""

    lower: Array  # (n, 7, 8) block of node i + 1 by node i
    diagonal: Array  # (n + 1, 7, 8) last column the residual, then the Newton step
    upper: Array  # (n, 7, 8) block of node i by node i + 1
    spare: Array  # (7, 8)
    ends: Array  # (2, 7, 8) loads on bit and top: tangent, and residual in the last column
    reaction: Array  # (2, 7) residual at bit and top before the constraints were imposed: forces of rig and rock
    end_rows: Array  # (2, 7, 14) their rows of the system
    command: Array  # (3,) set-points: weight on bit [N], rotation [rad/s], speed of a block [m/s]
    resultants: Array  # (7,) see drill_twin.physics.model.section
    force: Array  # (8,) conjugate to r', r'', psi', psi
    saa: Array  # (3, 3) their derivatives
    sab: Array
    sba: Array
    sbb: Array
    coupling: Array  # (4, 3)
    load: Array  # (4,) force per length on r and couple per length on the spin
    stiff: Array  # (4, 4) minus its derivative by the velocities (and half_step times by the positions)
    ke: Array  # (9, 16) element tangent: component pair (x, y, z by x, y, z), then shape pair (4 by 4)
    kc: Array  # (4, 3, 4) spin coupling by component and shape: columns of node 0 and 1, rows of node 0 and 1
    re: Array  # (3, 4) element residual: component, shape
    ue: Array  # (4, 3) element unknowns: shape, component
    ve: Array  # (4, 3) velocities
    dv: Array  # (4, 3) velocity changes


def make_workspace(elements: int) -> Workspace:
    """Arrays of zeros for a string of so many elements."""
    n = elements
    return Workspace(
        lower=np.zeros((n, 7, 8)),
        diagonal=np.zeros((n + 1, 7, 8)),
        upper=np.zeros((n, 7, 8)),
        spare=np.zeros((7, 8)),
        ends=np.zeros((2, 7, 8)),
        reaction=np.zeros((2, 7)),
        end_rows=np.zeros((2, 7, 14)),
        command=np.zeros(3),
        resultants=np.zeros(RESULTANTS),
        force=np.zeros(8),
        saa=np.zeros((3, 3)),
        sab=np.zeros((3, 3)),
        sba=np.zeros((3, 3)),
        sbb=np.zeros((3, 3)),
        coupling=np.zeros((4, 3)),
        load=np.zeros(4),
        stiff=np.zeros((4, 4)),
        ke=np.zeros((9, 16)),
        kc=np.zeros((4, 3, 4)),
        re=np.zeros((3, 4)),
        ue=np.zeros((4, 3)),
        ve=np.zeros((4, 3)),
        dv=np.zeros((4, 3)),
    )
