# SPDX-License-Identifier: Apache-2.0
"""Rows of a record as numbers, for all kinds of text: LAS, WITSML, and the CSV file that is read here."""

import csv
import math
import re
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drill_twin.core import numerals
from drill_twin.core.errors import DrillTwinError, TableError
from drill_twin.core.files.foreign_file import LONGEST_LINE, ForeignFile
from drill_twin.core.missing import WORDS
from drill_twin.core.units.parse import is_unit
from drill_twin.scene.records.channels import null_values
from drill_twin.scene.records.columns import Columns
from drill_twin.scene.records.times import Dates

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


_BETWEEN = r"[+-]?\d{{1,3}}([{0} '\u00a0\u202f])\d{{3}}(?:\1\d{{3}})*(?:{1}\d+)?"
_GROUPED = {mark: re.compile(_BETWEEN.format(other, re.escape(mark)), re.ASCII) for mark, other in (".,", ",.")}
"""Numbers with separators of thousands, by the decimal mark."""
_MARK = re.compile(
    r"[+-]?(?:(?:0|\d{4,}|)([.,])\d+|\d+([.,])(?!\d{3}$)\d+|\d{1,3}(?:[ .,']\d{3})+(?<!,)(?<!\.)([.,])\d+)", re.ASCII
)
"""Numbers that tell their decimal mark, other than 1,150 and 1.150."""
_HUNDREDS = re.compile(r"[1-9]\d\d", re.ASCII)
"""Numbers that a column of thousands, such as 1.150, has beside them, and a column of decimals hardly ever."""
_VALUE = re.compile(r"[+-]?[\d.,'\u00a0\u202f ]*\d(?:[.,]|[eE][+-]?\d+)?", re.ASCII)


class RecordRows:
    """Rows as they are read; 8 bytes a cell.

    Attributes:
        count: Number of rows.
        texts: First text of each column that has one, by the place of the column.
    """

    def __init__(self, names: Sequence[str], delimiter: str, mark: str = "") -> None:
        """Begin without rows.

        Args:
            names: Names of the columns; names that come again are numbered.
            delimiter: One character; a blank: any number of blanks and tabs.
            mark: Decimal mark of numbers that may have separators of thousands; empty: they have none, and a comma
                that is no delimiter is a decimal comma.
        """
        count, place = Counter(names), Counter[str]()
        for k, name in enumerate(names := list(names)):
            place[name] += 1
            names[k] = f"{name}:{place[name]}" if count[name] > 1 else name
        self.names, self._delimiter, self._mark = names, delimiter, mark
        self._numbers, self._dates = array("d"), dict[int, Dates]()
        self.count, self.texts = 0, dict[int, Text]()

    def add(self, line: str) -> None:
        """Append a line; the first cell of a column that is not missing decides between numbers, dates and text.

        Raises:
            RowError: The number of cells is not the number of columns.
        """
        cells = split(line, self._delimiter)
        if len(cells) == len(self.names) + 1 and not cells[-1].strip():  # rows that end with a delimiter
            cells.pop()
        if len(cells) != len(self.names):
            raise RowError(f"expected {len(self.names)} values as in the header, found {len(cells)}")
        self.count += 1
        comma = self._mark == ","
        if not self._dates and line.isascii() and "_" not in line and not (comma and "." in line):
            try:  # Python reads 1_0 and other scripts as numbers
                values = [float(cell.replace(",", ".")) for cell in cells] if comma else [*map(float, cells)]
            except ValueError:  # a missing value, a date or a text
                values = []
            if values:
                self._numbers.fromlist(values)
                return
        self._numbers.fromlist([self._value(k, cell.strip()) for k, cell in enumerate(cells)])

    def columns(self, path: Path, units: Mapping[str, str], null: str = "") -> Columns:
        """The columns.

        Args:
            path: The file, for messages.
            units: Units by column.
            null: Number that stands for no value, as the file gives it; empty for none.

        Raises:
            TableError: The null value is no number, or a name is endless.
        """
        table = np.frombuffer(self._numbers).reshape(-1, len(self.names))
        values = {name: table[:, k] for k, name in enumerate(self.names) if k not in self.texts}
        texts = {self.names[k]: str(text) for k, text in self.texts.items()}
        dates = {self.names[k]: found for k, found in self._dates.items() if k not in self.texts}
        return Columns(path, values, units, texts, null_values(null, str(path)), dates)

    def _value(self, k: int, cell: str) -> float:
        """Value of a cell; NaN if it is missing, a date or a text."""
        if k in self.texts:
            return math.nan
        missing = cell.lower() in WORDS
        if (dates := self._dates.get(k)) is None:
            if (value := math.nan if missing else self.number(cell)) is not None:
                return value
            if all(map(math.isnan, self._numbers[k :: len(self.names)])) and (first := Dates(self.count - 1)).add(cell):
                self._dates[k] = first
                return math.nan
        elif dates.add("" if missing else cell) or missing:
            return math.nan
        self.texts[k] = Text(cell[:_LONGEST_CELL], self.count)
        return math.nan

    def number(self, cell: str) -> float | None:
        """Number of a cell, which may have a decimal comma or separators of thousands; None if it is text."""
        if self._mark and (grouped := _GROUPED[self._mark].fullmatch(cell)):
            cell = cell.replace(grouped[1], "")
        if self._mark == "," or (not self._mark and self._delimiter != ","):
            cell = cell.replace(",", ".", 1)
        return numerals.number(cell)


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
_HEAD = 60
"""Lines among which header, units and decimal mark are looked for."""


def read_csv(path: Path) -> Columns:
    """Read a CSV file, with its preamble, its row of units, and the decimal mark that its cells tell.

    Raises:
        TableError: The file is no CSV file.
    """
    lines = used_lines(CSV, path, latin=True)
    head, size = list[tuple[int, str]](), 0
    for one in islice(lines, _HEAD):
        head.append(one)
        if (size := size + len(one[1])) > LONGEST_LINE:
            break
    place = head[0][0] if head else 0
    try:
        if not head:
            raise RowError("expected a header and rows of numbers, found none")
        begin, rows, units = _begin([line for _, line in head])
        header = head[begin - bool(units)][1]
        for place, line in chain(head[begin + 1 :], lines):  # noqa: B007  the place is told
            if line != header:
                rows.add(line)
    except RowError as error:
        raise TableError(f"{path}:{place}: {error}") from None
    if not rows.count:
        raise TableError(f"{path}: expected a header and rows of numbers, found {len(head)} lines")
    return rows.columns(path, dict(zip(rows.names, units, strict=False)))


def _begin(head: list[str]) -> tuple[int, RecordRows, list[str]]:
    """Place of the last line above the data, the rows to be filled, and the units, if that line has them.

    Raises:
        RowError: There is no header.
    """
    given = head[0].strip()[4:5] if head[0].lower().startswith("sep=") else ""
    place, delimiter = int(bool(given)), given or delimiter_of(head[0])
    tables, text = list[list[str]](), "".join(head)
    for other in given or [*sorted(_DELIMITERS, key=text.count, reverse=True), " "]:
        tables = [[cell.strip() for cell in split(line, other)] for line in head]
        block = next((k for k in range(len(head), 0, -1) if not _is_as_long(tables[k - 1], tables[-1])), 0)
        found = next((k for k in range(block, len(head)) if _is_data(tables[k])), 0)
        if len(tables[-1]) > 1 and found > block and not _is_data(tables[found - 1], strict=True):
            if any(_is_as_long(row, tables[-1]) and _is_data(row) for row in tables[:block]):
                raise RowError("expected one table, found a second header below rows; give each a file of its own")
            place, delimiter = found - 1, other
            break
    else:
        tables = [[cell.strip() for cell in split(line, delimiter)] for line in head]
    names = [cell.strip() for cell in split(head[place], delimiter)]
    if len(names) > MOST_COLUMNS:
        raise RowError(f"expected at most {MOST_COLUMNS} columns, found {len(names)}")
    units = list[str]()
    if place and len(tables[place - 1]) == len(tables[place]) and not _is_data(tables[place - 1], strict=True):
        told = [cell.strip("[]()") for cell in names if cell]
        if len(told) < 2 * sum(map(is_unit, told)) and len(told) <= sum(map(bool, tables[place - 1])):
            names, units = tables[place - 1], [cell.strip("[]()") for cell in names]
    if names and all(_VALUE.fullmatch(name) or name.lower() in WORDS for name in names):
        raise RowError("expected a header with column names, found numbers")
    columns = [*zip(*tables[place + 1 :], strict=False)]
    cells = [cell for column in columns for cell in column]
    marks = {one for cell in cells if (told_by := _MARK.fullmatch(cell)) for one in told_by.groups() if one}
    mixed = any(any(map(_GROUPED[","].fullmatch, one)) and any(map(_HUNDREDS.fullmatch, one)) for one in columns)
    either = (".", ",", "comma", delimiter not in ",;"), (",", ".", "point", delimiter == ";" or mixed)
    for mark, other, named, doubtful in either if not marks else ():
        odd = next((cell for cell in cells if other in cell and _GROUPED[mark].fullmatch(cell)), "")
        if doubtful and odd:
            raise RowError(
                f'expected a {named} that is of thousands or of decimals, found "{odd}", which may be either'
            )
    mark = marks.pop() if len(marks) == 1 else ""
    return place, RecordRows(names, delimiter, "." if delimiter == "," and mark != "," else mark), units


def _is_as_long(row: list[str], other: list[str]) -> bool:
    """True for rows of as many cells, where one may end with a delimiter."""
    return len(row) == len(other) or (abs(len(row) - len(other)) == 1 and not max(row, other, key=len)[-1])


def _is_data(cells: list[str], *, strict: bool = False) -> bool:
    """True for a row of which most cells are values or few are blank; where strict, for any row with a value."""
    told = [cell for cell in cells[:MOST_COLUMNS] if cell.lower() not in WORDS]
    values = sum(bool(_VALUE.fullmatch(cell)) or (len(cell) < _LONGEST_CELL and Dates(0).add(cell)) for cell in told)
    return values > (0 if strict or 2 * len(told) > len(cells) else len(told) - values)


def used_lines(kind: ForeignFile, path: Path, *, latin: bool = False) -> Iterator[tuple[int, str]]:
    """Lines of a table that are neither empty nor a comment, with their numbers."""
    return ((place, line) for place, line in kind.lines(path, latin=latin) if line.strip() and line[0] != "#")


def delimiter_of(header: str) -> str:
    """Most frequent delimiter of the header; a space if there is no other."""
    best = max(_DELIMITERS, key=header.count)
    return best if header.count(best) else " "
