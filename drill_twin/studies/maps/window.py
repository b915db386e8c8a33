# SPDX-License-Identifier: Apache-2.0
"""Safe windows: rectangles of set-points that are calm by all that a map knows, and what they rest on.

The plane is judged in cells of one step. A cell is safe if
* it lies in a cell of the search whose four corners have runs, all of them smooth in all their draws (a run that has
  not settled is not smooth); the smallest such cell decides;
* the linear string does not grow at any of its corners, where its growth is known;
* a whirl that exists dies there, where that was searched;
* no check in it failed: a run of the whole time asked;
* it keeps `MARGIN` to the next cell that is not safe.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.studies.maps.plane import Span, on_lattice
from drill_twin.studies.maps.regimes import Regime


def proportion_interval(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Two-sided limits of the chance behind `count` of `trials`; (0, 1), nothing known, without trials.

    They hold at least as often as `confidence`, whatever the chance and however few the trials. The upper limit alone
    holds with a confidence of (1 + confidence) / 2, so that 0.9 gives the one-sided 95 % limit.

    >>> low, high = proportion_interval(41, 42)
    >>> round(low, 3), round(high, 4)
    (0.874, 0.9994)
    """
    from scipy.special import betaincinv

    outside = 0.5 * (1.0 - confidence)
    low = 0.0 if count == 0 else float(betaincinv(count, trials - count + 1, outside))
    high = 1.0 if count == trials else float(betaincinv(count + 1, trials - count, 1.0 - outside))
    return low, high


def proportion_text(count: int, trials: int, confidence: float = 0.95) -> str:
    """The count with its limits in words.

    >>> proportion_text(41, 42)
    '41 of 42 (95 % interval 87.4 to 99.9 %)'
    >>> proportion_text(0, 0)
    '0 of 0 (not known)'
    """
    if trials == 0:
        return "0 of 0 (not known)"
    low, high = (100.0 * limit for limit in proportion_interval(count, trials, confidence))
    return f"{count} of {trials} ({100.0 * confidence:.3g} % interval {low:.3g} to {high:.3g} %)"


if TYPE_CHECKING:
    from drill_twin.studies.maps.operating_map import OperatingMap

MARGIN = 0.02
"""Distance that a window keeps to what is not safe, as a share of the ranges."""
FEWEST_CELLS = 4
"""Cells along each range of which a window knows the corners, at least."""
MOST_WINDOWS, LEAST_GAIN = 3, 0.08
"""Largest number of windows, and share of the safe cells that each after the first must add."""
CONFIDENCE = 0.9
"""Two-sided confidence of a count, of which the upper limit holds with 95 %."""


class SafeWindow(NamedTuple):
    """Rectangle of set-points."""

    weight: Span
    """Weight on bit [N]."""
    speed: Span
    """Speed [rad/s]."""


def known_and_calm(made: Mask, calm: Mask) -> tuple[Mask, Mask]:
    """Unit cells that lie in a cell with a run at each corner, and those of which the smallest such cell is calm.

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
        whole, well = (_corners(flags[::size, ::size]).all(axis=0) for flags in (made, calm))
        whole, well = (np.kron(flags, np.ones((size, size), bool)) for flags in (whole, well))
        known |= whole
        good = np.where(whole, well, good)
        size //= 2
    return known, good


def _corners(values: Array | Mask) -> Array:
    """Values at the four corners of each cell, shape (4, n, n)."""
    return np.array([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])


def safe_cells(found: OperatingMap) -> Mask:
    """Unit cells of a map that are safe, shape (n, n)."""
    from scipy.ndimage import distance_transform_edt

    steps = found.plane.steps
    made, calm = np.zeros((2, steps + 1, steps + 1), bool)
    for node, runs in found.runs_at_nodes.items():
        made[node], calm[node] = True, all(record.regime is Regime.SMOOTH for record in runs)
    good = known_and_calm(made, calm)[1]
    if len(found.growth):
        good &= _corners(on_lattice(np.array(found.largest_growth), steps)).max(axis=0) <= 0.0
    if found.has_second_boundary:
        good &= ~_corners(found.keeps_whirling).any(axis=0)
    for key, record in found.checks:
        if record.regime is not Regime.SMOOTH:
            good[found.plane.cells_at(key.place)] = False
    if good.all():
        return good
    return np.asarray(distance_transform_edt(good) > MARGIN * steps + 0.5)


def rectangles(safe: Mask) -> list[tuple[int, int, int, int]]:
    """Largest rectangle of safe cells, and those that add most to it: first and last node along both ranges."""
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


def cells_of(found: OperatingMap) -> Mask:
    """Unit cells in any of the windows, shape (n, n)."""
    inside = np.zeros((found.plane.steps,) * 2, bool)
    for i, k, j, m in found.window_nodes:
        inside[i:k, j:m] = True
    return inside


def basis(found: OperatingMap) -> list[str]:
    """Grounds of the windows, as sentences; empty without windows."""
    if not found.window_nodes:
        return []
    inside, steps = cells_of(found), found.plane.steps
    nodes = np.zeros((steps + 1,) * 2, bool)
    for shift in ((0, 0), (0, 1), (1, 0), (1, 1)):
        nodes[shift[0] : shift[0] + steps, shift[1] : shift[1] + steps] |= inside
    runs = sum(len(runs) for node, runs in found.runs_at_nodes.items() if nodes[node])
    runs_said = (
        f"{runs} runs of {found.duration:g} s in them and at their corners, all smooth: none would whirl or swing "
        f"within {found.asked:g} s if it went on growing as at its end"
    )
    said = [runs_said]
    if len(found.growth):
        largest = float(on_lattice(np.array(found.largest_growth), steps)[nodes].max())
        said.append(f"the straight string does not grow anywhere in them (largest rate {largest:.2g} 1/s)")
    else:
        said.append("linear growth is not known for this scene, so nothing is known between its runs")
    said.append(
        "a whirl that exists dies in them, on the way that was tried"
        if found.has_second_boundary
        else "whether a whirl that exists dies in them was not searched"
    )
    if len(found.draws) > 1:
        shown = proportion_interval(0, len(found.draws), CONFIDENCE)[1]
        said.append(
            f"no draw whirls at their set-points with {len(found.draws)} draws: each of them whirls with a chance "
            f"below {shown:.1%} (95 %)"
        )
    count = found.clean_checks
    if count:
        most = proportion_interval(0, count, CONFIDENCE)[1]
        said.append(
            f"{count} more runs of {found.asked:g} s at set-points drawn in them are smooth: at most {most:.1%} of "
            "their set-points are not (95 %)"
        )
    else:
        said.append(
            f"no run of {found.asked:g} s was made in them, so what share of their set-points is calm is not known"
        )
    said.append(
        f"they keep {MARGIN:.0%} of the ranges to all that is not safe or not known; nothing of this is of a rig"
    )
    return said
