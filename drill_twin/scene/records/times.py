# SPDX-License-Identifier: Apache-2.0
"""Dates and clocks in the cells of a record, as seconds."""

import math
import re
from array import array
from datetime import date
from functools import lru_cache

import numpy as np

from drill_twin.core.arrays import Array

ORDERS = ("day/month", "month/day", "year/month")
"""Meanings of the first two numbers of a date such as 04/03/26."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_CELL = re.compile(
    r"(?:(?P<year>\d{4})[-/. ](?P<month>\d{1,2}|[a-z]{3,9})[-/. ](?P<day>\d{1,2})|(?P<digits>\d{8}|\d{6})"
    r"|(?P<a>\d{1,2}|[a-z]{3,9})[-/. ](?P<b>\d{1,2}|[a-z]{3,9})[-/., ]{1,2}(?P<c>\d{4}|\d{2}))?"
    r"(?:[t ,_:-]{0,3}(?P<hour>\d{3}(?=:)|\d{1,2}):?(?P<minute>\d{2})(?::?(?P<second>\d{2}(?:[.,]\d{1,9})?))?"
    r" ?(?P<half>[ap]\.?m\.?)?)?(?: ?(?:z|utc|gmt))?(?P<zone>[+-]\d{2}(?::?\d{2})?)?",
    re.ASCII,
)
_DAY = 86400.0
_NO_TIME = (math.nan,) * len(ORDERS)
_FIRST_DAY = date(1970, 1, 1).toordinal()


class Dates:
    """Cells of a column that are dates or clocks, read in every order that the cells allow.

    Attributes:
        dated: True if a cell has a date.
        clocked: True if a cell has a clock.
        unsure: True if two numbers of a clock may be hours and minutes, or minutes and seconds, known after `seconds`.
    """

    def __init__(self, rows: int) -> None:
        """Begin after so many rows without a value."""
        self._readings = [array("d", [math.nan]) * rows for _ in ORDERS]
        self._short = array("b", [0]) * rows  # cells of two numbers, as 12:30
        self.dated = self.clocked = self._full = self.unsure = False

    def add(self, cell: str) -> bool:
        """Append a cell; False if it is neither a date nor a clock, and then NaN is appended."""
        found = _CELL.fullmatch(cell.lower())
        part = found.groupdict(default="") if found else {}
        dated = bool(part and part["digits"] + part["year"] + part["a"])
        times = _times(part, dated=dated) if dated or (part and part["hour"]) else _NO_TIME
        for reading, time in zip(self._readings, times, strict=True):
            reading.append(time)
        is_time = not all(map(math.isnan, times))
        self._short.append(bool(is_time and not dated and not part["second"] and not part["half"]))
        self._full |= is_time and bool(part["second"])
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
        short = np.frombuffer(self._short, np.int8) > 0
        form = re.search("hh?:mm|mm?:ss", asked.lower())
        self.unsure = bool(short.any() and not form and not self._full)
        if short.any() and (form[0].endswith("ss") if form else not self.unsure):
            readings[best] = np.where(short, readings[best] / 60.0, readings[best])
        notes = [f"dates read as {ORDERS[best]}, the shortest record"] * (order is None and len(rivals) > 1)
        return readings[best].copy(), notes


def past_midnight(times: Array) -> Array:
    """Times of a clock that go on after midnight [s]."""
    known = np.flatnonzero(np.isfinite(times))
    steps = np.diff(times[known], prepend=times[known[:1]])
    newest_first = 2 * np.sum(steps > 0) < np.sum(steps < 0)  # midnight is then a step ahead, else back
    days = np.round(np.where((steps > 0) == newest_first, steps, 0.0) / _DAY)
    times[known] -= _DAY * np.cumsum(days)
    return times


def _times(part: dict[str, str], *, dated: bool) -> tuple[float, ...]:
    """Times of the parts of a cell in the orders of `ORDERS`; NaN where there is no such date or clock."""
    second, zone = float(part["second"].replace(",", ".") or 0), part["zone"].replace(":", "").ljust(5, "0")
    hour, minute = int(part["hour"] or 0), int(part["minute"] or 0)
    if part["half"]:
        hour = hour % 12 + 12 * part["half"].startswith("p")
    minutes = 60 * hour + minute - (int(zone[0] + "1") * (60 * int(zone[1:3]) + int(zone[3:])) if part["zone"] else 0)
    if (hour > 24 and (dated or part["second"] or part["half"])) or minute > 59 or second >= 61.0:
        return _NO_TIME
    a, b, c, ymd = part["a"], part["b"], part["c"], (part["year"], part["month"], part["day"])
    if digits := part["digits"]:
        ymd = digits[:-4], digits[-4:-2], digits[-2:]
    orders = ((c, b, a), (c, a, b), (a, b, c) if len(c) == 2 else ("", "", "")) if a else (ymd, ymd, ymd)
    return tuple((_days(*order) if dated else 0.0) * _DAY + 60.0 * minutes + second for order in orders)


@lru_cache(maxsize=256)
def _days(year: str, month: str, day: str) -> float:
    """Days since 1970; NaN where there is no such day."""
    number = _MONTHS.index(month[:3]) + 1 if month[:3] in _MONTHS else month
    century = 0 if len(year) > 2 else 1900 if year >= "70" else 2000
    try:
        return float(date(int(year) + century, int(number), int(day)).toordinal() - _FIRST_DAY)
    except ValueError:
        return math.nan
