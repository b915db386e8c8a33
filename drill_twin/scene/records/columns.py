# SPDX-License-Identifier: Apache-2.0
"""Channels of a rig's record, their names and cells, and the columns of a file with their units."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drill_twin.core import numerals
from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError, nearest
from drill_twin.core.rig_channels import RECORDED, RIG_CHANNELS
from drill_twin.core.units import Dimension, UnitError
from drill_twin.core.units.dimension import TIME
from drill_twin.core.units.parse import name_and_unit, record_factor


class RecordChannel(NamedTuple):
    """Channel of a record, and the names of its column in the order of preference."""

    dimension: Dimension
    mnemonics: tuple[str, ...]
    pattern: str = ""
    """Regular expression of a name that is no known mnemonic, for a set-point whose column the scene does not give."""


_PATTERNS = {
    "time": r"(^|[^a-z])(time|timestamp|stamp|t)([^a-z]|$)",
    "weight_on_bit": r"(^|[^a-z])(wob|weight[ _-]?on[ _-]?bit)([^a-z]|$)",
    "rotation": r"(^|[^a-z])(rpm|rps|top[ _-]?(drive)?[ _-]?(speed|rpm)|rotary[ _-]?speed|rotation)([^a-z]|$)",
}
CHANNELS: Mapping[str, RecordChannel] = {
    "time": RecordChannel(TIME, ("time", "etim", "timestamp_utc_iso", "datetime", "dtim"), _PATTERNS["time"])
} | {
    name: RecordChannel(found.dimension, (*found.mnemonics, found.heading), _PATTERNS.get(name, ""))
    for name, found in ((name, RIG_CHANNELS[field]) for name, field in RECORDED.items())
}
"""Time and the channels of `drill_twin.core.rig_channels` that records have."""


def null_values(given: str, place: str) -> frozenset[float]:
    """Numbers that stand for no value: -999.25, and the null value that a file gives.

    Raises:
        TableError: The null value of the file is no number.
    """
    null = math.nan if given.lower() in {"", "nan"} else numerals.number(given)
    if null is None:
        raise TableError(f'{place}: expected a number as null value, found "{given[:40]}"; correct it')
    return frozenset((-999.25, null))


_MOST_NAMES, _LONGEST_NAME = 20, 60  # in a message
_LONGEST_HEADING = 1000  # characters


class Columns(dict[str, Array]):
    """Numbers by name of the column, each of shape (rows,); a missing value is NaN."""

    def __init__(
        self,
        file: Path,
        values: Mapping[str, Array],
        units: Mapping[str, str] | None = None,
        texts: Mapping[str, str] | None = None,
    ) -> None:
        """Keep the columns of a file.

        Args:
            file: The file, for messages.
            values: Numbers by name.
            units: Units that the file gives apart from the names.
            texts: Columns that are no numbers, with their first text.

        Raises:
            TableError: A name is endless.
        """
        for name in (*values, *(texts or {})):
            if len(name) > _LONGEST_HEADING:
                raise TableError(
                    f"{file}: expected names of columns of at most {_LONGEST_HEADING} characters, found a name of "
                    f'{len(name)}, "{name[:_LONGEST_NAME]}..."'
                )
        super().__init__(values)
        self.file = file
        self.units = dict(units or {})
        self._texts = dict(texts or {})

    def named(self, channel: str) -> list[str]:
        """Columns named by the first mnemonic of a channel that the file has; units do not count."""
        bare, stems = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
        for name in (*self, *self._texts):
            bare[name_and_unit(name)[0].lower()].append(name)
            stem, _, ending = name.rpartition("_")
            if ending == self.unit(name, CHANNELS[channel].dimension):  # no variable of MATLAB has brackets in its name
                stems[stem.lower()].append(name)
        mnemonics = CHANNELS[channel].mnemonics
        return next((names[name] for names in (bare, stems) for name in mnemonics if name in names), [])

    def unit(self, name: str, dimension: Dimension) -> str:
        """Unit of a column, as the file gives it or as its name ends: `WOB [kN]`, `wob_kN`; empty if there is none."""
        if found := self.units.get(name) or name_and_unit(name)[1]:
            return found
        ending = name.rpartition("_")[2]
        try:
            record_factor(ending, dimension)
        except UnitError:
            return ""
        return ending

    def si(self, name: str, unit: str, dimension: Dimension, meant: str) -> Array:
        """Values of a column in SI; a value that is too large for a double in SI is missing.

        Args:
            name: The column.
            unit: Its unit.
            dimension: Dimension that is expected.
            meant: Quantity, for messages.

        Raises:
            TableError: There is no such column, its values are no numbers, or the unit is none of the dimension.
        """
        if name in self._texts:
            raise TableError(f'{self.file}: expected numbers in column "{name}" for {meant}, found {self._texts[name]}')
        if name not in self:
            hint = nearest(name, [known for known in self if len(known) <= _LONGEST_NAME], 0.5)
            raise TableError(f'{self.file}: expected a column "{name}" for {meant}, found {self.listed}{hint}')
        try:
            factor = record_factor(unit, dimension)
        except UnitError as error:
            raise TableError(f'{self.file}: column "{name}" for {meant}: {error}') from None
        with np.errstate(over="ignore"):
            values = self[name] * factor
        return np.where(np.isfinite(values), values, np.nan)

    @property
    def listed(self) -> str:
        """The names, for a message."""
        return ", ".join([name[:_LONGEST_NAME] for name in self][:_MOST_NAMES]) or "no column of numbers"


_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "inf", "-inf", "+inf"}


def number(cell: str) -> float | None:
    """Value of a cell, NaN if it is missing, None if it is text."""
    return math.nan if cell.lower() in _MISSING else numerals.number(cell)


def date(cell: str) -> float | None:
    """Time of an ISO 8601 date [s since 1970], UTC where it names no zone; NaN if it is missing, None if it is text."""
    if cell.lower() in _MISSING:
        return math.nan
    try:
        found = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()


def from_first(times: Array) -> Array:
    """Dates [s since 1970] as times from the first of them [s]."""
    known = times[np.isfinite(times)]
    first: float = known[0] if known.size else 0.0
    return np.round(times - first, 6)  # a double has 0.2 us at today's dates
