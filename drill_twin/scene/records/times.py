# SPDX-License-Identifier: Apache-2.0
"""Time of a record: dates and clocks in one column or two, or numbers, brought into order."""

from __future__ import annotations

import math
import re
from array import array
from datetime import date
from typing import TYPE_CHECKING

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError
from drill_twin.core.units.dimension import TIME

if TYPE_CHECKING:
    from drill_twin.scene.records.columns import Columns

ORDERS = ("day/month", "month/day", "year/month")
"""Meanings of the first two numbers of a date such as 04/03/26."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_CELL = re.compile(
    r"(?:(?P<year>\d{4})[-/. ](?P<month>\d{1,2}|[a-z]{3,9})[-/. ](?P<day>\d{1,2})|(?P<digits>\d{8}|\d{6})"
    r"|(?P<a>\d{1,2}|[a-z]{3,9})[-/. ](?P<b>\d{1,2}|[a-z]{3,9})[-/., ]{1,2}(?P<c>\d{4}|\d{2}))?"
    r"(?:[t ,_:-]{0,3}(?P<hour>\d{1,2}):?(?P<minute>\d{2})(?::?(?P<second>\d{2}(?:[.,]\d{1,9})?))?"
    r" ?(?P<half>[ap]\.?m\.?)?)?(?: ?(?:z|utc|gmt))?(?P<zone>[+-]\d{2}(?::?\d{2})?)?",
    re.ASCII,
)
_DAY = 86400.0
_LATE = 100
"""Places by which a row may come late; a record that goes back farther is several records in one file."""
_SINCE_1970, _EPOCHS = (1e9, 4e9), {1.0: "s", 1e3: "ms", 1e6: "us", 1e9: "ns"}
"""Seconds since 1970 in the years 2001 to 2096, and units that computers count so."""
_SPREADSHEET, _DENSE = (30_000.0, 80_000.0), 0.005
"""Days of a spreadsheet in the years 1982 to 2119, and their largest usual step [d]: seconds do not come so dense."""
_FEWEST, _LONGEST = 2, 1e8
"""Fewest rows, and the time from which it is one since 1970, three years [s]."""
_NO_TIME = (math.nan,) * len(ORDERS)
_FIRST_DAY = date(1970, 1, 1).toordinal()


class Dates:
    """Cells of a column that are dates or clocks, read in every order that the cells allow.

    Attributes:
        dated: True if a cell has a date.
        clocked: True if a cell has a clock.
    """

    def __init__(self, rows: int) -> None:
        """Begin after so many rows without a value."""
        self._readings = [array("d", [math.nan]) * rows for _ in ORDERS]
        self.dated = self.clocked = False

    def add(self, cell: str) -> bool:
        """Append a cell; False if it is neither a date nor a clock, and then NaN is appended."""
        found = _CELL.fullmatch(cell.lower())
        part = found.groupdict(default="") if found else {}
        dated = bool(part and part["digits"] + part["year"] + part["a"])
        times = _times(part, dated=dated) if dated or (part and part["hour"]) else _NO_TIME
        for reading, time in zip(self._readings, times, strict=True):
            reading.append(time)
        is_time = not all(map(math.isnan, times))
        self.dated, self.clocked = self.dated | (is_time and dated), self.clocked | (is_time and bool(part["hour"]))
        return is_time

    def seconds(self, asked: str) -> tuple[Array, list[str]]:
        """Seconds since 1970, or since midnight, and sentences on how the cells were read.

        Args:
            asked: Form that the file or the user gives, as DD/MM/YYYY; else the order with the shortest record counts.
        """
        readings = [np.frombuffer(reading) for reading in self._readings]
        worth = [
            (np.isnan(one).sum(), np.nanmax(one, initial=-np.inf) - np.nanmin(one, initial=np.inf)) for one in readings
        ]
        order = {"dd": 0, "mm": 1, "yy": 2}.get(asked[:2].lower() if re.match(r"\w+\W", asked) else "")
        best = min(range(len(ORDERS)), key=worth.__getitem__) if order is None else order
        rivals = {span for lacks, span in worth if lacks == worth[best][0]}
        notes = [f"dates read as {ORDERS[best]}, the shortest record"] * (order is None and len(rivals) > 1)
        return readings[best].copy(), notes


def past_midnight(times: Array) -> Array:
    """Times of a clock that go on after midnight [s]."""
    known = np.flatnonzero(np.isfinite(times))
    days = np.round(np.diff(times[known], prepend=times[known[:1]]) / _DAY)
    times[known] -= _DAY * np.cumsum(days)
    return times


def _times(part: dict[str, str], *, dated: bool) -> tuple[float, ...]:
    """Times of the parts of a cell in the orders of `ORDERS`; NaN where there is no such date or clock."""
    second, zone = float(part["second"].replace(",", ".") or 0), part["zone"].replace(":", "").ljust(5, "0")
    hour, minute = int(part["hour"] or 0), int(part["minute"] or 0)
    if part["half"]:
        hour = hour % 12 + 12 * part["half"].startswith("p")
    minutes = 60 * hour + minute - (int(zone[0] + "1") * (60 * int(zone[1:3]) + int(zone[3:])) if part["zone"] else 0)
    if hour > 24 or minute > 59 or second >= 61.0:
        return _NO_TIME
    a, b, c, ymd = part["a"], part["b"], part["c"], (part["year"], part["month"], part["day"])
    if digits := part["digits"]:
        ymd = digits[:-4], digits[-4:-2], digits[-2:]
    orders = ((c, b, a), (c, a, b), (a, b, c) if len(c) == 2 else ("", "", "")) if a else (ymd, ymd, ymd)
    return tuple((_days(*order) if dated else 0.0) * _DAY + 60.0 * minutes + second for order in orders)


def _days(year: str, month: str, day: str) -> float:
    """Days since 1970; NaN where there is no such day."""
    number = _MONTHS.index(month[:3]) + 1 if month[:3] in _MONTHS else month
    century = 0 if len(year) > 2 else 1900 if year >= "70" else 2000
    try:
        return float(date(int(year) + century, int(number), int(day)).toordinal() - _FIRST_DAY)
    except ValueError:
        return math.nan


def set_in_order(columns: Columns) -> None:
    """Read the time, sort the rows by it, and let dates begin at 0; a record without a time stays as it is.

    Raises:
        TableError: The time goes back by many rows, or fewer than two rows have times of their own.
    """
    name, notes = _time(columns), columns.notes
    if name not in columns:
        return
    time, size = columns[name], columns[name].size
    given = "" if name in columns.dates else columns.chosen("time")[1] or columns.unit(name, TIME)
    unit = given or ("s" if name in columns.dates else _guessed(time))
    rows = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[rows])
    if newest_first := bool(2 * np.sum(steps > 0.0) < np.sum(steps < 0.0)):
        rows = rows[::-1]
    order = np.argsort(time[rows], kind="stable")
    if np.abs(order - np.arange(rows.size)).max(initial=0) > _LATE:
        place = int(np.argmin(np.diff(time[rows])))
        raise TableError(
            f"{columns.file}: expected time that increases, found {time[rows[place + 1]]:.6g} {unit} after "
            f"{time[rows[place]]:.6g} {unit} in row {rows[place + 1] + 1}; give each run a file of its own"
        )
    rows = rows[order]
    own = np.diff(time[rows], prepend=-np.inf) > 0.0
    told = {"without a stamp left out": size - rows.size, "with a repeated stamp left out": int(np.sum(~own))}
    notes += [f"{count} row{'s' * (count > 1)} {what}" for what, count in told.items() if count]
    notes += [f"rows sorted by time{', the newest came first' * newest_first}"] * bool((steps < 0.0).any())
    if (rows := rows[own]).size < _FEWEST:
        raise TableError(f"{columns.file}: expected at least two time stamps in {name}, found {rows.size}")
    columns.keep(rows, size)
    values = columns.si(name, unit, TIME, "time") if unit else columns[name]
    if unit and (not given or values[0] > _LONGEST):
        columns[name], columns.given["time"] = np.round(values - values[0], 6), (name, "s")
        notes += [f"{name} read in {unit} {'of a spreadsheet' * (unit == 'd')}"] * (name not in columns.dates)


def _time(columns: Columns) -> str:
    """Column of time; its dates and clocks, which may be two columns, as seconds; empty where there is not one."""
    dates, found = columns.dates, columns.named("time")
    days = [name for name, one in dates.items() if not one.clocked]
    clocks = [name for name, one in dates.items() if not one.dated]
    paired = bool(days and clocks) and (not found or bool({*found} & {days[0], clocks[0]}))
    found = clocks[:1] if paired else found
    for name, one in dates.items():
        columns[name], notes = one.seconds(columns.chosen("time")[1] or columns.units.get(name, "") or name)
        columns.notes += notes if name in found or paired else []
    if paired:
        columns[found[0]] += columns[days[0]]
        columns.given["time"] = (found[0], "")
    elif found[:1] == clocks[:1] != []:
        columns[found[0]] = past_midnight(columns[found[0]])
    return found[0] if len(found) == 1 else ""


def _guessed(times: Array) -> str:
    """Unit of times that a file gives without one: since 1970, or days of a spreadsheet; empty where none is sure."""
    low, high = np.nanmin(times, initial=np.inf), np.nanmax(times, initial=-np.inf)
    dense = 0.0 < np.nanmedian(np.abs(np.diff(times, append=np.nan))) < _DENSE
    days = "d" if dense and _SPREADSHEET[0] <= low <= high <= _SPREADSHEET[1] else ""
    return next((unit for n, unit in _EPOCHS.items() if _SINCE_1970[0] * n <= low <= high <= _SINCE_1970[1] * n), days)
