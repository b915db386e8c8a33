# SPDX-License-Identifier: Apache-2.0
"""Result of a fit: draws, intervals, correlations, what the record does not determine, the fitted scene, its figure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.errors import import_extra
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.scene.overrides import full_key
from drill_twin.scene.schema import unit_at
from drill_twin_studies.fitting.likelihood import features_goodness, noise_in
from drill_twin_studies.fitting.record import Record
from drill_twin_studies.fitting.sampling import Sampling, in_ranges, weighted_quantile
from drill_twin_studies.goodness import Goodness, correlation_limit, goodness, limit_of_samples, sentence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNDETERMINED = 0.6
"""Width of a 90 % interval over the width of the range, above which the record does not determine a number."""
AT_AN_END = 0.25
"""Probability in the last `END` of a range, from which a number is at an end of its range: five times the prior's."""
AT_REST = tuple(f"effects.bit_torque_stribeck.{name}" for name in ("sticking", "decay", "exponent"))
"""Numbers of how friction falls from its value at rest. A record tells what happens once the bit has gained speed, and
another law near rest explains it as well with other numbers (docs/drill_twin_studies/fit.md)."""
HELD = (
    "low and high hold less often than the 90 % for which they are made: of 300 twins with hidden numbers they held "
    "255 (decay of friction) to 281 (load); near the ends of a range 43 of 62 (decay)"
)
"""Counts of `make fit-coverage` (evidence/docs/fit.md), of a model that is right; the least of both ways to measure."""
CORRELATED = 0.9
"""Correlation above which only a combination of two numbers is determined."""


@dataclass(frozen=True, repr=False)
class Posterior:
    """Weighted draws of the free numbers and the runs behind them.

    Attributes:
        scene: The scene.
        ranges: Lowest and highest value [SI] by key; the prior is uniform between.
        values: Draws [SI], shape (N, d), in the order of `ranges`.
        sampling: Weights of the draws and likelihoods.
        record: What was fitted to.
        time: Times of the samples that were compared [s], shape (T,).
        measured: The record at these times, by channel, shape (T,).
        runs: The runs by channel, shape (N, T).
        failed: Number of runs that could not be followed to the end.
        window: Length of the windows whose features were compared [s]; None: the series was.
    """

    scene: Scene
    ranges: Mapping[str, tuple[float, float]]
    values: Array
    sampling: Sampling
    record: Record
    time: Array
    measured: Mapping[str, Array]
    runs: Mapping[str, Array]
    failed: int
    window: float | None = None

    def __repr__(self) -> str:
        """One line: scene, runs, and the 90 % interval of each number [SI]."""
        numbers = (f"{key} {low:.4g}..{high:.4g}" for key, (low, high) in self.intervals.items())
        doubt = ", the model does not explain the record" if self.unexplained else ""
        return f"<Posterior of {self.scene.name}: {len(self.values)} runs, {', '.join(numbers)}{doubt}>"

    @property
    def keys(self) -> list[str]:
        """Keys of the free numbers."""
        return list(self.ranges)

    @cached_property
    def best(self) -> dict[str, float]:
        """Numbers of the run with the highest likelihood, by key."""
        return dict(zip(self.keys, self.values[self.best_run].tolist(), strict=True))

    @property
    def best_run(self) -> int:
        """Number of the run with the highest likelihood."""
        return int(np.argmax(self.sampling.log_likelihood))

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Ends of the 90 % interval of each number [SI] by key."""
        low, high = in_ranges(self.sampling.intervals, self.ranges).tolist()
        return {key: (first, last) for key, first, last in zip(self.keys, low, high, strict=True)}

    def median(self, key: str) -> float:
        """Median of a number [SI]."""
        return float(weighted_quantile(self.values[:, self.keys.index(key)], self.sampling.weights, 0.5))

    @cached_property
    def correlation(self) -> Array:
        """Correlation of the numbers, shape (d, d)."""
        weights = self.sampling.weights
        spread = self.values - weights @ self.values
        covariance = (spread.T * weights) @ spread
        size = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
        return np.asarray(covariance / np.outer(size, size))

    @cached_property
    def undetermined(self) -> list[str]:
        """Sentences: numbers, or differences of numbers, that the record does not determine."""
        told = []
        low, high = self.sampling.intervals
        for key, share in zip(self.keys, high - low, strict=True):
            if share > UNDETERMINED:
                told.append(f"{key}: the 90 % interval covers {share:.0%} of its range")
        for key, low_end, high_end in zip(self.keys, *self.sampling.at_ends, strict=True):
            if max(low_end, high_end) > AT_AN_END:
                end = "lower" if low_end > high_end else "upper"
                told.append(f"{key}: at the {end} end of its range; if the truth lies beyond, other numbers err too")
        for i, first in enumerate(self.keys):
            for j, second in enumerate(self.keys[:i]):
                if abs(self.correlation[i, j]) > CORRELATED:
                    told.append(
                        f"{second} and {first}: one combination only (correlation {self.correlation[i, j]:+.2f})"
                    )
        return told

    @property
    def of_law(self) -> list[str]:
        """Sentences on the numbers that hold for the scene's law of friction only."""
        return of_law(self.keys, self.scene)

    def residual(self, channel: str) -> Array:
        """Measured less computed by the best run, shape (T,); NaN where the record has no sample."""
        return np.asarray(self.measured[channel] - self.runs[channel][self.best_run])

    @cached_property
    def goodness(self) -> dict[str, Goodness]:
        """Goodness of the best run by channel, against noise alone: draws that an error of the model widens hide it.

        Where features were compared, they are judged: the phase of the series is not determined.
        """
        if self.window is not None:
            best = {channel: values[self.best_run] for channel, values in self.runs.items()}
            return features_goodness(self.measured, best, float(self.time[1] - self.time[0]), self.window)
        found = {}
        for channel, values in self.runs.items():
            measured = self.measured[channel]
            noise, count = noise_in(measured, self.residual(channel)), int(np.isfinite(measured).sum())
            limits = limit_of_samples(count), correlation_limit(count)
            found[channel] = goodness(measured, values[self.best_run], 0.0, noise, noise, *limits)
        return found

    @property
    def unexplained(self) -> str:
        """Sentence on the channels that the model does not explain; empty if it explains all."""
        return sentence(self.goodness)

    def band(self, channel: str, share: float = 0.9) -> tuple[Array, Array]:
        """Band of a channel that holds a share of the draws, error of the model included, each of shape (T,)."""
        error = float(np.nanstd(self.residual(channel)))
        return predictive_band(self.runs[channel], self.sampling.weights, error, share)

    @property
    def draws(self) -> Array:
        """Draws of equal weight [SI], shape (2000, d), drawn from `values` by their weights: many are repeated."""
        return np.asarray(self.values[resampled(self.sampling.weights)[0]])

    def plot_corner(self) -> Figure:
        """Histogram of the draws of each number, and below it a dot for each pair of numbers of a draw."""
        from drill_twin.report.figures.style import BLUE, laid_out, styled

        keys, draws = self.keys, self.draws
        with styled():
            figure = laid_out(1.0 + 2.4 * len(keys), f"{self.scene.name}: draws of the numbers, in SI")
            for (k, j), panel in np.ndenumerate(figure.subplots(len(keys), len(keys), sharex="col", squeeze=False)):
                panel.set(visible=j <= k, xlabel=keys[j] * (k == len(keys) - 1), ylabel=keys[k] * (j == 0 < k))
                if j == k:
                    panel.hist(draws[:, k], 20, color=BLUE)
                else:
                    panel.plot(draws[:, j], draws[:, k], ".", color=BLUE, markersize=2, alpha=0.3)
        return figure

    def to_inferencedata(self) -> Any:
        """Draws of equal weight [SI] as groups `posterior` and `observed_data` of a DataTree, which ArviZ reads.

        Draws are of one chain and repeated, so that the effective sample size of ArviZ does not hold: it is
        `sampling.effective`.

        Raises:
            ArgumentError: arviz_base is not installed.
        """
        posterior = {key: column[None] for key, column in zip(self.keys, self.draws.T, strict=True)}
        groups = {"posterior": posterior, "observed_data": dict(self.measured)}
        dims = {channel: ["time"] for channel in self.measured}
        return import_extra("arviz_base").from_dict(groups, coords={"time": self.time}, dims=dims)

    def scene_text(self, base: str | None = None) -> str:
        """YAML of the fitted scene: the differences from a scene, by default the fit's scene, by its name."""
        from drill_twin.scene.lines import yaml_text

        fitted = self.scene_of(self.best).model_dump(mode="json", exclude_none=True)
        source = self.record.source.rpartition("/")[2]
        data: dict[str, Any] = {"name": f"{self.scene.name}_fitted", "base": base or self.scene.name,
                                "description": f"{self.scene.name} fitted to {source}"}  # fmt: skip
        for key in self.best:
            place, value = data, fitted
            for part in (path := full_key(key, self.scene).split("."))[:-1]:
                value = value[part]
                if isinstance(value, list):  # a list stands in full
                    place[part] = value
                    break
                place = place.setdefault(part, {})
            else:
                place[path[-1]] = value[path[-1]]
        return yaml_text(data)

    def scene_of(self, values: Mapping[str, float]) -> Scene:
        """The scene with other values of the free numbers [SI]."""
        return override(self.scene, {full_key(key, self.scene): value for key, value in values.items()})

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "scene": self.scene.name,
            "record": self.record.source.rpartition("/")[2],
            "notes": [*self.record.notes],
            "runs": len(self.values),
            "failed": self.failed,
            "effective_draws": round(self.sampling.effective, 1),
            "likelihood_power": self.sampling.power,
            "numbers": {
                key: {"best": self.best[key], "median": self.median(key),
                      "low": self.intervals[key][0], "high": self.intervals[key][1], "range": list(span)}
                for key, span in self.ranges.items()
            },
            "correlation": self.correlation.round(3).tolist(),
            "undetermined": self.undetermined,
            "of_law": self.of_law,
            "unexplained": self.unexplained,
            "goodness": {channel: one.to_dict() for channel, one in self.goodness.items()},
        }  # fmt: skip


def resampled(weights: Array) -> tuple[NDArray[np.int64], np.random.Generator]:
    """Numbers of 2,000 runs, drawn by their weights, and the generator that drew them; the same in each call."""
    alive, generator = np.flatnonzero(weights > 1e-6 * weights.max()), np.random.default_rng(1)
    return generator.choice(alive, 2000, p=weights[alive] / weights[alive].sum()), generator


def predictive_band(runs: Array, weights: Array, error: float, share: float) -> tuple[Array, Array]:
    """Quantiles at each time of weighted runs, shape (N, T), widened by a Gaussian error of the model."""
    drawn, generator = resampled(weights)
    noisy = runs[drawn] + error * generator.standard_normal((drawn.size, 1))
    low, high = np.quantile(noisy, (0.5 - share / 2.0, 0.5 + share / 2.0), axis=0)
    return low, high


def of_law(keys: Iterable[str], scene: Scene) -> list[str]:
    """Sentences on the free numbers that hold for the scene's law of friction only."""
    return [
        f"{key}: holds for this law of friction only; a record does not tell how friction falls near rest"
        for key in keys
        if full_key(key, scene) in AT_REST
    ]


def shown_number(key: str, scene: Scene) -> tuple[float, str]:
    """Size of an SI number of a scene in the units of its reader, and their name; of a factor 1 and nothing."""
    return scene.unit_system.in_unit(unit_at(scene, full_key(key, scene)))
