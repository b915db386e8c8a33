# SPDX-License-Identifier: Apache-2.0
"""Posterior of what the paper leaves open, from the numbers that do not exclude each other, with all assumptions kept.

Prior: each number of a set uniform between its bounds on its logarithmic scale. Likelihood: normal in the ratio of
computed to published, with the spread of `SPREAD` and the error of the surrogate. Critical times by growth along the
ramps, whirl numbers by radial basis functions through the runs of a search; sampled by emcee (Foreman-Mackey, Hogg,
Lang and Goodman 2013), whose walkers move by stretches along the lines between them; then some draws are run and
weighed by their likelihood, so that the surrogate's error does not shift the result.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator

from drill_twin.base.arrays import Array
from drill_twin.base.extras import import_emcee
from drill_twin.errors import ArgumentError
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.runs.published import Number
from drill_twin_evidence.paper.search.assumptions import ASSUMPTIONS, STRICT
from drill_twin_evidence.paper.search.evaluate import Bench, failed
from drill_twin_evidence.paper.search.growth import critical_times, start_of
from drill_twin_evidence.paper.search.readings import BASE, KINDS, LEVELS, NUMBERS, Results, values
from drill_twin_evidence.paper.search.record import Evaluated
from drill_twin_evidence.paper.search.space import CHOICES, FREE, NUMBER, PLAY, RADIUS, SHARE_LEFT, SPRING, Trial, trial

SPREAD = {"Q13": 0.1, "Q1": 0.1, "Q15": 0.1, "Q11": 0.1, "Q12": 0.2}
"""Standard deviation of the ratio of computed to published, by number; the others exclude each other."""
TIMED, WHIRLED = (
    tuple(one for one in NUMBERS if one.q in SPREAD and KINDS[one.what] == kind) for kind in ("time", "whirl")
)
ENOUGH = 40.0
"""Draws of equal weight from which an interval is given: two of them lie outside each limit of 5 %."""
SOUGHT = tuple(k for k, one in enumerate(FREE) if one.name not in (SHARE_LEFT, PLAY, SPRING))
"""Places in `FREE` of the numbers that a set with all assumptions kept uses."""
SLOW = tuple(NUMBER[name] for name in ("ramp of the load", "start of the load", "bow"))
"""Of these the ones that no longer matter to a whirl at the wall."""
FEWEST = 100
"""Runs for a number, below which its surrogate is worth nothing."""
SMOOTHING = 0.01
FOLDS = 10
OFF = 1.0
"""Largest difference of a ratio that counts."""
LATEST = 15.0
"""Time after which no critical time is sought [s]."""
ROUNDS, DRAWN = 4, 32
"""Times that draws of the posterior are run and taken into its model before the last sampling, and how many each time.

A search runs few sets where it has no goal, so a model through its runs alone misleads the walkers."""
WEIGHED = 200
"""Draws of the last sampling that are run and weighed."""


class Surrogate:
    """One whirl number over the numbers of a set, through the runs of a search.

    Attributes:
        number: The number.
        count: Runs that it goes through.
        error: Error of a run left out over the published number: median and 9th decile over the runs within 40 % of it.
    """

    def __init__(self, number: Number, evaluated: list[Evaluated]) -> None:
        """Fit it.

        Raises:
            ArgumentError: There are too few runs.
        """
        case = Case(number.weight_on_bit, number.speed)
        rows = [(one.trial.shares, _value(number, one.results)) for one in evaluated if case in one.results]
        rows = [(shares, value) for shares, value in rows if np.isfinite(value)]
        self.number, self.count = number, len(rows)
        if len(rows) < FEWEST:
            raise ArgumentError(
                f"--posterior: expected a record with {FEWEST} runs at {case} that keep all assumptions, "
                f"found {len(rows)}; search on with --sets"
            )
        places = self._columns(np.array([shares for shares, _ in rows]))
        ratio = np.clip([value / number.value for _, value in rows], 1.0 - 2.0 * OFF, 1.0 + 2.0 * OFF)
        fold = np.random.default_rng(0).integers(0, FOLDS, ratio.size)
        guess = np.empty_like(ratio)
        for k in range(FOLDS):
            guess[fold == k] = self._through(places[fold != k], ratio[fold != k])(places[fold == k])
        error = np.abs(guess - ratio)[np.abs(guess - 1.0) < 0.4]
        self.error = (float(np.quantile(error, 0.5)), float(np.quantile(error, 0.9))) if error.size else (OFF, OFF)
        self._fitted = self._through(places, ratio)

    def __call__(self, shares: Array) -> Array:
        """Ratio of computed to published at sets, shape (s, 14) to (s,)."""
        return np.asarray(self._fitted(self._columns(shares)))

    @staticmethod
    def _columns(shares: Array) -> Array:
        return np.asarray(shares[:, [k for k in SOUGHT if k not in SLOW]])

    @staticmethod
    def _through(places: Array, ratio: Array) -> RBFInterpolator:
        return RBFInterpolator(places, ratio, kernel="linear", smoothing=SMOOTHING)


class Likelihood:
    """Logarithm of the model's density of sets, all assumptions kept.

    Attributes:
        surrogates: Of the whirl numbers.
    """

    def __init__(self, bench: Bench, evaluated: list[Evaluated]) -> None:
        """Fit the surrogates to the sets of a record that keep all assumptions."""
        kept = [one for one in evaluated if ASSUMPTIONS[STRICT].hold(one.trial)]
        self._bench = bench
        self.surrogates = [Surrogate(number, kept) for number in WHIRLED]
        errors = [one.error[1] / 1.645 for one in self.surrogates]  # the 9th decile of a normal error
        self._spread = np.hypot([SPREAD[one.q] for one in (*TIMED, *WHIRLED)], [*(0.0 for _ in TIMED), *errors])

    @cached_property
    def _limit(self) -> Array:
        level = tuple(LEVELS.values())[BASE["time"] // 2]
        return np.array([-level * (RADIUS[0] - 0.5 * self._bench.scene.string.sections[0].outer_diameter)])

    def ratios(self, shares: Array) -> Array:
        """Computed over published of each of `TIMED` and `WHIRLED`, shape (s, 14) to (s, numbers)."""
        string = self._bench.strings[0, 0]
        times = np.array([[
            critical_times(string, start_of(one, number.weight_on_bit, number.speed), self._limit, LATEST)[0]
            for number in TIMED] for one in map(kept_trial, shares)])  # fmt: skip
        times = np.where(np.isfinite(times), times, LATEST) / [number.value for number in TIMED]
        return np.column_stack([times, *(surrogate(shares) for surrogate in self.surrogates)])

    def __call__(self, places: Array) -> Array:
        """Logarithm of the density at places in the unit cube, shape (s, sought) to (s,)."""
        result = np.full(len(places), -np.inf)
        inside = ((places >= 0.0) & (places <= 1.0)).all(axis=1)
        if inside.any():
            result[inside] = self.of(self.ratios(full(places[inside])))
        return result

    def of(self, ratios: Array) -> Array:
        """The same from the ratios, shape (s, numbers) to (s,)."""
        return _density(ratios, self._spread)


def _density(ratios: Array, spread: Array) -> Array:
    off = np.minimum(np.abs(np.nan_to_num(ratios, nan=np.inf) - 1.0), OFF)
    return np.asarray(-0.5 * ((off / spread) ** 2).sum(axis=1))


def full(places: Array) -> Array:
    """Shares of whole sets from those sought, shape (s, sought) to (s, 14)."""
    shares = np.full((len(places), len(FREE)), 0.5)
    shares[:, SOUGHT] = places
    return shares


def kept_trial(shares: Array) -> Trial:
    """The set with these shares and all assumptions kept."""
    return trial(shares, (0,) * len(CHOICES))


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior of what the paper leaves open.

    Attributes:
        shares: Draws of the numbers sought, each 0 to 1 of the way between its bounds, shape (n, sought).
        weights: Weight of each, shape (n,); their sum is 1.
        steps: Steps of each walker, the first third left out.
        autocorrelation: Longest autocorrelation time of a number [steps].
        surrogates: Of the whirl numbers.
        checked: Computed over published of the draws, by the model and by runs, shape (n, numbers, 2).
    """

    shares: Array
    weights: Array
    steps: int
    autocorrelation: float
    surrogates: list[Surrogate]
    checked: Array

    def interval(self, k: int) -> tuple[float, float, float]:
        """5 %, 50 % and 95 % of the number `SOUGHT[k]` [its unit]."""
        parameter = FREE[SOUGHT[k]]
        low, middle, high = (parameter.value(share) / parameter.scale for share in self._quantiles(k))
        return low, middle, high

    def width(self, k: int) -> float:
        """Width of its 90 % interval over that of its prior, on its logarithmic scale: 1: not determined."""
        low, _, high = self._quantiles(k)
        return (high - low) / 0.9

    @property
    def has_intervals(self) -> bool:
        """True if the draws are enough for limits of 5 % and 95 %; with fewer nothing is printed in their place."""
        return self.effective >= ENOUGH

    @property
    def effective(self) -> float:
        """Number of draws of equal weight that say as much."""
        return float(1.0 / (self.weights**2).sum())

    def _quantiles(self, k: int) -> tuple[float, ...]:
        order = np.argsort(self.shares[:, k])
        reached = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return tuple(float(np.interp(q, reached, self.shares[order, k])) for q in (0.05, 0.5, 0.95))

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "draws": len(self.shares), "effective": self.effective,
            "steps": self.steps, "autocorrelation": self.autocorrelation,
            "numbers": {} if not self.has_intervals else {
                FREE[place].name: {"low": one[0], "median": one[1], "high": one[2], "unit": FREE[place].unit,
                                   "width": self.width(k)}
                for k, place in enumerate(SOUGHT) for one in (self.interval(k),)
            },
            "surrogates": [
                {"number": one.number.name, "runs": one.count, "error": list(one.error)} for one in self.surrogates
            ],
            "checked": self.checked.tolist(),
        }  # fmt: skip


def sample(
    bench: Bench, evaluated: list[Evaluated], *, walkers: int, steps: int, seed: int, threads: int = 1
) -> Posterior:
    """Sample the posterior by its model, run draws and take them into the model, then run and weigh the last draws.

    The weight of a draw is its likelihood by its runs over that of the model (importance sampling), so what the model
    misses costs draws and does not shift the result.

    Args:
        bench: The bench of the search.
        evaluated: Sets of its record.
        walkers: Walkers, at least twice the numbers sought.
        steps: Steps of each.
        seed: Seed of the sampling.
        threads: Sets run at a time.

    Raises:
        ArgumentError: emcee is not installed, or the record has too few runs.
    """
    emcee, random = import_emcee(), np.random.default_rng(seed)
    known = [one for one in evaluated if ASSUMPTIONS[STRICT].hold(one.trial)]

    def walked(likelihood: Likelihood, count: int) -> Any:
        places = np.array([one.trial.shares for one in known])[:, SOUGHT]
        best = places[np.argsort(-likelihood(places))[:walkers]]
        start = np.clip(best + 0.01 * random.standard_normal(best.shape), 0.001, 0.999)
        sampler = emcee.EnsembleSampler(walkers, len(SOUGHT), likelihood, vectorize=True)
        sampler.random_state = np.random.RandomState(random.integers(2**31)).get_state()
        sampler.run_mcmc(start, count)
        return sampler

    def drawn(sampler: Any, count: int) -> list[Evaluated]:
        draws = sampler.get_chain(discard=sampler.iteration // 3, flat=True)
        picked = full(draws[random.integers(0, len(draws), count)])
        trials = [kept_trial(shares) for shares in picked]
        with ThreadPoolExecutor(threads, "set") as pool:
            return [Evaluated(*pair) for pair in zip(trials, pool.map(partial(_runs, bench), trials), strict=True)]

    for _ in range(ROUNDS):
        known += drawn(walked(Likelihood(bench, known), steps // 4), DRAWN)
    likelihood = Likelihood(bench, known)
    sampler = walked(likelihood, steps)
    weighed = drawn(sampler, WEIGHED)
    shares = np.array([one.trial.shares for one in weighed])
    model, run = likelihood.ratios(shares), np.array([_ratios(one.results) for one in weighed])
    excess = _density(run, np.array([SPREAD[one.q] for one in (*TIMED, *WHIRLED)])) - likelihood.of(model)
    weights = np.exp(excess - excess.max())
    return Posterior(
        shares[:, SOUGHT], weights / weights.sum(), steps, float(sampler.get_autocorr_time(tol=0).max()),
        likelihood.surrogates, np.stack([model, run], axis=2),
    )  # fmt: skip


def _runs(bench: Bench, one: Trial) -> Results:
    cases = dict.fromkeys(Case(number.weight_on_bit, number.speed) for number in (*TIMED, *WHIRLED))
    return {case: bench.run(one, case) or failed() for case in cases}


def _ratios(results: Results) -> list[float]:
    return [_value(number, results) / number.value for number in (*TIMED, *WHIRLED)]


def _value(number: Number, results: Results) -> float:
    found = results[Case(number.weight_on_bit, number.speed)]
    return float(values(number, found)[BASE[KINDS[number.what]]])
