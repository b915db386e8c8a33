# SPDX-License-Identifier: Apache-2.0
"""Fit of a rig with its own law: how wide the bands of somebody would be who knows the rig but for its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.foreign_rigs.motion import STEP
from drill_twin_evidence.foreign_rigs.rigs import (
    DECAY,
    INDICATED,
    LOAD,
    LOADS,
    RANGES,
    SLIDING,
    STICKING,
    Rig,
    Trial,
    mechanics_of,
    sampled,
)
from drill_twin_studies.fitting import Sampling, sample
from drill_twin_studies.fitting.sampling import in_ranges

MEMBERS, ROUNDS = 32, 40
OWN_RANGES = {key: RANGES[key] for key in (STICKING, SLIDING, DECAY)} | {LOAD: LOADS}
"""Free numbers and their ranges [SI]."""
Likelihood = Callable[[Mapping[str, Array]], Array]
"""Runs by channel, shape (M, T) -> logarithm of their likelihood, shape (M,)."""


def own_fit(
    rig: Rig, channels: tuple[str, ...], likelihood: Likelihood, seed: int, step: float = STEP
) -> tuple[Array, Sampling]:
    """Draws of `OWN_RANGES`, shape (N, 4), and their weights, by the stepper of the foreign rigs."""
    draws: list[Array] = []
    runs: dict[str, list[Array]] = {channel: [] for channel in channels}

    def evaluate(cube: Array) -> Array:
        draws.append(in_ranges(cube, OWN_RANGES))
        for row in draws[-1]:
            numbers = dict(zip(OWN_RANGES, row.tolist(), strict=True))
            columns = sampled(rig, mechanics_of(rig, numbers), numbers[LOAD] * INDICATED, step)[1]
            for channel in channels:
                runs[channel].append(columns[channel])
        return likelihood({channel: np.array(values) for channel, values in runs.items()})

    sampling = sample(evaluate, len(OWN_RANGES), members=MEMBERS, rounds=ROUNDS, effective=200, seed=seed)
    return np.concatenate(draws), sampling


def own_widths(rig: Rig, trial: Trial, noise: float = 0.01) -> dict[str, float]:
    """Widths of the 90 % bands by key [SI], of errors that are noise alone, of a known share of the largest value."""

    def likelihood(runs: Mapping[str, Array]) -> Array:
        total = np.zeros(())
        for channel, (_, values) in trial.record.series.items():
            error = noise * np.abs(values).max()
            total = total - 0.5 * np.sum((runs[channel][:, trial.present] - values) ** 2, axis=1) / error**2
        return total

    sampling = own_fit(rig, tuple(trial.record.series), likelihood, seed=1, step=1e-3)[1]
    low, high = in_ranges(sampling.intervals, OWN_RANGES)
    return dict(zip(OWN_RANGES, (high - low).tolist(), strict=True))
