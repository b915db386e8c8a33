# SPDX-License-Identifier: Apache-2.0
"""Result of a search: which published numbers no set meets together, and which assumption excludes them."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.table import Table
from drill_twin_evidence.paper.runs.published import RATIO, Number
from drill_twin_evidence.paper.search.bench import Bench
from drill_twin_evidence.paper.search.goals import ASSUMPTIONS, LOOSE, PAIRS, STRICT, Archive, Evaluated
from drill_twin_evidence.paper.search.readings import (
    BASE,
    IRREGULAR,
    KINDS,
    NEAR,
    NUMBERS,
    Results,
    misfit,
    misfits,
    values_of,
)  # fmt: skip
from drill_twin_evidence.paper.search.space import CHOICES, ParameterSet

SHOWN = 3
"""Sets that are shown of those that meet most numbers."""


class Value(NamedTuple):
    """A number of a set."""

    number: Number
    ours: float
    """In the reading of the set [unit of the number]; NaN: none, or its run was not made."""
    misfit: float
    """In units of 20 %; NaN: its run was not made."""
    low: float = np.nan
    """Of an irregular whirl the least and the most precession of mark_2 over windows [unit of the number]."""
    high: float = np.nan


@dataclass(frozen=True)
class Finalist:
    """A set that meets many numbers.

    Attributes:
        parameters: The set.
        under: Name of the assumptions that it keeps to.
        met: How many numbers it meets.
        steady: How many of them are no line of an irregular whirl.
        readings: The reading of each kind of number in which that is so.
        values: Each number.
    """

    parameters: ParameterSet
    under: str
    met: int
    steady: int
    readings: dict[str, str]
    values: tuple[Value, ...]


@dataclass(frozen=True, eq=False)
class Exclusion:
    """Result of a search.

    Attributes:
        sets: Sets that were run.
        runs: Runs made.
        least: Least misfit of each two numbers under each of the assumptions, shape (assumptions, 15, 15); the
            diagonal is that of a number alone; infinite: nothing was run for it.
        finalists: Sets that meet most numbers, under all assumptions and under none.
    """

    sets: int
    runs: int
    least: Array
    finalists: tuple[Finalist, ...]

    def excluded(self, under: int) -> list[tuple[int, int]]:
        """Pairs that no set meets under some assumptions."""
        return [pair for pair in PAIRS if self.least[under][pair] > NEAR]

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        plain = [
            vars(one) | {"parameters": one.parameters.described()}
            | {"values": [value._asdict() | {"number": value.number.name} for value in one.values]}
            for one in self.finalists
        ]  # fmt: skip
        least = {assumptions.name: self.least[k].tolist() for k, assumptions in enumerate(ASSUMPTIONS)}
        return vars(self) | {"numbers": [one.name for one in NUMBERS], "least": least, "finalists": plain}

    def to_csv(self) -> str:
        """A row a pair: least misfit under each of the assumptions, in units of 20 %."""
        stream = StringIO()
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["first", "second", *(assumptions.name for assumptions in ASSUMPTIONS)])
        for i, j in PAIRS:
            table.writerow([NUMBERS[j].name, NUMBERS[i].name, *(f"{value:.3f}" for value in self.least[:, i, j])])
        return stream.getvalue()


def exclusion_of(evaluated: list[Evaluated], bench: Bench) -> Exclusion:
    """Result of the sets that were run."""
    archive = Archive()
    for one in evaluated:
        archive.add(one)
    loose, strict = (finalists_of(bench, evaluated, under) for under in (LOOSE, STRICT))
    known = {one.parameters for one in loose}
    return Exclusion(
        len(evaluated), sum(len(one.runs) for one in evaluated), archive.least,
        (*loose, *(one for one in strict if one.parameters not in known)),
    )  # fmt: skip


def finalists_of(bench: Bench, evaluated: list[Evaluated], under: int) -> list[Finalist]:
    """Sets that meet most numbers under some assumptions, the best first."""
    found = []
    for one in evaluated:
        if ASSUMPTIONS[under].hold(one.parameters):
            results = one.results
            met, readings = score(results, any_reading=ASSUMPTIONS[under].any_reading)
            values = [_value(results, number, readings[KINDS[number.what]]) for number in NUMBERS]
            steady = sum(value.misfit <= NEAR and not _irregular(results, value.number) for value in values)
            found.append((met, steady, one, readings, values))
    best = sorted(found, key=lambda item: (-item[0], -item[1]))[:SHOWN]
    return [
        Finalist(
            one.parameters, ASSUMPTIONS[under].name, met, steady, readings,
            tuple(_with_interval(bench, one, value) for value in values),
        )
        for met, steady, one, readings, values in best
    ]  # fmt: skip


def score(results: Results, *, any_reading: bool) -> tuple[int, dict[str, str]]:
    """Most numbers within 20 % in one reading of each kind, and these readings; at a tie those of `BASE`."""
    count, names = 0, dict(BASE)
    for kind in BASE:
        near = int((misfits(results, kind, any_reading=False) <= NEAR).sum())
        every = (misfits(results, kind, any_reading=True) <= NEAR).sum(axis=0)
        if any_reading and every.max() > near:
            near = int(every.max())
            of_kind = next(number for number in NUMBERS if KINDS[number.what] == kind and number.case in results)
            names[kind] = list(values_of(of_kind, results[of_kind.case]))[int(np.argmax(every))]
        count += near
    return count, names


def _value(results: Results, number: Number, reading: str) -> Value:
    if number.case not in results:
        return Value(number, np.nan, np.nan)
    ours = values_of(number, results[number.case])[reading]
    return Value(number, ours, float(misfit(number, np.array(ours))))


def _irregular(results: Results, number: Number) -> bool:
    """True where the whirl is irregular, so that one value of it is a matter of the window."""
    run = results.get(number.case)
    return KINDS[number.what] == "whirl" and run is not None and run.spread > IRREGULAR


def _with_interval(bench: Bench, one: Evaluated, value: Value) -> Value:
    """The value with the interval of an irregular whirl, by a run."""
    number = value.number
    (motion,) = bench.motions([(one.parameters, number.case)]) if _irregular(one.results, number) else (None,)
    if motion is None:
        return value
    rates = motion.window_rates()[:, 1] / (number.speed if number.what == RATIO else 1.0)
    return value._replace(low=float(rates.min()), high=float(rates.max()))


def lead(found: Exclusion) -> str:
    """Size of the search and its result."""
    best = max((one.met for one in found.finalists), default=0)
    return (
        f"{found.sets} sets by {found.runs} runs. At most {best} of {len(NUMBERS)} numbers within 20 % in one set. "
        "Misfits are in units of 20 %: a pair is met at 1, with the larger of its two."
    )


def tables(found: Exclusion) -> Iterator[Table]:
    """Tables of a search, as in `evidence/docs/paper_search.md`."""
    names, least = [f"{number.q} {number.name}" for number in NUMBERS], found.least
    counted = [(one.name, str(len(found.excluded(k))), str(len(PAIRS))) for k, one in enumerate(ASSUMPTIONS)]
    yield Table(("assumptions", "pairs excluded", "of"), counted, title="Pairs of numbers that no set meets")
    alone = [
        (name, number.shown(number.value), *(f"{least[under, k, k]:.2f}" for under in (STRICT, LOOSE)))
        for k, (name, number) in enumerate(zip(names, NUMBERS, strict=True))
    ]
    yield Table(("number", "published", "least misfit, all kept", "none kept"), alone, title="Each number")
    opened = []
    for i, j in sorted(found.excluded(STRICT), key=lambda pair: -least[LOOSE][pair]):
        by = [ASSUMPTIONS[k].name for k in range(1, LOOSE) if least[k, i, j] <= NEAR]
        opened.append((names[j], names[i], f"{least[STRICT, i, j]:.2f}", "; ".join(by), f"{least[LOOSE, i, j]:.2f}"))
    yield Table(
        ("number", "and", "all kept", "opened alone by", "none kept"),
        opened,
        title="Pairs excluded with all assumptions kept",
    )
    best = []
    for k, one in enumerate(found.finalists, 1):
        differing = [
            f"{choice.name} {choice.options[option]}"
            for choice, option in zip(CHOICES, one.parameters.choices, strict=True)
            if option
        ]
        best.append(
            (str(k), str(one.met), str(one.steady), one.under, "; ".join(one.readings.values()), "; ".join(differing))
        )
    yield Table(
        ("set", "met of 15", "in steady whirl", "assumptions", "readings", "choices that differ"),
        best,
        title="Sets that meet most numbers",
    )
    values = [
        (f"{number.q} {number.name}", number.shown(number.value), number.shown(ours), f"{off:.2f}",
         f"irregular: {low:.2g} to {high:.2g} over windows" if np.isfinite(low) else "")
        for number, ours, off, low, high in (found.finalists[0].values if found.finalists else ())
    ]  # fmt: skip
    yield Table(("number", "published", "set 1", "off by, in 20 %", ""), values, title="Numbers of set 1")
