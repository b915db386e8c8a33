# SPDX-License-Identifier: Apache-2.0
"""The search for what the paper leaves open.

Differential evolution (Storn and Price 1997; scipy's, which is well kept): the loss jumps where a whirl turns from one
branch to another, so there is no gradient to follow, and a population keeps several branches alive. The scene's own
numbers are one member of the first generation, Sobol points the others; a generation is evaluated as a whole, so the
result does not depend on the number of processes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from drill_twin.base.arrays import Array
from drill_twin.scene import Scene
from drill_twin.studies.paper.calibration.objective import Loss, lateral, loss_at
from drill_twin.studies.paper.calibration.unknowns import UNKNOWNS, Unknown, shares_of
from drill_twin.studies.paper.runs.run import compile_for
from drill_twin.studies.pool import process_pool

STEP = 0.03
"""Shares by which a number is moved to see how sharply it is known."""
TOLERATED = 1.0
"""A loss this much higher still counts as the same quality."""


@dataclass(frozen=True)
class Found:
    """One number found."""

    unknown: Unknown
    value: float
    """[unit]"""
    low: float
    """Down to here the loss rises by no more than `TOLERATED`, as far as was tried [unit]."""
    high: float
    """Up to here [unit]."""
    without: float | None
    """Rise of the loss when it is left out; None where that has no meaning."""
    needed_for: tuple[str, ...]
    """Numbers that are worse by 20 % or more without it."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "place": self.unknown.place, "name": self.unknown.name, "unit": self.unknown.unit, "value": self.value,
            "low": self.low, "high": self.high, "without": self.without, "needed_for": list(self.needed_for),
        }  # fmt: skip


@dataclass(frozen=True)
class Calibration:
    """The result of a search."""

    start: Loss
    """Of the scene as it was."""
    best: Loss
    shares: tuple[float, ...]
    """Where the numbers found lie between their bounds."""
    evaluations: int
    seed: int
    found: tuple[Found, ...] = field(default=())
    tried: tuple[Loss, ...] = field(default=())
    """Every set that the search tried, in its order."""

    @property
    def changes(self) -> dict[str, float]:
        """The numbers found, in SI, by their place in the scene."""
        return {
            place: u.value(share)
            for u, share in zip(UNKNOWNS, self.shares, strict=True)
            for place in (u.place, *u.also)
        }


Progress = Callable[[str, int, int, float], None]
"""What is being done, how much of it, of how much, and the least loss so far."""


class _Search:
    """Evaluates generations and remembers the best."""

    def __init__(self, scene: Scene, workers: ProcessPoolExecutor | None, progress: Progress, total: int) -> None:
        self.scene, self.workers, self.progress, self.total = scene, workers, progress, total
        self.count, self.best, self.shares = 0, math.inf, tuple[float, ...]()
        self.tried: list[Loss] = []

    def losses(self, points: Iterable[Array]) -> list[Loss]:
        """The losses of some points, in their order."""
        listed = [[float(x) for x in point] for point in points]
        scenes = [self.scene] * len(listed)
        found = []
        for shares, value in zip(listed, (self.workers.map if self.workers else map)(loss_at, scenes, listed)):  # noqa: B905
            self.count += 1
            if value.total < self.best:
                self.best, self.shares = value.total, tuple(shares)
            self.progress("search", self.count, self.total, self.best)
            found.append(value)
        self.tried += found
        return found

    def map(self, _function: Callable[[Array], float], points: Iterable[Array]) -> list[float]:
        """The losses of a generation, as scipy asks for them."""
        return [value.total for value in self.losses(points)]


def _nowhere(point: Array) -> float:
    """Scipy's scalar entry, which is not used: generations are evaluated as a whole."""
    raise NotImplementedError(point)


def calibrate(
    scene: Scene, *, seed: int, population: int, generations: int, processes: int, progress: Progress
) -> Calibration:
    """Search, then see how sharply each number is known and what it is needed for.

    Args:
        scene: The bench with its present numbers.
        seed: Of the search.
        population: Members of a generation.
        generations: How many generations after the first.
        processes: How many evaluations at once.
        progress: Told after each evaluation.
    """
    own = shares_of(scene)
    for form in (scene, lateral(scene)):
        compile_for(form)
    first = qmc.Sobol(len(UNKNOWNS), seed=seed).random_base2((population - 1).bit_length())[:population]
    first[0] = own
    with process_pool(processes) if processes > 1 else nullcontext() as workers:
        search = _Search(scene, workers, progress, population * (generations + 1))
        if generations:
            differential_evolution(
                _nowhere, [(0.0, 1.0)] * len(UNKNOWNS), init=first, maxiter=generations, seed=seed,
                strategy="currenttobest1bin", mutation=(0.4, 0.9), recombination=0.8, tol=0.0, polish=False,
                updating="deferred", workers=search.map,
            )  # fmt: skip
        else:
            search.map(_nowhere, first[:1])
        spent, shares = search.count, search.shares
        best, start = search.losses([np.array(shares), np.array(own)])
        found = _examine(search, np.array(shares), best)
    return Calibration(start, best, shares, spent, seed, tuple(found), tuple(search.tried))


def _examine(search: _Search, at: Array, best: Loss) -> list[Found]:
    """Move each number a little each way, and leave each out in turn."""
    moved = []
    for number in range(len(UNKNOWNS)):
        for step in (-2 * STEP, -STEP, STEP, 2 * STEP):
            point = at.copy()
            point[number] = min(max(point[number] + step, 0.0), 1.0)
            moved.append(point)
    rises = [value.total - best.total for value in search.losses(moved)]
    left_out = [unknown for unknown in UNKNOWNS if unknown.off is not None]
    without = dict(zip((u.place for u in left_out), _without(search, at, left_out), strict=True))
    found = []
    for number, unknown in enumerate(UNKNOWNS):
        four = rises[4 * number : 4 * number + 4]
        down = 0 if four[1] > TOLERATED else 1 if four[0] > TOLERATED else 2
        up = 0 if four[2] > TOLERATED else 1 if four[3] > TOLERATED else 2
        low, value, high = (
            float(unknown.value(min(max(float(at[number]) + step, 0.0), 1.0)) / unknown.scale)
            for step in (-down * STEP, 0.0, up * STEP)
        )
        gone = without.get(unknown.place)
        needed = () if gone is None else tuple(
            name for name, e in gone.deviations.items() if e > best.deviations[name] + 1.0
        )  # fmt: skip
        found.append(Found(unknown, value, low, high, None if gone is None else gone.total - best.total, needed))
    return found


def _without(search: _Search, at: Array, unknowns: list[Unknown]) -> list[Loss]:
    """The losses with each of some numbers at the value that stands for leaving it out."""
    from drill_twin.studies.paper.calibration.objective import evaluate, loss
    from drill_twin.studies.paper.calibration.unknowns import with_shares
    from drill_twin.studies.paper.runs.cases import changed

    losses = []
    for number, unknown in enumerate(unknowns):
        off = 0.0 if unknown.off is None else unknown.off * unknown.scale
        scene = changed(with_shares(search.scene, list(at)), unknown.place, off)
        losses.append(loss(evaluate(scene)))
        search.progress("leaving out", number + 1, len(unknowns), search.best)
    return losses
