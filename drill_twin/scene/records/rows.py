# SPDX-License-Identifier: Apache-2.0
"""Rows of a record as numbers, for all kinds of text: LAS, WITSML, and the CSV file that is read here."""

from __future__ import annotations

import csv
import math
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drill_twin.core.errors import DrillTwinError, TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.scene.records.columns import Columns, date, from_first, null_values, number

LARGEST_FILE = 200_000_000
"""Bytes of a record."""
MOST_COLUMNS = 10_000
_LONGEST_CELL = 40  # characters, in a message


class RowError(DrillTwinError):
    """A row whose number of cells is not the number of columns."""


class Text(NamedTuple):
    """First cell of a column that is neither a number nor a date."""

    cell: str
    row: int
    """From 1."""

    def __str__(self) -> str:
        return f'"{self.cell}" in row {self.row}'


class RecordRows:
    """Rows as they are read; 8 bytes a cell.

    Attributes:
        count: Number of rows.
        texts: First text of each column that has one, by the place of the column.
    """

    def __init__(self, names: Sequence[str], delimiter: str) -> None:
        """Begin without rows.

        Args:
            names: Names of the columns.
            delimiter: One character; a blank: any number of blanks and tabs.
        """
        self._names, self._delimiter = names, delimiter
        self._numbers, self._dates = array("d"), set[int]()
        self.count, self.texts = 0, dict[int, Text]()

    def add(self, line: str) -> None:
        """Append a line; the first cell of a column that is not missing decides between numbers and ISO 8601 dates.

        Raises:
            RowError: The number of cells is not the number of columns.
        """
        cells = split(line, self._delimiter)
        if len(cells) != len(self._names):
            raise RowError(f"expected {len(self._names)} values as in the header, found {len(cells)}")
        self.count += 1
        if not self._dates and line.isascii() and "_" not in line:  # Python reads 1_0 and other scripts as numbers
            try:
                values = [*map(float, cells)]
            except ValueError:  # a missing value, a date or a text
                values = []
            if values:
                self._numbers.fromlist(values)
                return
        self._numbers.fromlist([self._value(k, cell.strip()) for k, cell in enumerate(cells)])

    def columns(self, path: Path, units: Mapping[str, str], null: str = "") -> Columns:
        """The columns; a number that is infinite, -999.25 or the null value is missing.

        Args:
            path: The file, for messages.
            units: Units by column.
            null: Number that stands for no value, as the file gives it; empty for none.

        Raises:
            TableError: The null value is no number, or a name is endless.
        """
        nulls, units = list(null_values(null, str(path))), dict(units)
        table, values = np.frombuffer(self._numbers).reshape(-1, len(self._names)), {}
        for k, name in enumerate(self._names):
            column = table[:, k]
            if k in self._dates:
                column, units[name] = from_first(column), "s"
            if k not in self.texts:
                missing = ~np.isfinite(column) | np.isin(column, nulls)
                values[name] = np.where(missing, math.nan, column) if missing.any() else column
        return Columns(path, values, units, {self._names[k]: str(text) for k, text in self.texts.items()})

    def _value(self, k: int, cell: str) -> float:
        """Value of a cell; NaN if it is missing or a text."""
        if k in self.texts:
            return math.nan
        decimal = cell if self._delimiter == "," else cell.replace(",", ".", 1)
        value = date(cell) if k in self._dates else number(decimal)
        if value is None and k not in self._dates and (value := date(cell)) is not None:
            if all(map(math.isnan, self._numbers[k :: len(self._names)])):
                self._dates.add(k)
            else:
                value = None
        if value is None:
            self.texts[k] = Text(cell[:_LONGEST_CELL], self.count)
            return math.nan
        return value


def split(line: str, delimiter: str) -> list[str]:
    """Cells of a line, which may be in double quotes, with blanks around.

    Raises:
        RowError: A cell in quotes is too long.
    """
    if '"' not in line:
        return line.split() if delimiter == " " else line.split(delimiter)
    try:
        return next(csv.reader([line.strip(" \r\n")], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error as error:
        raise RowError(f"expected cells in quotes, found {error}") from None


CSV = ForeignFile("a CSV file", LARGEST_FILE, TableError, may_be_empty=False)
_DELIMITERS = ",;\t|"


def read_csv(path: Path) -> Columns:
    """Read a CSV file.

    Raises:
        TableError: The file is no CSV file, or has a cell that is not a number (with its line).
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
        RowError: The line is no header.
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
