# SPDX-License-Identifier: Apache-2.0
"""Matrices of a string as block rows [lower, own, upper] of its nodes: products, quarter turn, banded solution.

Each node couples with its neighbours alone, so that all operations take a time in proportion to the elements.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgbsv, zgbsv
from scipy.sparse import csc_array

from drill_twin.core.arrays import Array, Mask

Places = NDArray[np.int64]
"""Indices."""


Solver = Callable[..., Any]
"""Solution, as of `solve_banded`, from the entries of a matrix, the right-hand side, and columns that are replaced."""


def banded(row: Places, column: Places, size: int) -> Solver:
    """Solver of systems of some size that have their entries at the same rows and columns."""
    half = int(np.abs(row - column).max())
    places = column * (3 * half + 1) + 2 * half + row - column

    def solve(entries: NDArray[Any], right: NDArray[Any], *columns: Sequence[Any]) -> Any:
        store = np.zeros((size, 3 * half + 1), entries.dtype)
        store.reshape(-1)[places] = entries
        return solve_banded(store, half, right, *columns)

    return solve


class BlockRows:
    """Operations on block rows, shape (n + 1, k, 3 k), with k unknowns a node.

    Attributes:
        free: Mask of the unknowns that are not constrained, shape (n + 1, k).
        unknowns: Number m of free unknowns.
        row: Of each entry of a matrix of the free unknowns that may differ from zero, its row.
        column: Its column.
    """

    def __init__(self, free: Mask, columns: Places) -> None:
        """Number the free unknowns; `columns` are the places of a node's unknowns in its row of seven."""
        self.free, self.unknowns = free, int(free.sum())
        self._x, self._y = (np.flatnonzero(np.isin(columns, pair)) for pair in ((0, 3), (1, 4)))
        nodes, width = free.shape
        number = np.full((nodes + 2, width), -1)
        number[1:-1][free] = np.arange(self.unknowns)
        row = np.broadcast_to(number[1:-1, :, None], (nodes, width, 3 * width))
        column = np.stack([number[i : i + 3].ravel() for i in range(nodes)])[:, None, :]
        column = np.broadcast_to(column, row.shape)
        taken = ((row >= 0) & (column >= 0)).ravel()
        self._from = np.flatnonzero(taken)
        self.row, self.column = row.ravel()[taken], column.ravel()[taken]

    def dense(self, blocks: Array) -> Array:
        """The full matrix of the free unknowns, shape (m, m)."""
        matrix = np.zeros((self.unknowns, self.unknowns))
        matrix[self.row, self.column] = self.entries(blocks)
        return matrix

    def sparse(self, blocks: Array) -> Any:
        """As `dense`, a sparse matrix."""
        return csc_array((self.entries(blocks), (self.row, self.column)), shape=(self.unknowns, self.unknowns))

    def entries(self, blocks: Array) -> Array:
        """Entries of the matrix of the free unknowns, at `row` and `column`."""
        return np.asarray(blocks.reshape(-1)[self._from])

    def times_j(self, blocks: Array) -> Array:
        """Blocks times J, the quarter turn about the axis."""
        result = np.zeros_like(blocks)
        source, target = self._nodes(blocks), self._nodes(result)
        target[..., self._x], target[..., self._y] = source[..., self._y], -source[..., self._x]
        return result

    def across(self, blocks: Array) -> Array:
        """Blocks times -J J: their columns across the axis."""
        result = np.zeros_like(blocks)
        both = np.concatenate([self._x, self._y])
        self._nodes(result)[..., both] = self._nodes(blocks)[..., both]
        return result

    def times(self, blocks: Array, values: Array) -> Array:
        """Product with values of the free unknowns, shape (m,)."""
        nodes, width = self.free.shape
        padded = np.zeros((nodes + 2, width))
        padded[1:-1][self.free] = values
        beside = np.concatenate([padded[:-2], padded[1:-1], padded[2:]], axis=1)
        return np.asarray(np.matmul(blocks, beside[:, :, None])[self.free, 0])

    @cached_property
    def solver(self) -> Solver:
        """Solver of systems with such entries."""
        return banded(self.row, self.column, self.unknowns)

    def solve(self, blocks: Array, right: Array, held: int = -1, instead: Array | None = None) -> Any:
        """Solution of a banded system, not finite where there is none.

        Args:
            blocks: Of the matrix.
            right: Right-hand side, shape (m,).
            held: Number of a column of the matrix that another one replaces; -1: none.
            instead: That other column, dense, shape (m,).
        """
        return self.solver(self.entries(blocks), right, *(() if instead is None else ([held], [instead])))

    def _nodes(self, blocks: Array) -> Array:
        """View with the columns of each node apart, shape (n + 1, k, 3, k)."""
        nodes, width, _ = blocks.shape
        return blocks.reshape(nodes, width, 3, width)


def solve_banded(
    store: NDArray[Any], half: int, right: NDArray[Any], held: Sequence[int] = (), instead: Sequence[Array] = ()
) -> Any:
    """Solution of a banded system in which dense columns replace some columns; not finite where there is no solution.

    Args:
        store: The matrix in LAPACK's band storage, transposed, shape (m, 3 half + 1); overwritten.
        half: Diagonals on each side.
        right: Right-hand side, shape (m,), or without such columns (m, k).
        held: Numbers of the columns that are replaced.
        instead: The dense columns, shape (m,) each.
    """
    # with unit vectors as these columns the matrix stays banded; one more solution for each makes up for the change
    for column in held:
        store[column], store[column, 2 * half] = 0.0, 1.0
    rights = np.asfortranarray(np.column_stack([right, *instead]))
    solver = zgbsv if np.iscomplexobj(store) else dgbsv
    _, _, found, info = solver(half, half, store.T, rights, overwrite_ab=1, overwrite_b=1)
    if info != 0:
        return np.full(right.shape, np.nan)
    if not held:
        return found.reshape(right.shape)
    columns = list(held)
    try:
        own = np.linalg.solve(found[columns, 1:], found[columns, 0])
    except np.linalg.LinAlgError:
        return np.full(right.shape, np.nan)
    solution = found[:, 0] - found[:, 1:] @ own
    solution[columns] = own
    return solution
