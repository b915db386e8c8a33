# SPDX-License-Identifier: Apache-2.0
"""CSV file with a header; columns of ISO 8601 dates become seconds from the first."""

from __future__ import annotations

import csv
import math
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TextIO

import numpy as np

from drill_twin.errors import TableError, encoding_problem
from drill_twin.schedule.reading.cells import date, from_first, number
from drill_twin.schedule.reading.columns import Columns
from drill_twin.schedule.reading.mnemonics import null_values

MOST_COLUMNS = 10_000
_LONGEST_LINE = 1_000_000  # characters
_DELIMITERS = ",;\t|"


def read_csv(path: Path) -> Columns:
    """Read a CSV file.

    Raises:
        TableError: It is none, or has a cell that is not a number (with its line).
    """
    try:
        with path.open(encoding="utf-8-sig") as stream:
            return _columns(path, _lines(path, stream))
    except UnicodeDecodeError as error:
        raise TableError(f"{path}: expected a CSV file in UTF-8, found {encoding_problem(error)}") from None
    except (OSError, csv.Error) as error:
        raise TableError(f"{path}: expected a CSV file in UTF-8, found {error}") from None


def _lines(path: Path, stream: TextIO) -> Iterator[str]:
    """Lines of a file; one that is endless is not read to its end.

    Raises:
        TableError: There is one.
    """
    place = 0
    while line := stream.readline(_LONGEST_LINE + 1):
        place += 1
        if len(line) > _LONGEST_LINE:
            raise TableError(
                f"{path}:{place}: expected a line of at most {_LONGEST_LINE} characters, found a longer one"
            )
        yield line


def _columns(path: Path, stream: Iterable[str]) -> Columns:
    rows = ((place, line) for place, line in enumerate(stream, 1) if line.strip() and not line.startswith("#"))
    begun, first = next(rows, (0, ""))
    delimiter = _delimiter(first)
    header = _cells(path, first, delimiter)
    if len(header) > MOST_COLUMNS:
        raise TableError(f"{path}:{begun}: expected at most {MOST_COLUMNS} columns, found {len(header)}")
    if header and all(_number(cell, delimiter) is not None for cell in header):
        raise TableError(f"{path}:{begun}: expected a header with column names, found numbers")
    if twice := sorted(name for name, count in Counter(header).items() if count > 1):
        raise TableError(f"{path}:{begun}: expected each column once, found {', '.join(twice)[:100]} again")
    numbers, nulls, dates = array("d"), null_values("", str(path)), set[str]()
    for line, text in rows:
        cells = _cells(path, text, delimiter)
        if len(cells) != len(header):
            raise TableError(f"{path}:{line}: expected {len(header)} values as in the header, found {len(cells)}")
        if not numbers:  # the first row tells which columns are dates
            dates = {name for name, cell in zip(header, cells, strict=True) if _number(cell, delimiter) is None}
        for name, cell in zip(header, cells, strict=True):
            value = date(cell) if name in dates else _number(cell, delimiter)
            if value is None:
                raise TableError(f'{path}:{line}: expected a number in column "{name[:40]}", found "{cell[:40]}"')
            numbers.append(math.nan if value in nulls else value)
    if not numbers:
        raise TableError(f"{path}: expected a header and rows of numbers, found {1 if begun else 0} lines")
    table = np.frombuffer(numbers).reshape(-1, len(header))
    values = {name: table[:, column].copy() for column, name in enumerate(header)}
    return Columns(path, values | {name: from_first(values[name]) for name in dates}, dict.fromkeys(dates, "s"))


def _cells(path: Path, line: str, delimiter: str) -> list[str]:
    if "\0" in line:
        raise TableError(f"{path}: expected a table of text, found binary data")
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def _delimiter(header: str) -> str:
    """Most frequent delimiter of the header; a space if there is no other."""
    best = max(_DELIMITERS, key=header.count)
    return best if header.count(best) else " "


def _number(cell: str, delimiter: str) -> float | None:
    """As `number`; decimal commas are read where the delimiter is another."""
    return number(cell.replace(",", ".") if delimiter != "," else cell)
