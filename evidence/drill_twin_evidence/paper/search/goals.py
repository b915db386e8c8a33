# SPDX-License-Identifier: Apache-2.0
"""Goals of a search: two published numbers at once, or the whole table, under some of the assumptions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search.readings import BASE, NUMBERS, Readings, Results, misfits, of_kind
from drill_twin_evidence.paper.search.space import (
    BIT,
    CHOICES,
    HOLE,
    INCLINATION,
    LAW,
    LOAD_AT,
    LOAD_SHAPE,
    ROTATION_SHAPE,
    ParameterSet,
)  # fmt: skip


class Assumptions(NamedTuple):
    """Assumptions that may differ from the bench as calibrated and from the readings of `drill-twin study paper`."""

    name: str
    free: frozenset[int]
    """Choices that may differ."""
    any_reading: bool
    """True: each kind of number is read in the way that suits a set best, the same for all numbers of the kind."""

    def hold(self, one: ParameterSet) -> bool:
        """True if a set keeps to them."""
        return self.applied(one) == one

    def applied(self, one: ParameterSet) -> ParameterSet:
        """The set with the choices that must not differ set back."""
        return one._replace(choices=tuple(option if k in self.free else 0 for k, option in enumerate(one.choices)))


ASSUMPTIONS = (
    Assumptions("all kept", frozenset(), any_reading=False),
    Assumptions("R may be the diameter", frozenset({HOLE}), any_reading=False),
    Assumptions("the load may be counted at the top", frozenset({LOAD_AT}), any_reading=False),
    Assumptions("the hole may be inclined", frozenset({INCLINATION}), any_reading=False),
    Assumptions("the bit may be guided, or have play and a spring", frozenset({BIT}), any_reading=False),
    Assumptions("load and rotation may rise as a STEP", frozenset({LOAD_SHAPE, ROTATION_SHAPE}), any_reading=False),
    Assumptions("friction may fall to a share", frozenset({LAW}), any_reading=False),
    Assumptions("numbers may be read in any way", frozenset(), any_reading=True),
    Assumptions("none kept", frozenset(range(len(CHOICES))), any_reading=True),
)
STRICT, LOOSE = 0, len(ASSUMPTIONS) - 1
PAIRS = tuple((i, j) for i in range(len(NUMBERS)) for j in range(i))
ENOUGH = 2.0
"""Misfit beyond which a number counts no more in a total."""
ELITE = 30
"""Best sets for the whole table, of which neighbours are proposed."""
RUNS_OF_ALL = 9
"""Runs that the whole table needs."""


@dataclass(frozen=True)
class Evaluated:
    """A set and the runs made for it; a record has them as they are."""

    fractions: list[float]
    choices: list[int]
    runs: list[Readings]

    @property
    def parameters(self) -> ParameterSet:
        """The set."""
        return ParameterSet(tuple(self.fractions), tuple(self.choices))

    @property
    def results(self) -> Results:
        """Readings by run."""
        return {Case(run.weight_on_bit, run.speed): run for run in self.runs}


class Goal(NamedTuple):
    """Goal of a proposal: a pair of numbers, or the whole table, under some of the assumptions."""

    pair: tuple[int, int] | None
    under: int
    """Place in `ASSUMPTIONS`."""

    @property
    def any_reading(self) -> bool:
        """As of its assumptions."""
        return ASSUMPTIONS[self.under].any_reading


def pair_misfits(results: Results, *, any_reading: bool) -> Array:
    """Larger misfit of each two numbers, shape (15, 15); infinite where a run was not made.

    The diagonal is the misfit of a number alone.

    Args:
        results: Readings by run.
        any_reading: Take the least over the readings, both numbers of a kind read in one way.
    """
    parts = [
        ([NUMBERS.index(number) for number in of_kind(kind)], misfits(results, kind, any_reading=any_reading))
        for kind in BASE
    ]
    alone = np.full(len(NUMBERS), np.inf)
    for places, part in parts:
        alone[places] = part.min(axis=1)
    table = np.maximum(alone[:, None], alone[None])
    for places, part in parts:
        table[np.ix_(places, places)] = np.maximum(part[:, None], part[None]).min(axis=2)
    return np.asarray(table)


def total(results: Results, *, any_reading: bool) -> float:
    """Sum of the misfits, each at most `ENOUGH`, in one reading of each kind; a run not made counts nothing."""
    parts = (misfits(results, kind, any_reading=any_reading) for kind in BASE)
    return float(sum(np.where(np.isinf(part), 0.0, np.minimum(part, ENOUGH)).sum(axis=0).min() for part in parts))


class Archive:
    """Best sets known under each of the assumptions: for each pair of numbers, and for the whole table.

    Attributes:
        least: Least misfit of each pair, shape (assumptions, 15, 15).
        best: The set that has it.
        elite: Total, number and set of the best for the whole table, under all assumptions and under none.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.least = np.full((len(ASSUMPTIONS), len(NUMBERS), len(NUMBERS)), np.inf)
        self.best: dict[tuple[int, int, int], ParameterSet] = {}
        self.elite: dict[int, list[tuple[float, int, ParameterSet]]] = {STRICT: [], LOOSE: []}
        self._count = 0

    def add(self, one: Evaluated) -> None:
        """Take a set."""
        self._count += 1
        own, results = one.parameters, one.results
        tables = [pair_misfits(results, any_reading=any_reading) for any_reading in (False, True)]
        for under, assumptions in enumerate(ASSUMPTIONS):
            if not assumptions.hold(own):
                continue
            found = tables[assumptions.any_reading]
            for i, j in zip(*np.nonzero(found < self.least[under]), strict=True):
                self.best[under, int(i), int(j)] = own
            self.least[under] = np.minimum(self.least[under], found)
            if under in self.elite and len(results) == RUNS_OF_ALL:
                row = (total(results, any_reading=assumptions.any_reading), self._count, own)
                self.elite[under] = sorted((*self.elite[under], row))[:ELITE]

    def elite_of(self, goal: Goal) -> list[tuple[float, int, ParameterSet]]:
        """Best sets for the whole table, under the assumptions of a goal or under none."""
        return self.elite[goal.under if goal.under == STRICT else LOOSE]

    def promising(self, goal: Goal, results: Results) -> bool:
        """True if further runs of a set may still improve on its goal."""
        if goal.pair is None:
            elite = self.elite[goal.under]
            worst = elite[-1][0] if len(elite) == ELITE else ENOUGH * len(NUMBERS)
            return total(results, any_reading=goal.any_reading) < worst
        alone = np.diag(pair_misfits(results, any_reading=goal.any_reading))[list(goal.pair)]
        return bool((alone[np.isfinite(alone)] < self.least[goal.under][goal.pair]).all())
