# SPDX-License-Identifier: Apache-2.0
"""Journal of a map: one line a run, so that a map that was broken off goes on."""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from drill_twin.base.resumable import resume
from drill_twin.errors import ArgumentError, BagError
from drill_twin.maps.runs import Key, Record

TOGETHER = 32
"""Runs that are written at a time."""

FOREIGN = "expected the runs of a map, found another file; choose another folder with --out"
OTHER = "expected runs of this map, found those of another {}; choose another folder with --out, or --replace"
"""Messages about the file of something else."""


class Journal:
    """File `runs.jsonl` of a folder: what the map is of, then its runs in the order in which they ended.

    Attributes:
        records: The runs that it has.
    """

    def __init__(self, file: Path, setup: Mapping[str, Any]) -> None:
        """Open the journal, and read what it has.

        Args:
            file: The file; it need not exist.
            setup: Scene, ranges and all else that the runs depend on, in plain types.

        Raises:
            ArgumentError: The journal is of another setup, or no journal.
            BagError: It cannot be read or written.
        """
        self.file, self.records = file, dict[Key, Record]()
        try:
            resume(file, "map", setup, self._read, foreign=FOREIGN, other=OTHER)
        except OSError as error:
            raise _not_writable(file, error) from error

    def _read(self, lines: list[str]) -> None:
        for number, line in enumerate(lines, 2):
            try:
                (i, j, draw, origin), data = json.loads(line)
                key = Key(i, j, draw, None if origin is None else (origin[0], origin[1]))
                self.records[key] = Record.from_dict(data)
            except (ValueError, TypeError, KeyError) as error:
                raise ArgumentError(
                    f"{self.file}, line {number}: expected a run of a map, found {line[:60]!r}; remove the folder"
                ) from error

    def kept(self, runs: Generator[tuple[Key, Record]]) -> Generator[tuple[Key, Record]]:
        """The same runs, appended `TOGETHER` at a time, and where they end or are broken off.

        Raises:
            BagError: The file cannot be written.
        """
        new: dict[Key, Record] = {}
        with closing(runs):
            try:
                for key, record in runs:
                    new[key] = record
                    if len(new) == TOGETHER:
                        self.add(new)
                        new = {}
                    yield key, record
            finally:
                if new:
                    self.add(new)

    def add(self, records: Mapping[Key, Record]) -> None:
        """Append runs.

        Raises:
            BagError: The file cannot be written.
        """
        text = "".join(json.dumps([key, record.to_dict()]) + "\n" for key, record in records.items())
        try:
            with self.file.open("ab") as stream:
                stream.write(text.encode())
        except OSError as error:
            raise _not_writable(self.file, error) from error
        self.records |= records


def _not_writable(file: Path, error: OSError) -> BagError:
    return BagError(
        f"{file}: expected a place to keep the runs, found {error.strerror or error}; choose another with --out"
    )
