# SPDX-License-Identifier: Apache-2.0
"""Journal of a map: one line a run, so that a map that was broken off goes on."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from drill_twin.core.files.json_lines import JsonLines
from drill_twin.studies.maps.runs import Key, RunRecord

FOREIGN = "expected the runs of a map, found another file; choose another folder with --out"
OTHER = "expected runs of this map, found those of another {}; choose another folder with --out, or --replace"
"""Messages about the file of something else."""


class Journal:
    """File `runs.jsonl` of a folder: what the map is of, then its runs in the order in which they ended.

    Attributes:
        records: The runs that it has.
    """

    def __init__(self, file: Path, setup: Mapping[str, Any]) -> None:
        """Open the journal, and read what it has; a line that is no run is left out.

        Args:
            file: The file; it need not exist.
            setup: Scene, ranges and all else that the runs depend on, in plain types.

        Raises:
            ArgumentError: The journal is of another setup, or no journal.
            BagError: It cannot be read or written.
        """
        self.records = dict[Key, RunRecord]()
        self._lines = JsonLines(file, "map", setup, self._read, foreign=FOREIGN, other=OTHER, of=tuple[Key, RunRecord])

    def _read(self, run: tuple[Key, RunRecord]) -> None:
        self.records.update([run])

    def kept(self, runs: Generator[tuple[Key, RunRecord]]) -> Generator[tuple[Key, RunRecord]]:
        """The same runs, each appended as it ends.

        Raises:
            BagError: The file cannot be written.
        """
        with closing(runs):
            for key, record in runs:
                self._lines.add([key, record.to_dict()])
                self.records[key] = record
                yield key, record
