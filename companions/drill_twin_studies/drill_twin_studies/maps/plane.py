# SPDX-License-Identifier: Apache-2.0
"""The plane of a map: a lattice over the ranges of weight on bit and speed, and its cells."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import ArgumentError

UNKNOWN = -1
"""Label of a node without a run."""
Node = tuple[int, int]
"""Place on the lattice: load, speed."""
Labels = NDArray[np.int8]
"""Label of each node of the lattice, `UNKNOWN` where there is none; shape (n + 1, n + 1)."""
FEWEST_CELLS = 4
"""Cells along each range of which a window knows the corners, at least."""


class Span(NamedTuple):
    """Range of a set-point, in SI."""

    low: float
    high: float


class Plane(NamedTuple):
    """Lattice of n by n steps over two ranges."""

    weight: Span
    """Weight on bit [N]."""
    speed: Span
    """Speed of rotation [rad/s]."""
    steps: int
    """Steps of the lattice along each range, a power of 2."""

    def checked(self) -> Self:
        """The plane itself.

        Raises:
            ArgumentError: A range is empty or not finite, or the number of steps is no power of 2 from 8 to 1024.
        """
        for name, span in (("weight on bit", self.weight), ("speed", self.speed)):
            if not (math.isfinite(span.low) and math.isfinite(span.high) and span.low < span.high):
                raise ArgumentError(
                    f"range of the {name}: expected LOW..HIGH with LOW below HIGH, found {span.low:g} to {span.high:g}"
                )
        if self.steps not in {2**power for power in range(3, 11)}:
            raise ArgumentError(f"lattice steps: expected a power of 2 from 8 to 1024, found {self.steps}")
        return self

    def command(self, node: tuple[float, float]) -> tuple[float, float]:
        """Weight on bit [N] and speed [rad/s] at a node, or between nodes."""
        i, j = node
        return (
            self.weight.low + (self.weight.high - self.weight.low) * i / self.steps,
            self.speed.low + (self.speed.high - self.speed.low) * j / self.steps,
        )

    def place(self, weight: float, speed: float) -> tuple[float, float]:
        """Place of a set-point on the lattice, in steps."""
        return (
            (weight - self.weight.low) / (self.weight.high - self.weight.low) * self.steps,
            (speed - self.speed.low) / (self.speed.high - self.speed.low) * self.steps,
        )

    def cells_at(self, place: tuple[float, float]) -> tuple[slice, slice]:
        """Unit cells that a place on the lattice, in steps, lies in or on the edge of; none outside it."""
        i, j = (slice(max(math.ceil(at) - 1, 0), min(math.floor(at), self.steps - 1) + 1) for at in place)
        return i, j

    def labels(self) -> Labels:
        """Labels of a lattice on which nothing is known."""
        return np.full((self.steps + 1, self.steps + 1), UNKNOWN, np.int8)


def wanted(labels: Labels, coarse: int, finest: int, hint: Labels | None = None, hinted: int = 0) -> list[Node]:
    """Nodes to be labelled next, so that cells with more than one label are split down to a size.

    A cell whose corners are known is split into four if the known nodes in it or on its edges have different labels.
    The nodes depend on the labels alone, so a search that was broken off goes on as if it had not been.

    Args:
        labels: What is known.
        coarse: Size of the largest cells, in steps.
        finest: Size below which no cell is split.
        hint: Expected labels; cells in which they differ are split too, down to the size `hinted`.
        hinted: Size below which no cell is split for the hint alone.

    Returns:
        Nodes of the largest cells first; empty at the end of the search.
    """
    found: dict[Node, None] = {}
    steps = labels.shape[0] - 1
    cells = [(i, j) for i in range(0, steps, coarse) for j in range(0, steps, coarse)]
    size = coarse
    while cells:
        split: list[Node] = []
        for i, j in cells:
            corners = [(a, b) for a in (i, i + size) for b in (j, j + size)]
            missing = [node for node in corners if labels[node] == UNKNOWN]
            found.update(dict.fromkeys(missing))
            inside = (slice(i, i + size + 1), slice(j, j + size + 1))
            expected = hint is not None and size > hinted and differ(hint[inside])
            if not missing and size > finest and (differ(labels[inside]) or expected):
                split.append((i, j))
        size //= 2
        cells = [(i + a, j + b) for i, j in split for a in (0, size) for b in (0, size)]
    return list(found)


def differ(labels: Labels) -> bool:
    """True for labels of which two known ones are not the same."""
    known = labels[labels != UNKNOWN]
    return bool(known.size and (known != known[0]).any())


def on_lattice(grid: Array, steps: int) -> Array:
    """Values at the nodes of a lattice, linear between the points of an even grid."""
    nodes, points = np.linspace(0.0, 1.0, steps + 1), np.linspace(0.0, 1.0, grid.shape[0])
    rows = np.array([np.interp(nodes, points, row) for row in grid])
    return np.array([np.interp(nodes, points, column) for column in rows.T]).T


def filled(labels: Labels) -> Labels:
    """Labels of all nodes: each has the label of the nearest known node.

    Raises:
        ArgumentError: No label is known.
    """
    return np.asarray(labels[tuple(nearest_known(labels != UNKNOWN))])


def depth(flags: Mask) -> Array:
    """Distance of each flagged node to the next that is not, in steps; infinite where all are flagged."""
    from scipy.ndimage import distance_transform_edt

    return np.full(flags.shape, math.inf) if flags.all() else np.asarray(distance_transform_edt(flags))


def nearest_known(known: Mask) -> NDArray[np.int64]:
    """Nearest known node of each node, shape (2, n + 1, n + 1).

    Raises:
        ArgumentError: No node is known.
    """
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        raise ArgumentError("expected a map with at least one run, found none")
    places = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(places, np.int64)


def boundary(flags: Mask) -> Iterator[tuple[Array, Array]]:
    """Line between flagged and other nodes, as segments between the middles of lattice edges; each two points (2, 2).

    Marching squares; a cell with both diagonals mixed is cut about its flagged corners.
    """
    from contourpy import contour_generator

    for line in contour_generator(z=flags.astype(float)).lines(0.5):
        yield from pairwise(np.asarray(line)[:, ::-1])


def known_and_calm(made: Mask, calm: Mask) -> tuple[Mask, Mask]:
    """Unit cells that lie in a cell with a run at each corner, and unit cells whose smallest such cell is calm.

    Args:
        made: Nodes with a run, shape (n + 1, n + 1).
        calm: Nodes of which all runs are smooth.

    Returns:
        Two masks of shape (n, n).
    """
    steps = made.shape[0] - 1
    known, good = np.zeros((2, steps, steps), bool)
    size = steps // FEWEST_CELLS
    while size:
        whole, well = (corners(flags[::size, ::size]).all(axis=0) for flags in (made, calm))
        whole, well = (np.kron(flags, np.ones((size, size), bool)) for flags in (whole, well))
        known |= whole
        good = np.where(whole, well, good)
        size //= 2
    return known, good


def corners(values: Array | Mask) -> Array:
    """Values at the four corners of each cell, shape (4, n, n)."""
    return np.array([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])


MOST_WINDOWS, LEAST_GAIN = 3, 0.08
"""Largest number of windows, and share of the safe cells that each window after the first must add; not measured."""


def rectangles(safe: Mask) -> list[tuple[int, int, int, int]]:
    """Largest rectangle of safe cells, and others that add most to it: first and last node along both ranges."""
    found: list[tuple[int, int, int, int]] = []
    new = safe.astype(int)
    while len(found) < MOST_WINDOWS:
        gain, best = _best_rectangle(safe, new)
        if gain <= (LEAST_GAIN * safe.sum() if found else 0):
            break
        found.append(best)
        i, k, j, m = best
        new[i:k, j:m] = 0
    return found


def _best_rectangle(safe: Mask, new: Array) -> tuple[int, tuple[int, int, int, int]]:
    """Rectangle of safe cells with the largest sum of `new`, and that sum."""
    sums = np.zeros(np.add(safe.shape, 1), int)
    sums[1:, 1:] = new.cumsum(axis=0).cumsum(axis=1)
    heights = np.zeros(safe.shape[1], int)
    gain, best = 0, (0, 0, 0, 0)
    for i, row in enumerate(safe):
        heights = np.where(row, heights + 1, 0)
        for j in range(heights.size):
            tall = np.minimum.accumulate(heights[j:])
            tall = tall[: int(np.argmin(tall > 0)) if not tall.all() else tall.size]
            if tall.size:
                last, top = j + 1 + np.arange(tall.size), i + 1 - tall
                sizes = sums[i + 1, last] - sums[top, last] - sums[i + 1, j] + sums[top, j]
                k = int(np.argmax(sizes))
                if sizes[k] > gain:
                    gain, best = int(sizes[k]), (int(top[k]), i + 1, j, int(last[k]))
    return gain, best
