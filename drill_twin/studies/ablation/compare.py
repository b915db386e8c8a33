# SPDX-License-Identifier: Apache-2.0
"""Comparison of two sets of runs: differences beyond the tolerance and beyond chance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from drill_twin.accuracy.trial import Trial

CONFIDENCE = 0.95
"""Confidence level of a significant difference."""
RELATIVE = ("onset_s", "whirl_frequency_hz")
"""Quantities whose tolerance is relative; the others are shares already."""
NAMES = {
    "onset_s": "onset",
    "whirl_frequency_hz": "whirl frequency",
    "mean_radius": "mean orbit radius",
    "contact_fraction": "contact fraction",
}
"""Quantities to compare, and their names in the tables."""


@dataclass(frozen=True)
class Quantity:
    """A quantity with and without a group of effects."""

    before: float | None
    """Mean with all effects; None where there is none, as the onset of a run that does not whirl."""
    after: float | None
    """Mean without the group."""
    noise: float
    """Standard error of the difference."""
    tolerances: float
    """The difference in tolerances; infinite if only one of the two exists."""
    matters: bool
    """True if the difference is beyond the tolerance and statistically significant."""


def differences(before: Sequence[Trial], after: Sequence[Trial], tolerance: float) -> dict[str, Quantity]:
    """Every quantity with and without a group of effects.

    Args:
        before: Runs with all effects.
        after: Runs without the group.
        tolerance: Smallest relevant difference, relative for times and frequencies, absolute for shares [-].
    """
    return {name: _quantity(_values(before, name), _values(after, name), tolerance, name in RELATIVE) for name in NAMES}


def worst(quantities: Mapping[str, Quantity]) -> float:
    """Largest difference in tolerances, of the significant ones if there are any."""
    sure = [quantity.tolerances for quantity in quantities.values() if quantity.matters]
    return max(sure or [quantity.tolerances for quantity in quantities.values()] or [0.0])


def _values(trials: Sequence[Trial], name: str) -> list[float]:
    values = [getattr(trial, name) for trial in trials]
    return [value for value in values if value is not None]


def _quantity(before: list[float], after: list[float], tolerance: float, relative: bool) -> Quantity:
    if not before or not after:
        differ = bool(before) != bool(after)
        first, second = _mean(before), _mean(after)
        return Quantity(first, second, noise=0.0, tolerances=math.inf if differ else 0.0, matters=differ)
    one, other = float(np.mean(before)), float(np.mean(after))
    noise = math.sqrt(_square_error(before) + _square_error(after))
    scale = tolerance * (abs(one) if relative else 1.0)
    difference = abs(other - one)
    return Quantity(
        one, other, noise, difference / max(scale, 1e-300), difference > max(scale, _chance_difference(before, after))
    )


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _chance_difference(before: list[float], after: list[float]) -> float:
    """Confidence limit of the difference of two means (Welch 1947); far above its standard error for few runs."""
    errors = (_square_error(before), _square_error(after))
    freedom = sum(e**2 / (len(runs) - 1) for e, runs in zip(errors, (before, after), strict=True) if e > 0.0)
    if freedom == 0.0:
        return 0.0
    return float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, sum(errors) ** 2 / freedom)) * math.sqrt(sum(errors))


def _square_error(values: list[float]) -> float:
    return float(np.var(values, ddof=1)) / len(values) if len(values) > 1 else 0.0
