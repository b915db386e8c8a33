# SPDX-License-Identifier: Apache-2.0
"""Search for sets that meet two published numbers at once, for each two of them, and for sets that meet most of all.

Each set is proposed for a goal: a pair of numbers, or the whole table. A proposal is a neighbour of the best set known
for the goal, or one drawn at random. Where the goal has a critical time, many are proposed, and growth along the ramps
(`growth`), a hundredth of the price of a run, rejects those whose critical times are farther off. Runs that cannot
improve on the goal are not made (`evaluate`). A generation depends on the seed, its number and the generations before
alone, so a search that was broken off and taken up again is the same, for any number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from drill_twin_evidence.paper.search.assumptions import (
    ASSUMPTIONS,
    ENOUGH,
    LOOSE,
    STRICT,
    pair_misfits,
    total,
)  # fmt: skip
from drill_twin_evidence.paper.search.evaluate import ORDER, TIMED, Bench, evaluate_pair, evaluate_whole
from drill_twin_evidence.paper.search.readings import BASE, NEAR, NUMBERS, Results
from drill_twin_evidence.paper.search.record import Evaluated, Generation, Record
from drill_twin_evidence.paper.search.space import Trial, known_trials, mutated, random_trial

TOGETHER = 32
"""Sets that are run in a generation."""
PROPOSED = 100
"""Sets proposed for one that is run, where growth can choose."""
SLACK = 0.3
"""Misfit of the critical times by which a proposal may be farther off than the set that it is a neighbour of."""
AT_RANDOM = 0.1
"""Share of the proposals that are drawn at random."""
WHOLE = 0.5
"""Share of the sets whose goal is the whole table."""
UNDER = (0.3, *(0.05 for _ in ASSUMPTIONS[1:-1]), 0.35)
"""Chance of each of the assumptions as those of a goal."""
ELITE = 30
"""Best sets for the whole table, of which neighbours are proposed."""
PAIRS = tuple((i, j) for i in range(len(NUMBERS)) for j in range(i))
_TIME_PLACES = tuple(NUMBERS.index(number) for number in TIMED)


class Goal(NamedTuple):
    """Goal of a proposal: a pair of numbers, or the whole table, under some of the assumptions."""

    pair: tuple[int, int] | None
    under: int
    """Place in `ASSUMPTIONS`."""

    @property
    def timed(self) -> list[int]:
        """Critical times that it has, by their place in `TIMED`."""
        return [k for k, place in enumerate(_TIME_PLACES) if self.pair is None or place in self.pair]


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
        self.best: dict[tuple[int, int, int], Trial] = {}
        self.elite: dict[int, list[tuple[float, int, Trial]]] = {STRICT: [], LOOSE: []}
        self._count = 0

    def add(self, one: Evaluated) -> None:
        """Take a set."""
        self._count += 1
        tables = [pair_misfits(one.results, any_reading=any_reading) for any_reading in (False, True)]
        for under, assumptions in enumerate(ASSUMPTIONS):
            if not assumptions.hold(one.trial):
                continue
            found = tables[assumptions.any_reading]
            for i, j in zip(*np.nonzero(found < self.least[under]), strict=True):
                self.best[under, int(i), int(j)] = one.trial
            self.least[under] = np.minimum(self.least[under], found)
            if under in self.elite and len(one.results) == len(ORDER):
                row = (total(one.results, any_reading=assumptions.any_reading), self._count, one.trial)
                self.elite[under] = sorted((*self.elite[under], row))[:ELITE]

    def worst(self, under: int) -> float:
        """Total from which a set is of no use."""
        elite = self.elite[under]
        return elite[-1][0] if len(elite) == ELITE else ENOUGH * len(NUMBERS)


def search(
    bench: Bench,
    record: Record,
    *,
    sets: int,
    seed: int,
    threads: int = 1,
    progress: Callable[[int, int, Archive], None] = lambda _done, _of, _archive: None,
) -> Archive:
    """Search until a number of sets has been evaluated, on from what the record has.

    Args:
        bench: What the sets are evaluated on.
        record: Takes the generations.
        sets: Number of sets.
        seed: Seed of the search.
        threads: Sets run at a time.
        progress: Called with the number of sets evaluated, the number wanted, and the archive.

    Raises:
        BagError: The record cannot be written.
    """
    archive = Archive()
    for one in record.evaluated:
        archive.add(one)
    with ThreadPoolExecutor(threads, "set") as pool:
        while record.sets < sets:
            number = len(record.generations)
            random = np.random.default_rng((seed, number))
            jobs, grown = _proposals(bench, archive, random) if number else (_first(bench, random), 0)
            results = list(pool.map(lambda job: Evaluated(job[0], _evaluate(bench, archive, *job)), jobs))
            generation = record.add(Generation(grown, tuple(results)))
            for one in generation.evaluated:
                archive.add(one)
            progress(record.sets, sets, archive)
    return archive


def _evaluate(bench: Bench, archive: Archive, one: Trial, goal: Goal) -> Results:
    any_reading = ASSUMPTIONS[goal.under].any_reading
    if goal.pair is None:
        return evaluate_whole(bench, one, archive.worst(goal.under), any_reading=any_reading)
    least = float(archive.least[goal.under][goal.pair])
    return evaluate_pair(bench, one, goal.pair, least, any_reading=any_reading)


def _first(bench: Bench, random: np.random.Generator) -> list[tuple[Trial, Goal]]:
    """First generation: the bench, its variants, and sets drawn at random."""
    known = known_trials(bench.scene, joined=bench.joined)
    drawn = (random_trial(random, joined=bench.joined) for _ in range(TOGETHER - len(known)))
    return [(one, Goal(None, LOOSE)) for one in (*known, *drawn)]


def _goal(archive: Archive, random: np.random.Generator) -> Goal:
    """A goal: of the pairs those that are not met, or not met with all assumptions kept, more often."""
    if random.random() < WHOLE:
        return Goal(None, STRICT if random.random() < 0.3 else LOOSE)
    under = int(random.choice(len(ASSUMPTIONS), p=UNDER))
    chances = np.array([1.0 if archive.least[under][pair] > NEAR else 0.05 for pair in PAIRS])
    return Goal(PAIRS[int(random.choice(len(PAIRS), p=chances / chances.sum()))], under)


def _proposals(bench: Bench, archive: Archive, random: np.random.Generator) -> tuple[list[tuple[Trial, Goal]], int]:
    """Sets to run, each with its goal, and the number of sets that growth chose them from."""
    jobs, grown = [], 0
    for _ in range(TOGETHER):
        goal = _goal(archive, random)
        parent = _parent(archive, goal, random)
        candidates = [_proposal(bench, archive, goal, parent, random) for _ in range(PROPOSED if goal.timed else 1)]
        off = np.array([_screened(bench, one, goal) if goal.timed else 0.0 for one in candidates])
        if goal.timed:
            grown += sum(map(bench.grows, candidates))
        least = _screened(bench, parent, goal) if parent is not None and goal.timed else 0.0
        passed = np.flatnonzero(off <= max(least + SLACK, float(off.min())))
        jobs.append((candidates[int(random.choice(passed))], goal))
    return jobs, grown


def _screened(bench: Bench, one: Trial, goal: Goal) -> float:
    """Misfit of a goal's critical times by growth; 0 where it says nothing."""
    found = bench.grown(one)
    if found is None:
        return 0.0
    rows = np.minimum(found[goal.timed], 2.0 * ENOUGH)
    if not ASSUMPTIONS[goal.under].any_reading:
        rows = rows[:, [BASE["time"]]]
    return float(rows.sum(axis=0).min())


def _elite(archive: Archive, goal: Goal) -> list[tuple[float, int, Trial]]:
    return archive.elite[goal.under if goal.under == STRICT else LOOSE]


def _parent(archive: Archive, goal: Goal, random: np.random.Generator) -> Trial | None:
    """Best set known for a goal; of those for the whole table one, the better the likelier."""
    known = archive.best.get((goal.under, *goal.pair)) if goal.pair else None
    elite = _elite(archive, goal)
    if known is None and elite:
        known = elite[min(int(random.geometric(0.2)) - 1, len(elite) - 1)][2]
    return known if random.random() >= AT_RANDOM else None


def _proposal(bench: Bench, archive: Archive, goal: Goal, parent: Trial | None, random: np.random.Generator) -> Trial:
    assumptions, elite = ASSUMPTIONS[goal.under], _elite(archive, goal)
    if parent is None:
        return assumptions.applied(random_trial(random, joined=bench.joined))
    other = elite[int(random.integers(len(elite)))][2] if elite else parent
    return assumptions.applied(mutated(random, parent, other))
