# SPDX-License-Identifier: Apache-2.0
"""Calibration of the parameters that the paper does not give.

Differential evolution (Storn and Price 1997; from scipy): the loss is discontinuous where a whirl changes its branch,
so it has no useful gradient, and a population covers several branches. The first generation holds the values of the
scene and Sobol points; a generation is evaluated as a whole, so the result does not depend on the number of processes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from drill_twin.base.arrays import Array
from drill_twin.scene import Scene
from drill_twin_evidence.paper.calibration.objective import Loss, evaluate
from drill_twin_evidence.paper.calibration.parameters import PARAMETERS, FreeParameter, shares_of, with_shares
from drill_twin_evidence.paper.runs.cases import changed

STEP = 0.03
"""Step of the sensitivity analysis, as a share of the bounds."""
LOSS_MARGIN = 1.0
"""Rise of the loss within which a value counts as equally good."""


@dataclass(frozen=True)
class Found:
    """A calibrated parameter."""

    parameter: FreeParameter
    value: float
    """Best value [unit]."""
    low: float
    """Least tried value at which the loss rises by no more than `LOSS_MARGIN` [unit]."""
    high: float
    """Largest such value [unit]."""
    without: float | None
    """Rise of the loss without the parameter; None where that has no meaning."""
    needed_for: tuple[str, ...]
    """Published numbers that deviate by a further 20 % or more without it."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "place": self.parameter.place, "name": self.parameter.name, "unit": self.parameter.unit,
            "value": self.value, "low": self.low, "high": self.high,
            "without": self.without, "needed_for": list(self.needed_for),
        }  # fmt: skip


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration."""

    start: Loss
    """Loss of the scene as given."""
    best: Loss
    shares: tuple[float, ...]
    """Values found, as shares of the way between their bounds."""
    evaluations: int
    seed: int
    found: tuple[Found, ...] = field(default=())
    tried: tuple[Loss, ...] = field(default=())
    """Loss of every set of parameters that was tried, in order."""

    @property
    def changes(self) -> dict[str, float]:
        """Values found, in SI, by their key in the scene."""
        return {
            place: u.value(share)
            for u, share in zip(PARAMETERS, self.shares, strict=True)
            for place in (u.place, *u.also)
        }


Progress = Callable[[str, int, int, float], None]
"""Stage, number of evaluations done, their total, and the least loss so far."""


class _Search:
    """Evaluates generations and stores the best set of parameters."""

    def __init__(self, scene: Scene, workers: int, progress: Progress, total: int) -> None:
        self.scene, self.workers, self.progress, self.total = scene, workers, progress, total
        self.count, self.best, self.shares = 0, math.inf, tuple[float, ...]()
        self.tried: list[Loss] = []

    def losses(self, points: Iterable[Array]) -> list[Loss]:
        """Losses of some points, in their order."""
        listed, least = [[float(x) for x in point] for point in points], self.best

        def done(value: Loss) -> None:
            nonlocal least
            self.count, least = self.count + 1, min(least, value.total)
            self.progress("search", self.count, self.total, least)

        found = evaluate([with_shares(self.scene, shares) for shares in listed], self.workers, done)
        for shares, value in zip(listed, found, strict=True):
            if value.total < self.best:
                self.best, self.shares = value.total, tuple(shares)
        self.tried += found
        return found

    def map(self, _function: Callable[[Array], float], points: Iterable[Array]) -> list[float]:
        """Losses of a generation, as the `workers` argument of scipy expects."""
        return [value.total for value in self.losses(points)]


def _unused(point: Array) -> float:
    """Scalar function that scipy requires and does not call, because generations are evaluated as a whole."""
    raise NotImplementedError(point)


def calibrate(
    scene: Scene, *, seed: int, population: int, generations: int, processes: int, progress: Progress
) -> Calibration:
    """Search for the parameters, then find the uncertainty and the importance of each.

    Args:
        scene: The bench with its present values.
        seed: Seed of the search.
        population: Members of a generation.
        generations: Generations after the first.
        processes: Runs at once.
        progress: Called after each evaluation.
    """
    own = shares_of(scene)
    first = qmc.Sobol(len(PARAMETERS), seed=seed).random_base2((population - 1).bit_length())[:population]
    first[0] = own
    search = _Search(scene, processes, progress, population * (generations + 1))
    if generations:
        differential_evolution(
            _unused, [(0.0, 1.0)] * len(PARAMETERS), init=first, maxiter=generations, seed=seed,
            strategy="currenttobest1bin", mutation=(0.4, 0.9), recombination=0.8, tol=0.0, polish=False,
            updating="deferred", workers=search.map,
        )  # fmt: skip
    else:
        search.map(_unused, first[:1])
    spent, shares = search.count, search.shares
    best, start = search.losses([np.array(shares), np.array(own)])
    found = _examine(search, np.array(shares), best)
    return Calibration(start, best, shares, spent, seed, tuple(found), tuple(search.tried))


def _examine(search: _Search, at: Array, best: Loss) -> list[Found]:
    """Sensitivity of the loss to each parameter, and loss without each."""
    moved = []
    for number in range(len(PARAMETERS)):
        for step in (-2 * STEP, -STEP, STEP, 2 * STEP):
            point = at.copy()
            point[number] = min(max(point[number] + step, 0.0), 1.0)
            moved.append(point)
    rises = [value.total - best.total for value in search.losses(moved)]
    left_out = [parameter for parameter in PARAMETERS if parameter.off is not None]
    without = dict(zip((u.place for u in left_out), _without(search, at, left_out), strict=True))
    found = []
    for number, parameter in enumerate(PARAMETERS):
        four = rises[4 * number : 4 * number + 4]
        down = 0 if four[1] > LOSS_MARGIN else 1 if four[0] > LOSS_MARGIN else 2
        up = 0 if four[2] > LOSS_MARGIN else 1 if four[3] > LOSS_MARGIN else 2
        low, value, high = (
            float(parameter.value(min(max(float(at[number]) + step, 0.0), 1.0)) / parameter.scale)
            for step in (-down * STEP, 0.0, up * STEP)
        )
        gone = without.get(parameter.place)
        needed = () if gone is None else tuple(
            name for name, e in gone.deviations.items() if e > best.deviations[name] + 1.0
        )  # fmt: skip
        found.append(Found(parameter, value, low, high, None if gone is None else gone.total - best.total, needed))
    return found


def _without(search: _Search, at: Array, parameters: list[FreeParameter]) -> list[Loss]:
    """Losses with each of some parameters at the value that leaves it out."""
    values = [0.0 if parameter.off is None else parameter.off * parameter.scale for parameter in parameters]
    best = with_shares(search.scene, list(at))
    scenes = [changed(best, parameter.place, off) for parameter, off in zip(parameters, values, strict=True)]
    ended = itertools.count(1)

    def done(_: Loss) -> None:
        search.progress("leaving out", next(ended), len(parameters), search.best)

    return evaluate(scenes, search.workers, done)
