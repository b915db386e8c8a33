# SPDX-License-Identifier: Apache-2.0
"""Sums over the rows of a window as numpy's `sum(axis=0)`: row by row, or pairwise where a row is one number."""

from __future__ import annotations

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.base.exact_jit import exact_kernel
from drill_twin.base.numpy_loops import complex_total, total


@exact_kernel
def sum_rows(rows: Array, out: Array) -> None:
    """Sum of the rows of an array, shape (n, k), to `out`, shape (k,)."""
    if out.size == 1:
        total(rows[:, 0], out)
        return
    out[:] = 0.0
    for i in range(rows.shape[0]):
        for k in range(out.size):
            out[k] += rows[i, k]


@exact_kernel
def complex_sum_rows(rows: ComplexArray, out: ComplexArray) -> None:
    """The same for complex numbers."""
    if out.size == 1:
        complex_total(rows[:, 0], out)
        return
    out[:] = 0.0
    for i in range(rows.shape[0]):
        for k in range(out.size):
            out[k] += rows[i, k]
