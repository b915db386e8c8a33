# SPDX-License-Identifier: Apache-2.0
"""Fit of a rig with its own law: how wide the bands of somebody would be who knows the rig but for its numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.studies.fitting import sample
from drill_twin.studies.fitting.likelihood import noise_in
from drill_twin.studies.fitting.posterior import weighted_quantile
from drill_twin.studies.fitting.sampling import in_ranges
from drill_twin_evidence.foreign_rigs.motion import Mechanics
from drill_twin_evidence.foreign_rigs.rigs import (
    DECAY,
    INDICATED,
    LOAD,
    LOADS,
    RADIUS,
    RANGES,
    SLIDING,
    STICKING,
    Rig,
    Trial,
    sampled,
)

MEMBERS, ROUNDS = 32, 40


def own_widths(rig: Rig, trial: Trial) -> dict[str, float]:
    """Widths of the 90 % bands by key [SI], of errors that are noise alone."""
    ranges = {key: RANGES[key] for key in (STICKING, SLIDING, DECAY)} | {LOAD: LOADS}
    draws: list[Array] = []
    found: list[Array] = []

    def likelihood(cube: Array) -> Array:
        values = in_ranges(cube, ranges)
        draws.append(values)
        found.extend(_error(rig, trial, dict(zip(ranges, row.tolist(), strict=True))) for row in values)
        return -0.5 * np.array(found)

    sampling = sample(likelihood, len(ranges), members=MEMBERS, rounds=ROUNDS, effective=100, seed=1)
    values = np.concatenate(draws)
    low, high = (weighted_quantile(values, sampling.weights, share) for share in (0.05, 0.95))
    return dict(zip(ranges, (high - low).tolist(), strict=True))


def _error(rig: Rig, trial: Trial, numbers: Mapping[str, float]) -> Array:
    """Sum of the squared residuals over the noise of a run with other numbers."""
    weight = numbers[LOAD] * INDICATED
    plain: Mechanics = trial.mechanics
    sticking, sliding = (numbers[key] * RADIUS * weight for key in (STICKING, SLIDING))
    columns = sampled(rig, plain._replace(sticking=sticking, sliding=sliding, decay=numbers[DECAY]), weight)[1]
    total = np.zeros(())
    for name, (_, values) in trial.record.series.items():
        total += np.sum((values - columns[name][trial.present]) ** 2) / noise_in(values) ** 2
    return total
