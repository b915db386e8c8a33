# SPDX-License-Identifier: Apache-2.0
"""Search for sets that meet two published numbers at once, for each two of them, and for sets that meet most of all.

Each set is proposed for a goal: a pair of numbers, or the whole table. A proposal is a neighbour of the best set known
for the goal, or one drawn at random. Runs that cannot improve on the goal are not made. A generation depends on the
seed, its number and the generations before alone, so a search that was broken off and taken up again is the same, for
any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.core.files.json_files import JsonLines
from drill_twin_evidence.paper.runs.cases import Case, changed
from drill_twin_evidence.paper.runs.variants import VARIANTS
from drill_twin_evidence.paper.search.bench import Bench
from drill_twin_evidence.paper.search.goals import (
    ASSUMPTIONS,
    LOOSE,
    PAIRS,
    STRICT,
    Archive,
    Evaluated,
    Goal,
)  # fmt: skip
from drill_twin_evidence.paper.search.readings import NEAR, NUMBERS, Results
from drill_twin_evidence.paper.search.space import ParameterSet, mutated, random_set, set_of

ORDER = (
    Case(40.0, 2.0), Case(20.0, 2.0), Case(300.0, 2.0), Case(150.0, 2.0), Case(40.0, 6.0), Case(40.0, 1.0),
    Case(40.0, 4.0), Case(40.0, 3.0), Case(40.0, 6.5),
)  # fmt: skip
"""Runs of the whole table; those that decide most come first."""
TOGETHER = 32
"""Sets that are run in a generation."""
AT_RANDOM = 0.1
"""Share of the proposals that are drawn at random."""
WHOLE = 0.5
"""Share of the sets whose goal is the whole table."""
UNDER = (0.3, *(0.05 for _ in ASSUMPTIONS[1:-1]), 0.35)
"""Chance of each of the assumptions as those of a goal."""
Job = tuple[ParameterSet, Goal]


Record = JsonLines[list[Evaluated]]
"""Generations of a search."""


def open_record(file: Path, setup: dict[str, Any]) -> Record:
    """Open the record of a search, and read what it has, up to a line that is no generation.

    Args:
        file: The file; it need not exist.
        setup: All that the search depends on, in plain types.

    Raises:
        ArgumentError: It is of another search, or no record.
        BagError: It cannot be read or written.
    """
    remedy = "choose another with --record"
    return JsonLines(file, list[Evaluated], "paper search", setup, remedy=remedy, ordered=True)


def evaluated(record: Record) -> list[Evaluated]:
    """All sets of a record, in order."""
    return [one for generation in record.results for one in generation]


def search(
    bench: Bench, record: Record, *, sets: int, seed: int, progress: Callable[[int], None] = lambda _: None
) -> Archive:
    """Search until a number of sets has been evaluated, on from what the record has.

    Args:
        bench: The bench that the sets are evaluated on.
        record: Takes the generations.
        sets: Number of sets.
        seed: Seed of the search.
        progress: Called with the number of sets evaluated.

    Raises:
        BagError: The record cannot be written.
    """
    archive = Archive()
    for one in evaluated(record):
        archive.add(one)
    while (done := len(evaluated(record))) < sets:
        number = len(record.results)
        random = np.random.default_rng((seed, number))
        jobs = _proposals(bench, archive, random) if number else _first(bench, random)
        record.add(_evaluate(bench, archive, jobs))
        for one in record.results[-1]:
            archive.add(one)
        progress(done + len(record.results[-1]))
    return archive


def _evaluate(bench: Bench, archive: Archive, jobs: list[Job]) -> list[Evaluated]:
    """Runs of all sets in rounds: the next of a set only if it may still improve on its goal."""
    left = [
        list(ORDER) if goal.pair is None else list(dict.fromkeys(NUMBERS[k].case for k in goal.pair))
        for _, goal in jobs
    ]
    found: list[Results] = [{} for _ in jobs]
    while going := [
        k for k, (_, goal) in enumerate(jobs) if left[k] and (not found[k] or archive.promising(goal, found[k]))
    ]:
        wanted = [(jobs[k][0], left[k].pop(0)) for k in going]
        for k, (_, case), readings in zip(going, wanted, bench.run(wanted), strict=True):
            found[k][case] = readings
    return [
        Evaluated(list(one.fractions), list(one.choices), list(results.values()))
        for (one, _), results in zip(jobs, found, strict=True)
    ]


def _first(bench: Bench, random: np.random.Generator) -> list[Job]:
    """First generation: the bench, its variants, and sets drawn at random."""
    known = []
    for variant in VARIANTS:
        scene = bench.scene
        for place, value in variant.changes.items():
            scene = changed(scene, place, value)
        known.append(set_of(scene, joined=bench.joined))
    drawn = (random_set(random, joined=bench.joined) for _ in range(TOGETHER - len(known)))
    return [(one, Goal(None, LOOSE)) for one in (*known, *drawn)]


def _goal(archive: Archive, random: np.random.Generator) -> Goal:
    """Draw a goal; a pair not yet met is 20 times as likely as one that is."""
    if random.random() < WHOLE:
        return Goal(None, STRICT if random.random() < 0.3 else LOOSE)
    under = int(random.choice(len(ASSUMPTIONS), p=UNDER))
    chances = np.array([1.0 if archive.least[under][pair] > NEAR else 0.05 for pair in PAIRS])
    return Goal(PAIRS[int(random.choice(len(PAIRS), p=chances / chances.sum()))], under)


def _proposals(bench: Bench, archive: Archive, random: np.random.Generator) -> list[Job]:
    """Sets to run, each with its goal: neighbours of the best known for it, or drawn at random."""
    jobs = list[Job]()
    for _ in range(TOGETHER):
        goal = _goal(archive, random)
        known, elite = archive.best.get((goal.under, *goal.pair)) if goal.pair else None, archive.elite_of(goal)
        if known is None and elite:  # one of the best for the whole table, the better the likelier
            known = elite[min(int(random.geometric(0.2)) - 1, len(elite) - 1)][2]
        if known is None or random.random() < AT_RANDOM:
            one = random_set(random, joined=bench.joined)
        else:
            one = mutated(random, known, elite[int(random.integers(len(elite)))][2] if elite else known)
        jobs.append((ASSUMPTIONS[goal.under].applied(one), goal))
    return jobs
