# SPDX-License-Identifier: Apache-2.0
"""Columns of a file: their names, their units, and what is done with each."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError, nearest
from drill_twin.core.missing import beyond, left_out, without_missing
from drill_twin.core.rig_channels import INSTANT
from drill_twin.core.units import Dimension, UnitError
from drill_twin.core.units.dimension import ANGULAR_SPEED
from drill_twin.core.units.parse import AMBIGUOUS, name_and_unit, record_factor
from drill_twin.scene.records.channels import CHANNELS, NULL, channel_column, null_values, plain, recorded
from drill_twin.scene.records.times import Dates

_QUALIFIERS = frozenset(["average", "averaged", "avg", "ave", "mean", "surface", "surf", "gs", "actual", "measured"])
"""Words of a heading that do not change the channel."""
_MOST_NAMES, _LONGEST_NAME = 20, 60  # in a message
_LONGEST_HEADING = 1000  # characters


class Taken(NamedTuple):
    """Column that a channel is read from."""

    column: str
    unit: str
    values: Array
    """SI, NaN where no value was measured."""


class Columns(dict[str, Array]):
    """Numbers by name of the column, each of shape (rows,); a missing value is NaN.

    Attributes:
        file: The file, for messages.
        units: Units that the file gives apart from the names, or the user.
        left_out: Values of each column that are no measurement.
        notes: Sentences on time and units, for the user.
        taken: Channels that were read, with column and unit.
    """

    def __init__(
        self,
        file: Path,
        values: Mapping[str, Array],
        units: Mapping[str, str] | None = None,
        texts: Mapping[str, str] | None = None,
        nulls: Iterable[float] = (),
        dates: Mapping[str, Dates] | None = None,
    ) -> None:
        """Keep the columns of a file.

        Args:
            file: The file, for messages.
            values: Numbers by name.
            units: Units that the file gives apart from the names.
            texts: Columns that are no numbers, with their first text.
            nulls: Null values that the file gives.
            dates: Columns that are dates or clocks.

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
        self.file, self.notes, self.taken = file, list[str](), dict[str, Taken]()
        self.units = {name: unit.strip("[]() ") for name, unit in (units or {}).items()}
        self.left_out, self.given = dict[str, list[str]](), dict[str, tuple[str, str]]()
        self.dates = dict(dates or {})
        self._texts, self._nulls = dict(texts or {}), [*nulls]

    def choose(self, choices: Iterable[str]) -> None:
        """Take the choices of the user, `CHANNEL=COLUMN:UNIT` and `null_value=NUMBER`, and leave missing values out.

        Raises:
            TableError: A null value is no number, or a channel has no such name.
        """
        for choice in choices:
            channel, column, unit = channel_column(choice, lambda rest: rest in self or rest in self._texts)
            if channel == NULL:
                self._nulls += null_values(column, str(self.file))
            elif column:
                self.given[channel.removesuffix(INSTANT)] = column, unit
        for name, values in self.items():
            self[name], self.left_out[name] = (
                (values, []) if name in self.dates else without_missing(values, self._nulls)
            )

    def keep(self, rows: npt.NDArray[np.intp], size: int) -> None:
        """Keep these rows of the columns of a size, and no column of another size."""
        for name, values in [*self.items()]:
            if values.size == size:
                self[name] = values[rows]
            else:
                self._texts[name] = f"{self.pop(name).size} values beside {size} times"

    def named(self, channel: str) -> list[str]:
        """Columns of a channel: chosen by the user, else named by the first of its mnemonics that the file has."""
        if given := self.chosen(channel)[0]:
            return [given]
        record = CHANNELS[recorded(channel)]
        exact, loose = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
        for name in (*self, *self._texts):
            exact[plain(name_and_unit(name)[0].partition(":")[0])].append(name)  # WOB:2 is the second WOB of a header
            words = re.findall(r"[a-z0-9]+", self._parts(name, record.dimension)[0].partition(":")[0].lower())
            loose["".join(word for word in words if word not in _QUALIFIERS)].append(name)
        found = next((names[key] for names in (exact, loose) for key in record.mnemonics if key in names), [])
        if channel == "time" and not found:
            found = [*self.dates] or [name for name in self if re.match(r"(time|t_)", name, re.IGNORECASE)]
        return found

    def unit(self, name: str, dimension: Dimension) -> str:
        """Unit of a column, as the file gives it or as its name ends: `WOB [kN]`, `wob_kN`, `WOB kN`; else empty."""
        return self._parts(name, dimension)[1]

    def channel(self, name: str, otherwise: str = "") -> Taken:
        """Column of a channel with its unit, and its values in SI; what no rig can have is left out.

        Args:
            name: The channel, by any of its names.
            otherwise: Unit where the file gives none.

        Raises:
            TableError: No column or several have the name, the unit is missing or of another dimension, or it is text.
        """
        dimension, found = CHANNELS[recorded(name)].dimension, self.named(name)
        if len(found) != 1:
            what = f"{len(found)} ({', '.join(found[:3])[:_LONGEST_NAME]})" if found else "none"
            raise TableError(
                f"{self.file}: expected one column for {name}, found {what}; name it, as --channel "
                f'"{name}=COLUMN:{dimension.unit}", out of: {self.listed}'
            )
        column = found[0]
        unit = self.chosen(name)[1] or self.unit(column, dimension) or otherwise
        if not unit and column in self:
            raise TableError(
                f'{self.file}: expected a unit in the header, such as "{column[:_LONGEST_NAME]} [{dimension.unit}]", '
                f'found "{column[:_LONGEST_NAME]}"; or give it, as --channel "{name}={column[:_LONGEST_NAME]}:UNIT"'
            )
        self.taken[name] = Taken(column, unit, self.si(column, unit, dimension, name))
        return self.taken[name]

    def si(self, name: str, unit: str, dimension: Dimension, meant: str) -> Array:
        """Values of a column in SI; what no rig can have in the quantity, or a double cannot hold, is missing.

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
        if taken_for := AMBIGUOUS.get(unit.lower()):
            self.notes.append(f'"{unit}" of {name[:_LONGEST_NAME]} is taken for {taken_for}')
        with np.errstate(over="ignore"):
            values = self[name] * factor
        rows, what = beyond(meant, values)
        if rows.any():  # null values may have hidden behind these
            kept, told = without_missing(np.where(rows, np.nan, self[name]))
            self.left_out[name] += [*left_out(what, rows), *told[1:]]
            values = kept * factor
        return np.where(np.isfinite(values), values, np.nan)

    @property
    def listed(self) -> str:
        """The names, for a message."""
        return ", ".join([name[:_LONGEST_NAME] for name in self][:_MOST_NAMES]) or "no column of numbers"

    @property
    def told(self) -> list[str]:
        """Sentences for the user: the notes, and what was left out of the columns that were read."""
        left = ((one.column, self.left_out[one.column]) for one in self.taken.values())
        return [*self.notes, *(f"{column}: left out {', '.join(texts)}" for column, texts in left if texts)]

    def account(self) -> Iterator[dict[str, Any]]:
        """Use of each column: `column`, `channel` and `unit` if it is taken, else `why` not; `left_out`."""
        by_column = {taken.column: (name, taken.unit) for name, taken in self.taken.items()}
        for name in (*self, *self._texts):
            channel, unit = by_column.get(name, ("", ""))
            why, left = "" if channel else self._why_not(name), self.left_out.get(name, [])
            yield {"column": name, "channel": channel, "unit": unit, "why": why, "left_out": left}

    def _why_not(self, name: str) -> str:
        if name in self._texts:
            return f"text, {self._texts[name]}"
        if name in self.dates:
            return "a date or a clock, part of the time or beside it"
        if name.partition(":")[0] != name and f"{name.partition(':')[0]}:1" in self:
            return "twice in the header"
        for channel, record in CHANNELS.items():
            bare, unit = self._parts(name, record.dimension)
            if plain(bare) in record.mnemonics:
                if channel in self.taken:
                    return f"{channel} is taken from {self.taken[channel].column}"
                said = f"unknown unit {unit}" if unit else "no unit"
                return f'{said}: give it, as --channel "{channel}={name[:_LONGEST_NAME]}:UNIT"'
        return "no channel has this name"

    def chosen(self, channel: str) -> tuple[str, str]:
        """Column and unit that the user gives a channel, under any of its names; empty where none."""
        same = (given for name, given in self.given.items() if recorded(name) == recorded(channel))
        return self.given.get(channel) or next(same, ("", ""))

    def _parts(self, name: str, dimension: Dimension) -> tuple[str, str]:
        """Name and unit of a column; the unit is empty where there is none."""
        bare, unit = name_and_unit(name)
        if unit := self.units.get(name) or unit:
            return bare, unit
        words = re.split(r"[ _,;]+", bare[:_LONGEST_NAME])
        for count in (2, 1):
            with suppress(UnitError):
                record_factor(unit := " ".join(words[-count:]), dimension)
                return " ".join(words[:-count]) or bare, unit
        by_name = (unit for word, unit in (("rpm", "rpm"), ("rps", "rev/s")) if word in bare.lower())
        return bare, next(by_name, "") if dimension is ANGULAR_SPEED else ""
