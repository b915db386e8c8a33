# SPDX-License-Identifier: Apache-2.0
"""CSV tables of a well plan: columns by their headings, numbers with the units of one system; its options."""

import csv
import math
import re
from pathlib import Path
from typing import NamedTuple

from drill_twin.core.errors import SceneError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.units import UnitError, factor_of, parse
from drill_twin.core.units.dimension import ANGLE, LENGTH, LINEAR_MASS, Dimension
from drill_twin.core.units.parse import is_unit, name_and_unit, short, split, unit_here
from drill_twin.scene.records.rows import delimiter_of, used_lines

MOST_ROWS = 10_000
TABLE = ForeignFile("a CSV table", 4_000_000, SceneError)
UNITS = {
    "si": {"depth": "m", "diameter": "mm", "mass": "kg/m", "angle": "deg"},
    "field": {"depth": "ft", "diameter": "in", "mass": "lb/ft", "angle": "deg"},
    "": {"angle": "deg"},
}
"""Units of bare numbers, by system; where none is stated, only angles have one."""
DIMENSIONS: dict[str, Dimension] = {"depth": LENGTH, "diameter": LENGTH, "mass": LINEAR_MASS, "angle": ANGLE}
_DECIMAL_COMMA = re.compile(r"^(\s*[+-]?\d*),(\d+)(?=\s|$)", re.ASCII)
_BARE = re.compile(r"[+-]?\d+(?:\.\d*)?(?:\s+\d+/\d+|/\d+)?|[+-]?\.\d+", re.ASCII)


class Row(NamedTuple):
    """Row of a table: its cells by column, and how to read them."""

    place: str
    """File and number of the line, for messages."""
    cells: dict[str, str]
    units: dict[str, str]
    """Unit of a column from its heading."""
    system: str
    """`si`, `field`, or empty: not stated."""
    unread: tuple[str, ...] = ()
    """Headings that name none of the columns, or a column a second time."""

    def text(self, column: str) -> str:
        """Cell without spaces around; empty if the row has none, or a sign for none such as `-`."""
        text = self.cells.get(column, "").strip()
        return "" if text.lower() in {"-", "--", "n/a"} else text

    def in_unit(self, column: str, value: float, kind: str = "depth") -> str:
        """SI value as text in the unit of its column, for messages."""
        unit = self.units.get(column) or UNITS[self.system or "si"][kind]
        return f"{value / factor_of(unit, DIMENSIONS[kind]):.6g} {unit}"

    def number(self, column: str, kind: str) -> float:
        """Number of a cell in SI; NaN if it is empty.

        Args:
            column: Heading.
            kind: `depth`, `diameter`, `mass` or `angle`: what a number without a unit is in.

        Raises:
            SceneError: The cell is no such number, or has another unit than the column.
        """
        text = self.text(column)
        if not text:
            return math.nan
        unit = self.units.get(column) or UNITS[self.system].get(kind)
        bare = _BARE.fullmatch(text) is not None
        if unit is None and bare:
            raise SceneError(
                f'{self.place}, {column}: expected its unit, found none for "{text[:40]}"; name it in the heading, as '
                f"{column} [{UNITS['field'][kind]}], or give --units si ({UNITS['si'][kind]}) or --units field "
                f"({UNITS['field'][kind]})"
            )
        try:
            number, own = split(text, DIMENSIONS[kind])
            own = unit if bare and unit else unit_here(own)
            value = parse(f"{number!r} {own}", DIMENSIONS[kind])
        except UnitError as error:
            raise SceneError(f"{self.place}, {column}: {error}") from None
        if unit and own != unit:
            raise SceneError(
                f'{self.place}, {column}: expected a number in {unit} as in the rest of the column, found "{text}"; '
                "convert it, or name the unit of the whole column in its heading"
            )
        return value


def read_table(file: Path, names: dict[str, tuple[str, ...]], needed: tuple[str, ...], system: str) -> list[Row]:
    """Read a CSV table; columns are known by their heading, with a unit in brackets if any; # begins a
    comment. Where semicolons separate the cells, numbers may have a decimal comma.

    Args:
        file: The table.
        names: Accepted headings of each column, lower case.
        needed: Columns that must be there.
        system: `si` or `field`, or empty where columns must name their units.

    Raises:
        SceneError: The file cannot be read, or a column is missing.
    """
    lines = [(number, line.rstrip("\n")) for number, line in used_lines(TABLE, file) if line.strip(" ,;\t\n")]
    if not lines or len(lines) - 1 > MOST_ROWS:
        raise SceneError(f"{file}: expected a heading and up to {MOST_ROWS} rows, found {len(lines)} lines")
    heading = lines[0][1]
    separator = delimiter_of(heading)
    columns, units, unread = list[str](), dict[str, str](), list[str]()
    for cell in next(csv.reader([heading], delimiter=separator)):
        word, unit = name_and_unit(cell)
        column = next((key for key, known in names.items() if word.lower().replace(".", "") in known), "")
        unread += [word] if word and (not column or column in columns) else []
        columns.append("" if column in columns else column)
        if unit and columns[-1]:
            units[column] = unit_here(unit.lower() if is_unit(unit.lower()) else unit)
    missing = [name for name in needed if name not in columns]
    if missing:
        raise SceneError(
            f"{file}, line {lines[0][0]}: expected the columns {', '.join(needed)}, found no {' and no '.join(missing)}"
            f"; known headings: {', '.join(name for known in names.values() for name in known)}"
        )
    rows = []
    for number, line in lines[1:]:
        place, cells = f"{file}, line {number}", next(csv.reader([line], delimiter=separator))
        if any(cell.strip() for cell in cells[len(columns) :]):
            raise SceneError(
                f"{place}: expected at most {len(columns)} cells as in the heading, found {len(cells)}; a number has "
                "no separator of thousands"
            )
        if separator == ";":
            cells = [re.sub(_DECIMAL_COMMA, r"\1.\2", cell) for cell in cells]
        rows.append(Row(place, dict(zip(columns, cells, strict=False)), units, system, tuple(unread)))
    return rows


def quantity(option: str, text: str, dimension: Dimension, least: float = -math.inf, bare: str = "") -> float:
    """Number of an option in SI; one without a unit is in `bare`, and a 0 needs none.

    Raises:
        SceneError: The text is no such number, is below `least`, or is a length not above 0.
    """
    try:
        number, unit = split(text, dimension)
        value = parse(text if unit else f"{text} {bare if number else dimension.unit}", dimension)
    except SceneError as error:
        raise SceneError(f"{option}: {error}") from None
    if dimension is LENGTH and value <= 0.0:
        raise SceneError(f'{option}: expected a length above 0, found "{short(text)}"')
    if value < least:
        raise SceneError(f'{option}: expected {dimension.article} from {least:g}, found "{short(text)}"')
    return value
