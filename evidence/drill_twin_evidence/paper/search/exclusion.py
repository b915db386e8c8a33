# SPDX-License-Identifier: Apache-2.0
"""Result of a search: which published numbers no set meets together, and which assumption excludes them."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.runs.published import RATIO, Number
from drill_twin_evidence.paper.search.assumptions import ASSUMPTIONS, LOOSE, STRICT, Score, score
from drill_twin_evidence.paper.search.evaluate import TIMED, Bench
from drill_twin_evidence.paper.search.readings import (
    BASE,
    IRREGULAR,
    KINDS,
    NEAR,
    NUMBERS,
    READINGS,
    Results,
    misfit,
    values,
    window_rates,
)  # fmt: skip
from drill_twin_evidence.paper.search.record import Evaluated, Record
from drill_twin_evidence.paper.search.search import PAIRS, Archive
from drill_twin_evidence.paper.search.short_spectra import Short, short_spectra
from drill_twin_evidence.paper.search.space import BIT, CHOICES, LAW, PLAY, SHARE_LEFT, SPRING, Trial

SHOWN = 3
"""Sets that are shown of those that meet most numbers."""


class Value(NamedTuple):
    """A number of a set."""

    number: Number
    ours: float
    """In the reading of the set [unit of the number]; NaN: none, or its run was not made."""
    misfit: float
    """In units of 20 %; NaN: its run was not made."""
    spread: float
    """Range of the precession of mark_2 over windows of the last half, over its mean."""
    low: float = np.nan
    """Of an irregular whirl the least and the most precession of mark_2 over these windows [unit of the number]."""
    high: float = np.nan

    @property
    def irregular(self) -> bool:
        """True where the whirl is irregular, so that one value of it is a matter of the window."""
        return KINDS[self.number.what] == "whirl" and self.spread > IRREGULAR


@dataclass(frozen=True)
class Finalist:
    """A set that meets many numbers.

    Attributes:
        trial: The set.
        under: Assumptions that it keeps to, by their place in `ASSUMPTIONS`.
        score: What it meets.
        values: Each number.
        short: Readings of short spectra that give the two frequencies at high load.
    """

    trial: Trial
    under: int
    score: Score
    values: tuple[Value, ...]
    short: tuple[Short, ...] = ()

    @property
    def steady(self) -> int:
        """Count of the numbers that it meets and that are no line of an irregular whirl."""
        return sum(value.misfit <= NEAR and not value.irregular for value in self.values)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "under": ASSUMPTIONS[self.under].name, "met": self.score.met, "steady": self.steady,
            "readings": self.score.readings, "numbers": numbers_of(self.trial), "choices": choices_of(self.trial),
            "values": [
                {"number": one.number.name, "ours": one.ours, "misfit": one.misfit, "irregular": one.irregular,
                 "low": one.low, "high": one.high}
                for one in self.values
            ],
            "short_spectra": [one._asdict() for one in self.short],
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Exclusion:
    """Result of a search.

    Attributes:
        sets: Sets evaluated, by growth or by runs.
        grown: Sets whose critical times were computed by growth.
        run: Sets of which runs were made.
        runs: Runs made.
        least: Least misfit of each two numbers under each of the assumptions, shape (assumptions, 15, 15); the
            diagonal is that of a number alone; infinite: nothing was run for it.
        best: The set that has it.
        finalists: Sets that meet most numbers, under all assumptions and under none.
        growth_error: Error of critical times by growth against the same set's runs, median and 9th decile [-].
    """

    sets: int
    grown: int
    run: int
    runs: int
    least: Array
    best: dict[tuple[int, int, int], Trial]
    finalists: tuple[Finalist, ...]
    growth_error: tuple[float, float]

    def excluded(self, under: int) -> list[tuple[int, int]]:
        """Pairs that no set meets under some assumptions."""
        return [pair for pair in PAIRS if self.least[under][pair] > NEAR]

    def opened_by(self, pair: tuple[int, int]) -> list[int]:
        """Assumptions of which each, given up alone, lets a set meet a pair."""
        return [k for k in range(1, LOOSE) if self.least[k][pair] <= NEAR]

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "sets": self.sets, "grown": self.grown, "run": self.run, "runs": self.runs,
            "growth_error": list(self.growth_error),
            "numbers": [number.name for number in NUMBERS],
            "least_misfit": {
                assumptions.name: self.least[k].tolist() for k, assumptions in enumerate(ASSUMPTIONS)
            },
            "best_sets": [
                {"first": NUMBERS[j].name, "second": NUMBERS[i].name, "under": ASSUMPTIONS[k].name,
                 "misfit": float(self.least[k, i, j]), "numbers": numbers_of(one), "choices": choices_of(one)}
                for (k, i, j), one in sorted(self.best.items()) if i > j and k in (STRICT, LOOSE)
            ],
            "finalists": [one.to_dict() for one in self.finalists],
        }  # fmt: skip

    def to_csv(self) -> str:
        """A row a pair: least misfit under each of the assumptions, in units of 20 %."""
        stream = StringIO()
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["first", "second", *(assumptions.name for assumptions in ASSUMPTIONS)])
        for i, j in PAIRS:
            table.writerow([NUMBERS[j].name, NUMBERS[i].name, *(f"{value:.3f}" for value in self.least[:, i, j])])
        return stream.getvalue()


def exclusion_of(record: Record, bench: Bench) -> Exclusion:
    """Result of a record."""
    archive, evaluated = Archive(), list(record.evaluated)
    for one in evaluated:
        archive.add(one)
    loose, strict = (finalists_of(evaluated, under) for under in (LOOSE, STRICT))
    known = {one.trial for one in loose}
    finalists = tuple(examined(bench, one) for one in (*loose, *(one for one in strict if one.trial not in known)))
    return Exclusion(
        record.sets, record.grown, len(evaluated), sum(len(one.results) for one in evaluated),
        archive.least, archive.best, finalists, growth_error(bench, evaluated),
    )  # fmt: skip


def finalists_of(evaluated: list[Evaluated], under: int) -> list[Finalist]:
    """Sets that meet most numbers under some assumptions, the best first."""
    assumptions = ASSUMPTIONS[under]
    found = [
        (score(one.results, any_reading=assumptions.any_reading), one)
        for one in evaluated
        if assumptions.hold(one.trial)
    ]
    best = sorted(found, key=lambda item: -item[0].met)[: 10 * SHOWN]
    finalists = [Finalist(one.trial, under, near, values_of(one.results, near)) for near, one in best]
    return sorted(finalists, key=lambda one: (-one.score.met, -one.steady))[:SHOWN]


def values_of(results: Results, near: Score) -> tuple[Value, ...]:
    """Each number of a set in its readings."""
    found = []
    for number in NUMBERS:
        run, kind = results.get(Case(number.weight_on_bit, number.speed)), KINDS[number.what]
        if run is None:
            found.append(Value(number, np.nan, np.nan, np.nan))
        else:
            reading = READINGS[kind].index(near.readings[kind])
            found.append(
                Value(number, float(values(number, run)[reading]), float(misfit(number, run)[reading]), run.spread)
            )
    return tuple(found)


def examined(bench: Bench, one: Finalist) -> Finalist:
    """A finalist with the intervals of its irregular whirls and its readings of short spectra, by runs."""
    return replace(
        one,
        values=tuple(_interval(bench, one.trial, value) for value in one.values),
        short=tuple(short_spectra(bench, one.trial)),
    )


def _interval(bench: Bench, one: Trial, value: Value) -> Value:
    number = value.number
    motion = bench.motion(one, Case(number.weight_on_bit, number.speed)) if value.irregular else None
    if motion is None:
        return value
    rates = window_rates(motion)[:, 1] / (number.speed if number.what == RATIO else 1.0)
    return value._replace(low=float(rates.min()), high=float(rates.max()))


def growth_error(bench: Bench, evaluated: list[Evaluated]) -> tuple[float, float]:
    """Median and 9th decile of the error of critical times by growth against those of the runs [-]."""
    errors = []
    for one in evaluated:
        times = bench.grown_times(one.trial)
        for k, number in enumerate(TIMED):
            found = one.results.get(Case(number.weight_on_bit, number.speed))
            if times is not None and found is not None and np.isfinite(found.time[BASE["time"]]):
                error = abs(times[k, BASE["time"]] / found.time[BASE["time"]] - 1.0)
                errors.append(error if np.isfinite(error) else 1.0)
    return (float(np.quantile(errors, 0.5)), float(np.quantile(errors, 0.9))) if errors else (np.nan, np.nan)


def numbers_of(one: Trial) -> dict[str, str]:
    """Numbers of a set with their units; those that its choices do not use are left out."""
    unused = {"fall of friction with slip"} if one.joined else {SHARE_LEFT} if one.choices[LAW] == 0 else set()
    unused |= {PLAY, SPRING} if one.choices[BIT] != 2 else set()
    unused |= {"friction at the bit", "radius at which the bit rubs"} if one.choices[BIT] != 0 else set()
    return {
        parameter.name: f"{parameter.value(share) / parameter.scale:.3g} {parameter.unit}".rstrip()
        for parameter, share in zip(one.parameters, one.shares, strict=True)
        if parameter.name not in unused
    }


def choices_of(one: Trial) -> dict[str, str]:
    """Choices of a set in words."""
    return {choice.name: choice.options[option] for choice, option in zip(CHOICES, one.choices, strict=True)}
