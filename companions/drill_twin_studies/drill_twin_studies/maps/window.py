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

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin_studies.maps.fields import MapFields
from drill_twin_studies.maps.plane import Span, corners, known_and_calm, on_lattice
from drill_twin_studies.maps.proportions import CONFIDENCE, proportion_interval
from drill_twin_studies.maps.regimes import Regime

MARGIN = 0.02
"""Distance that a window keeps to what is not safe, as a share of the ranges."""
MOST_WINDOWS, LEAST_GAIN = 3, 0.08
"""Largest number of windows, and share of the safe cells that each after the first must add."""


class SafeWindow(NamedTuple):
    """Rectangle of set-points."""

    weight: Span
    """Weight on bit [N]."""
    speed: Span
    """Speed [rad/s]."""


def safe_cells(found: MapFields) -> Mask:
    """Unit cells of a map that are safe, shape (n, n)."""
    from scipy.ndimage import distance_transform_edt

    steps = found.plane.steps
    made, calm = np.zeros((2, steps + 1, steps + 1), bool)
    for node, runs in found.runs_at_nodes.items():
        made[node], calm[node] = True, all(record.regime is Regime.SMOOTH for record in runs)
    good = known_and_calm(made, calm)[1]
    if len(found.growth):
        good &= corners(on_lattice(np.array(found.largest_growth), steps)).max(axis=0) <= 0.0
    if found.has_second_boundary:
        good &= ~corners(found.keeps_whirling).any(axis=0)
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


def cells_of(windows: Sequence[tuple[int, int, int, int]], steps: int) -> Mask:
    """Unit cells in any of the windows, given by their first and last nodes, shape (n, n)."""
    inside = np.zeros((steps,) * 2, bool)
    for i, k, j, m in windows:
        inside[i:k, j:m] = True
    return inside


def basis(found: MapFields, inside: Mask, clean_checks: int) -> list[str]:
    """Grounds of the windows, as sentences; empty without windows.

    Args:
        found: The map.
        inside: Unit cells in its windows, shape (n, n).
        clean_checks: Checks in the windows since the last one that was not smooth.
    """
    if not inside.any():
        return []
    steps = found.plane.steps
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
    if count := clean_checks:
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
