# SPDX-License-Identifier: Apache-2.0
"""Calibration of the parameters that the paper does not give.

Differential evolution (Storn and Price 1997; from scipy): the loss is discontinuous where a whirl changes its branch,
so it has no useful gradient, and a population covers several branches. The first generation holds the values of the
scene and Sobol points; a generation is evaluated as a whole, so the result does not depend on the number of processes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin_evidence.paper.calibration.objective import Loss, evaluate
from drill_twin_evidence.paper.calibration.parameters import PARAMETERS, shares_of, with_shares


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration."""

    seed: int
    shares: tuple[float, ...]
    """Values found, as shares of the way between their bounds."""
    tried: tuple[Loss, ...]
    """Loss of every set of parameters that was tried, in order; the first is the scene as given."""

    @property
    def best(self) -> Loss:
        """Least loss."""
        return min(self.tried, key=lambda loss: loss.total)

    @property
    def values(self) -> list[float]:
        """Values found [unit], one for each of `PARAMETERS`."""
        return [u.value(share) / u.scale for u, share in zip(PARAMETERS, self.shares, strict=True)]

    @property
    def changes(self) -> dict[str, float]:
        """Values found, in SI, by their key in the scene."""
        return {
            place: u.value(share)
            for u, share in zip(PARAMETERS, self.shares, strict=True)
            for place in (u.place, *u.also)
        }


Progress = Callable[[int, int, float], None]
"""Number of evaluations done, their total, and the least loss so far."""


def calibrate(
    scene: Scene, *, seed: int, population: int, generations: int, processes: int, progress: Progress
) -> Calibration:
    """Search for the parameters.

    Args:
        scene: The bench with its present values.
        seed: Seed of the search.
        population: Members of a generation.
        generations: Generations after the first; 0: only the scene as it is.
        processes: Runs at once.
        progress: Called after each evaluation.
    """
    first = qmc.Sobol(len(PARAMETERS), seed=seed).random_base2((population - 1).bit_length())[:population]
    first[0] = shares_of(scene)
    points: list[Array] = []
    tried: list[Loss] = []
    ended: list[float] = []

    def done(loss: Loss) -> None:
        ended.append(loss.total)
        progress(len(ended), population * (generations + 1), min(ended))

    def losses(_function: Callable[[Array], float], generation: Iterable[Array]) -> list[float]:
        """Losses of a generation, as the `workers` argument of scipy expects."""
        listed = [np.array(point) for point in generation]
        found = evaluate([with_shares(scene, point.tolist()) for point in listed], processes, done)
        points.extend(listed)
        tried.extend(found)
        return [loss.total for loss in found]

    if generations:
        differential_evolution(
            _unused, [(0.0, 1.0)] * len(PARAMETERS), init=first, maxiter=generations, seed=seed,
            strategy="currenttobest1bin", mutation=(0.4, 0.9), recombination=0.8, tol=0.0, polish=False,
            updating="deferred", workers=losses,
        )  # fmt: skip
    else:
        losses(_unused, first[:1])
    best = int(np.argmin([loss.total for loss in tried]))
    return Calibration(seed, tuple(points[best].tolist()), tuple(tried))


def _unused(point: Array) -> float:
    """Scalar function that scipy requires and does not call, because generations are evaluated as a whole."""
    raise NotImplementedError(point)
