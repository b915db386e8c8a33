# SPDX-License-Identifier: Apache-2.0
"""The block-tridiagonal system of a Newton step with four unknowns per node (x, y, x', y'), solved in place.

As `drill_twin.solve.blocks`, with rows of four doubles, which fill a vector register; the right-hand side stands apart.
"""

from drill_twin.rod.jit import kernel
from drill_twin.rod.types import Array

NODE = 4  # unknowns per node: x, y, x', y'
SMALLEST_PIVOT = 1e-300

Row = tuple[float, float, float, float]


@kernel
def load(m: Array, r: int) -> Row:
    """Row r of a block."""
    return m[r, 0], m[r, 1], m[r, 2], m[r, 3]


@kernel
def subtract(m: Array, r: int, factor: float, x: Row) -> None:
    """Row r less a multiple of another row."""
    y0, y1, y2, y3 = m[r, 0] - factor * x[0], m[r, 1] - factor * x[1], m[r, 2] - factor * x[2], m[r, 3] - factor * x[3]
    m[r, 0], m[r, 1], m[r, 2], m[r, 3] = y0, y1, y2, y3


@kernel
def eliminate(d: Array, u: Array, right: Array) -> bool:
    """Overwrite u and the right-hand side with the solutions of d x = u; false if a pivot vanishes."""
    for k in range(NODE):
        if not abs(d[k, k]) > SMALLEST_PIVOT:
            return False
        inverse = 1.0 / d[k, k]
        x, y, z = load(d, k), load(u, k), right[k]
        for r in range(k + 1, NODE):
            factor = d[r, k] * inverse
            subtract(d, r, factor, x)
            subtract(u, r, factor, y)
            right[r] -= factor * z
        d[k, k] = inverse
    for k in range(NODE - 1, -1, -1):
        inverse = d[k, k]
        y0, y1, y2, y3 = u[k, 0] * inverse, u[k, 1] * inverse, u[k, 2] * inverse, u[k, 3] * inverse
        z = right[k] * inverse
        u[k, 0], u[k, 1], u[k, 2], u[k, 3] = y0, y1, y2, y3
        right[k] = z
        for r in range(k):
            subtract(u, r, d[r, k], (y0, y1, y2, y3))
            right[r] -= d[r, k] * z
    return True


@kernel
def solve_blocks(lower: Array, diagonal: Array, upper: Array, right: Array) -> bool:
    """Solve in place; the solution ends in `right`.

    Args:
        lower: Block (i + 1, i), shape (n, 4, 4).
        diagonal: Block (i, i), shape (n + 1, 4, 4); overwritten.
        upper: Block (i, i + 1), shape (n + 1, 4, 4), the last one zero; overwritten.
        right: Right-hand side, shape (n + 1, 4).

    Returns:
        Whether every pivot was usable.
    """
    last = diagonal.shape[0] - 1
    for i in range(last + 1):
        d, b = diagonal[i], right[i]
        if i > 0:
            low, above, before = lower[i - 1], upper[i - 1], right[i - 1]
            for k in range(NODE):
                x, z = load(above, k), before[k]
                for r in range(NODE):
                    subtract(d, r, low[r, k], x)
                    b[r] -= low[r, k] * z
        if not eliminate(d, upper[i], b):
            return False
    for i in range(last - 1, -1, -1):
        u, b, below = upper[i], right[i], right[i + 1]
        for r in range(NODE):
            b[r] -= u[r, 0] * below[0] + u[r, 1] * below[1] + u[r, 2] * below[2] + u[r, 3] * below[3]
    return True
