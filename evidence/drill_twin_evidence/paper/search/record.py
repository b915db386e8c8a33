# SPDX-License-Identifier: Apache-2.0
"""Record of a search: one line a generation, so that a search that was broken off goes on."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.files.json_lines import JsonLines
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search.readings import READINGS, Readings, Results
from drill_twin_evidence.paper.search.space import Trial

FOREIGN = "expected the record of a search, found another file; choose another with --record"
OTHER = "expected a record of this search, found one of another {}; choose another with --record"
"""Messages about the file of something else."""


_Run = tuple[float, float, list[float], list[float], list[float], float]
"""Load, speed, then times, whirl and sizes as `Readings` has them, and the spread."""
_Line = tuple[int, list[tuple[list[float], list[int], list[_Run]]]]
"""Number of sets by growth; shares, choices and runs of each set."""


class Evaluated(NamedTuple):
    """A set and the runs made for it."""

    trial: Trial
    results: Results


class Generation(NamedTuple):
    """Sets evaluated at a time."""

    grown: int
    """Sets whose critical times were computed by growth."""
    evaluated: tuple[Evaluated, ...]
    """Sets that were run."""


class Record:
    """File of a search: what it searches, then its generations.

    Attributes:
        generations: The generations that it has.
    """

    def __init__(self, file: Path, setup: dict[str, Any]) -> None:
        """Open a record, and read what it has, up to a line that is no generation.

        Args:
            file: The file; it need not exist.
            setup: All that the search depends on, in plain types.

        Raises:
            ArgumentError: It is of another search, or no record.
            BagError: It cannot be read or written.
        """
        self.generations = list[Generation]()
        self._lines = JsonLines(
            file, "paper search", setup, self._read, foreign=FOREIGN, other=OTHER, of=_Line, ordered=True
        )

    def _read(self, line: Any) -> None:
        grown, sets = line
        self.generations.append(Generation(int(grown), tuple(_evaluated(row) for row in sets)))

    def add(self, generation: Generation) -> Generation:
        """Append a generation, and return it as the record has it, rounded.

        Raises:
            BagError: The file cannot be written.
        """
        rows = [[one.trial.shares, one.trial.choices, _runs(one.results)] for one in generation.evaluated]
        line = [generation.grown, rows]
        self._lines.add(line)
        self._read(line)
        return self.generations[-1]

    @property
    def evaluated(self) -> Iterator[Evaluated]:
        """All sets that were run, in order."""
        return (one for generation in self.generations for one in generation.evaluated)

    @property
    def grown(self) -> int:
        """Number of sets whose critical times were computed by growth."""
        return sum(generation.grown for generation in self.generations)

    @property
    def sets(self) -> int:
        """Number of sets that were evaluated in one way or the other."""
        return sum(max(generation.grown, len(generation.evaluated)) for generation in self.generations)


def _runs(results: Results) -> list[Any]:
    return [
        [case.weight_on_bit, case.speed, *(_rounded(values) for values in found[:3]), round(found.spread, 4)]
        for case, found in results.items()
    ]


def _rounded(values: np.ndarray) -> list[float]:
    return [float(f"{value:.4g}") for value in values.ravel()]


def _evaluated(row: list[Any]) -> Evaluated:
    shares, choices, runs = row
    results = {}
    for weight, speed, time, whirl, size, spread in runs:
        table = np.array(size, float).reshape(-1, len(READINGS["size"]))
        results[Case(weight, speed)] = Readings(np.array(time, float), np.array(whirl, float), table, float(spread))
    return Evaluated(Trial(tuple(shares), tuple(choices)), results)
