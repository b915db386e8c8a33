# SPDX-License-Identifier: Apache-2.0
"""Differences between runs: errors against the converged run, and what two sets of runs show beyond chance.

Before the onset of whirl paths are compared. After it the motion is chaotic, so that only statistics converge. Their
uncertainty is the spread of replicas, which differ by a small perturbation of the initial velocity.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy import stats

from drill_twin.core.arrays import Array, ComplexArray, number_or_none
from drill_twin.studies.accuracy.motion_run import Motion

SETTLED = 0.5
"""Share of the run after which statistics are taken."""


@dataclass(frozen=True)
class MotionErrors:
    """Differences from the converged run, all dimensionless; None where there is nothing to compare."""

    path: float | None
    """Largest distance of a mark's centre line from the converged one before the onset, over its largest radius."""
    onset: float | None
    """Relative error of the onset time."""
    frequency: float | None
    """Relative error of the whirl frequency."""
    radius: float
    """Error of the mean orbit radius, over the clearance."""
    contact: float
    """Error of the share of nodes at the wall."""
    hookload: float | None = None
    """Relative error of the mean hookload after half of the run."""
    torque: float | None = None
    """Relative error of the mean torque of the top drive after half of the run."""
    stick_slip: float | None = None
    """Relative error of the period of stick-slip."""

    @property
    def controlled(self) -> float:
        """The error that `accuracy` controls: the larger of path and onset error."""
        return max((value for value in (self.path, self.onset) if value is not None), default=0.0)


def statistics(motion: Motion) -> tuple[float, float]:
    """Mean orbit radius over the clearance and share of nodes at the wall, of the settled part [-]."""
    late = motion.time > SETTLED * motion.time[-1]
    radius = np.hypot(motion.centre[late, :, 0], motion.centre[late, :, 1]) / motion.clearance
    return float(radius.mean()), float(motion.contact[late].mean())


def compare(motion: Motion, reference: Motion) -> MotionErrors:
    """Errors of a run of the same scene with the same frames."""
    radius, contact = statistics(motion)
    true_radius, true_contact = statistics(reference)
    return MotionErrors(
        path=path_error(motion, reference),
        onset=_relative(motion.onset, reference.onset),
        frequency=_relative(motion.frequency, reference.frequency),
        radius=abs(radius - true_radius),
        contact=abs(contact - true_contact),
        hookload=_relative(*(_late_mean(one, one.hookload) for one in (motion, reference))),
        torque=_relative(*(_late_mean(one, one.torque) for one in (motion, reference))),
        stick_slip=_relative(motion.stick_slip_period, reference.stick_slip_period),
    )


def errors_before(motion: Motion, reference: Motion) -> tuple[float, float]:
    """Errors of path and onset time [-], of a run that may have ended before the converged one or after it."""
    end = min(float(motion.time[-1]), float(reference.time[-1]))
    path = path_error(motion.until(end), reference.until(end)) or 0.0
    return path, _relative(motion.onset, reference.onset) or 0.0


def _late_mean(motion: Motion, values: Array) -> float:
    """Mean of the settled part; nan where it is zero, as the torque without friction."""
    return float(values[motion.time > SETTLED * motion.time[-1]].mean()) or np.nan


def path_error(motion: Motion, reference: Motion) -> float | None:
    """Largest distance between two paths before the onset, over the largest radius there [-]; None without marks."""
    early = reference.time <= (reference.onset if np.isfinite(reference.onset) else np.inf)
    if not early.any() or reference.centre.shape[1] == 0:
        return None
    path, true = (run.centre[early, :, 0] + 1j * run.centre[early, :, 1] for run in (motion, reference))
    return largest_distance(path, true)


def largest_distance(path: ComplexArray, true: ComplexArray) -> float:
    """Largest distance between paths x + i y, shape (T, m), over the largest deflection of the true paths [-]."""
    largest = float(np.abs(true).max()) if true.size else 0.0
    return float(np.abs(path - true).max()) / largest if largest > 0.0 else 0.0


def spread(replicas: Sequence[Motion], reference: Motion) -> MotionErrors:
    """Root mean square of the errors of replicas of the converged run: smaller errors cannot be resolved."""
    found: dict[str, list[float]] = {}
    for replica in replicas:
        for name, error in asdict(compare(replica, reference)).items():
            if error is not None:
                found.setdefault(name, []).append(error)
    rms: dict[str, Any] = {"path": None, "onset": None, "frequency": None, "radius": 0.0, "contact": 0.0}
    return MotionErrors(**rms | {name: float(np.sqrt(np.mean(np.square(errors)))) for name, errors in found.items()})


def _relative(value: float, true: float) -> float | None:
    if np.isnan(true):
        return None if np.isnan(value) else 1.0
    return 1.0 if np.isnan(value) else abs(value - true) / abs(true)


@dataclass(frozen=True)
class Trial:
    """Scalar results of a run."""

    onset_s: float | None
    """Onset of whirl [s]; None if there was none."""
    whirl_frequency_hz: float | None
    """Dominant whirl after the onset, positive = forward [Hz]."""
    mean_radius: float
    """Orbit radius over the clearance, mean of marks and of the second half of the run [-]."""
    contact_fraction: float
    """Share of nodes at the wall, mean of the second half of the run [-]."""
    cost: float
    """Processor time of the physics per simulated second [s/s]."""
    iteration_cost: float
    """Processor time per Newton iteration and element [s]; independent of how many iterations the motion takes."""


def trial_of(motion: Motion) -> Trial:
    """Scalar results of a run."""
    return Trial(
        number_or_none(motion.onset),
        number_or_none(motion.frequency),
        *statistics(motion),
        motion.cost,
        motion.cost / (max(motion.iteration_rate, 1.0) * motion.elements),
    )


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
class AblationQuantity:
    """A quantity with and without a group of effects."""

    before: float | None
    """Mean with all effects, of the runs that have it; None where none has, as the onset of runs without whirl."""
    after: float | None
    """Mean without the group."""
    runs_before: int
    """Number of runs with all effects that have it."""
    runs_after: int
    """Number of runs without the group that have it."""
    noise: float
    """Standard error of the difference; NaN where a mean is of one run, or of none."""
    tolerances: float
    """The difference in tolerances; infinite if only one of the two exists."""
    matters: bool
    """True if the difference is beyond the tolerance and statistically significant, or the counts' difference is."""
    known: bool
    """False if so few runs could not have shown a difference."""


def differences(before: Sequence[Trial], after: Sequence[Trial], tolerance: float) -> dict[str, AblationQuantity]:
    """Every quantity with and without a group of effects.

    Args:
        before: Runs with all effects.
        after: Runs without the group.
        tolerance: Smallest relevant difference, relative for times and frequencies, absolute for shares [-].
    """
    sizes = len(before), len(after)
    return {
        name: _quantity((_values(before, name), _values(after, name)), sizes, tolerance, name in RELATIVE)
        for name in NAMES
    }


def worst(quantities: Mapping[str, AblationQuantity]) -> float:
    """Largest difference in tolerances, of the significant differences if there are any."""
    sure = [quantity.tolerances for quantity in quantities.values() if quantity.matters]
    return max(sure or [quantity.tolerances for quantity in quantities.values()] or [0.0])


def _values(trials: Sequence[Trial], name: str) -> list[float]:
    return [value for trial in trials if (value := getattr(trial, name)) is not None]


def _quantity(
    values: tuple[list[float], list[float]], sizes: tuple[int, int], tolerance: float, relative: bool
) -> AblationQuantity:
    """Means and counts, of the runs that have the quantity, with and without a group."""
    before, after = values
    means, counts = (_mean(before), _mean(after)), (len(before), len(after))
    (one, other), differ = means, counts[0] * sizes[1] != counts[1] * sizes[0]
    more_often = differ and _fisher(counts, sizes) < 1.0 - CONFIDENCE
    countable = not differ or _fisher((sizes[0], 0), sizes) < 1.0 - CONFIDENCE
    if one is None or other is None:
        return AblationQuantity(*means, *counts, math.nan, math.inf if differ else 0.0, more_often, countable)
    scale, difference = tolerance * (abs(one) if relative else 1.0), abs(other - one)
    measurable = min(counts) > 1
    noise = math.sqrt(_square_error(before) + _square_error(after)) if measurable else math.nan
    matters = more_often or (measurable and difference > max(scale, chance_difference(before, after)))
    known = matters or (measurable and countable)
    return AblationQuantity(one, other, *counts, noise, difference / max(scale, 1e-300), matters, known)


def _fisher(counts: tuple[int, int], sizes: tuple[int, int]) -> float:
    """Chance of counts that differ at least so much where none does (Fisher's exact test)."""
    return float(stats.fisher_exact([counts, (sizes[0] - counts[0], sizes[1] - counts[1])])[1])


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def chance_difference(before: list[float], after: list[float], confidence: float = CONFIDENCE) -> float:
    """Confidence limit of the difference of two means (Welch 1947); far above its standard error for few runs."""
    errors = (_square_error(before), _square_error(after))
    freedom = sum(e**2 / (len(runs) - 1) for e, runs in zip(errors, (before, after), strict=True) if e > 0.0)
    if freedom == 0.0:
        return 0.0
    return float(stats.t.ppf(0.5 + 0.5 * confidence, sum(errors) ** 2 / freedom)) * math.sqrt(sum(errors))


def _square_error(values: list[float]) -> float:
    return float(np.var(values, ddof=1)) / len(values)
