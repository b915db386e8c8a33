# SPDX-License-Identifier: Apache-2.0
"""Record of a search: one line a generation, so that a search that was broken off goes on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drill_twin.errors import ArgumentError, BagError
from drill_twin.studies.paper.runs.cases import Case
from drill_twin.studies.paper.search.readings import READINGS, Readings, Results
from drill_twin.studies.paper.search.space import Trial


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
        """Open a record, and read what it has.

        Args:
            file: The file; it need not exist.
            setup: All that the search depends on, in plain types.

        Raises:
            ArgumentError: It is of another search, or no record.
            BagError: It cannot be read or written.
        """
        self.file, self.generations = file, list[Generation]()
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            text = file.read_bytes() if file.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]  # a line that was cut off is computed again
            lines = whole.decode("utf-8", "replace").splitlines()
            if lines:
                self._check(lines[0], setup)
                self._read(lines[1:])
            with file.open("ab") as stream:
                stream.truncate(len(whole))
                if not whole:
                    stream.write((json.dumps({"paper search": setup}) + "\n").encode())
        except OSError as error:
            raise self._not_writable(error) from error

    def _check(self, line: str, setup: dict[str, Any]) -> None:
        try:
            found = json.loads(line)["paper search"]
        except (ValueError, KeyError, TypeError):
            raise ArgumentError(
                f"{self.file}: expected the record of a search, found another file; choose another with --record"
            ) from None
        if other := [name for name, value in setup.items() if found.get(name) != json.loads(json.dumps(value))]:
            raise ArgumentError(
                f"{self.file}: expected a record of this search, found one of another {' and '.join(other)}; "
                "choose another with --record"
            )

    def _read(self, lines: list[str]) -> None:
        for number, line in enumerate(lines, 2):
            try:
                grown, sets = json.loads(line)
                self.generations.append(Generation(int(grown), tuple(_evaluated(row) for row in sets)))
            except (ValueError, TypeError, KeyError, IndexError) as error:
                raise ArgumentError(
                    f"{self.file}, line {number}: expected a generation of a search, found {line[:60]!r}; "
                    "remove the line and those after it"
                ) from error

    def add(self, generation: Generation) -> Generation:
        """Append a generation, and return it as the record has it, rounded.

        Raises:
            BagError: The file cannot be written.
        """
        rows = [[one.trial.shares, one.trial.choices, _runs(one.results)] for one in generation.evaluated]
        line = json.dumps([generation.grown, rows], separators=(",", ":"), allow_nan=True)
        try:
            with self.file.open("ab") as stream:
                stream.write(line.encode() + b"\n")
        except OSError as error:
            raise self._not_writable(error) from error
        self._read([line])
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

    def _not_writable(self, error: OSError) -> BagError:
        return BagError(
            f"{self.file}: expected a file for the record, found {error.strerror or error}; "
            "choose another with --record"
        )


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
