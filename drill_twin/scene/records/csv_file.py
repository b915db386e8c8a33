# SPDX-License-Identifier: Apache-2.0
"""CSV file with a header; columns of ISO 8601 dates become seconds from the first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.scene.records.columns import Columns, number
from drill_twin.scene.records.rows import LARGEST_FILE, MOST_COLUMNS, RecordRows, RowError, split

CSV = ForeignFile("a CSV file", LARGEST_FILE, TableError, may_be_empty=False)
_DELIMITERS = ",;\t|"


def read_csv(path: Path) -> Columns:
    """Read a CSV file.

    Raises:
        TableError: It is none, or has a cell that is not a number (with its line).
    """
    lines = used_lines(CSV, path)
    place, header = next(lines, (0, ""))
    try:
        names, rows = _begin(header)
        for place, line in lines:  # noqa: B007  the place is told
            rows.add(line)
            if rows.texts:
                column, text = next(iter(rows.texts.items()))
                raise RowError(f'expected a number in column "{names[column][:40]}", found "{text.cell}"')
    except RowError as error:
        raise TableError(f"{path}:{place}: {error}") from None
    if not rows.count:
        raise TableError(f"{path}: expected a header and rows of numbers, found {1 if header else 0} lines")
    return rows.columns(path, {})


def _begin(header: str) -> tuple[list[str], RecordRows]:
    """Names of the columns, and their rows to be filled.

    Raises:
        RowError: The header is none.
    """
    delimiter = delimiter_of(header)
    names = [cell.strip() for cell in split(header, delimiter)]
    if len(names) > MOST_COLUMNS:
        raise RowError(f"expected at most {MOST_COLUMNS} columns, found {len(names)}")
    if names and all(number(name if delimiter == "," else name.replace(",", ".")) is not None for name in names):
        raise RowError("expected a header with column names, found numbers")
    if twice := sorted(name for name, count in Counter(names).items() if count > 1):
        raise RowError(f"expected each column once, found {', '.join(twice)[:100]} again")
    return names, RecordRows(names, delimiter)


def used_lines(kind: ForeignFile, path: Path) -> Iterator[tuple[int, str]]:
    """Lines of a table that are neither empty nor a comment, with their numbers."""
    return ((place, line) for place, line in kind.lines(path) if line.strip() and not line.startswith("#"))


def delimiter_of(header: str) -> str:
    """Most frequent delimiter of the header; a space if there is no other."""
    best = max(_DELIMITERS, key=header.count)
    return best if header.count(best) else " "
