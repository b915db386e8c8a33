# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers over time from files: CSV, MATLAB, LAS 2.0 and WITSML 1.4.1 time logs."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.yaml_reader import plain_yaml
from drill_twin.core.units.dimension import TIME
from drill_twin.scene.records.channels import CHANNELS
from drill_twin.scene.records.columns import Columns, Taken
from drill_twin.scene.records.las_file import read_las
from drill_twin.scene.records.matlab_file import read_matlab
from drill_twin.scene.records.rows import read_csv
from drill_twin.scene.records.times import past_midnight
from drill_twin.scene.records.witsml_file import read_witsml

__all__ = ["CHANNELS", "RECORDS", "Columns", "Taken", "read_columns"]

_READERS = {".mat": read_matlab, ".las": read_las, ".xml": read_witsml, ".witsml": read_witsml}
_BESIDE = ForeignFile("names of columns", 100_000, TableError)
RECORDS = frozenset((*_READERS, ".csv", ".txt"))
"""Endings of records."""


BESIDE = ".yaml"
"""Ending, after the name of the record, of the file that names its columns."""
_LATE = 10
"""Places by which a row may come late; a record that goes back farther is several records in one file."""
_SINCE_1970, _EPOCHS = (1e9, 4e9), {1.0: "s", 1e3: "ms", 1e6: "us", 1e9: "ns"}
"""Seconds since 1970 in the years 2001 to 2096, and units that computers count so."""
_SPREADSHEET, _DENSE = (30_000.0, 80_000.0), 0.005
"""Days of a spreadsheet in the years 1982 to 2119, and their largest usual step [d]: seconds do not come so dense."""
_FEWEST, _LONGEST, _HOUR = 2, 1e8, 3600.0
"""Fewest rows, an hour [s], and the time from which it is one since 1970, three years [s]."""


def read_columns(path: Path, choices: Iterable[str] = ()) -> Columns:
    """Read all columns of numbers of a file, in order of time; what is not MAT, LAS or WITSML is read as CSV.

    Args:
        path: The file; where `path.yaml` is beside it, its pairs come before the choices.
        choices: Channels and their columns as `CHANNEL=COLUMN:UNIT`, and null values as `null_value=NUMBER`.

    Raises:
        TableError: No such file, not a table, or a time that goes back and forth.
    """
    columns, beside = _READERS.get(path.suffix.lower(), read_csv)(path), path.with_name(path.name + BESIDE)
    pairs = plain_yaml(_BESIDE.text(beside), str(beside)) if beside.exists() else {}
    if not isinstance(pairs, dict):
        raise TableError(f'{beside}: expected lines such as "weight_on_bit: WOB:klbf", found none')
    columns.choose((*(f"{name}={value}" for name, value in pairs.items()), *choices))
    _set_in_order(columns)
    return columns


def _set_in_order(columns: Columns) -> None:
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
    back = np.flatnonzero(steps < 0.0)
    if name in columns.dates and back.size == 1 and abs(steps[back[0]] + _HOUR) < 0.1 * _HOUR:
        time[rows[back[0] + 1 :]] += _HOUR
        notes.append(f"the clock was set back by an hour before row {rows[back[0] + 1] + 1}")
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
        if dates[found[0]].unsure:
            raise TableError(
                f'{columns.file}: expected hours, minutes and seconds, found two numbers in "{found[0]}", which may be '
                f'hours and minutes or minutes and seconds; say which, as --channel "time={found[0]}:MM:SS" or HH:MM'
            )
        columns[found[0]] = past_midnight(columns[found[0]])
    return found[0] if len(found) == 1 else ""


def _guessed(times: Array) -> str:
    """Unit of times that a file gives without one: since 1970, or days of a spreadsheet; empty where none is sure."""
    low, high = np.nanmin(times, initial=np.inf), np.nanmax(times, initial=-np.inf)
    dense = 0.0 < np.nanmedian(np.abs(np.diff(times, append=np.nan))) < _DENSE
    days = "d" if dense and _SPREADSHEET[0] <= low <= high <= _SPREADSHEET[1] else ""
    return next((unit for n, unit in _EPOCHS.items() if _SINCE_1970[0] * n <= low <= high <= _SINCE_1970[1] * n), days)
