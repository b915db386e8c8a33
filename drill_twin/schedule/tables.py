# SPDX-License-Identifier: Apache-2.0
"""Recorded set-points of a rig: columns selected, converted to SI, cleaned, with a report."""

import difflib
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from drill_twin.base.arrays import Array
from drill_twin.errors import TableError
from drill_twin.scene.blocks.rig import Column
from drill_twin.schedule.clean import Cleaning, clean
from drill_twin.schedule.reading import Columns, read_columns
from drill_twin.units import Dimension, UnitError, factor_of
from drill_twin.units.dimension import ANGULAR_SPEED, FORCE, TIME

_WANTED: dict[str, tuple[Dimension, str]] = {
    "time": (TIME, r"(^|[^a-z])(time|timestamp|stamp|t)([^a-z]|$)"),
    "weight_on_bit": (FORCE, r"(^|[^a-z])(wob|weight[ _-]?on[ _-]?bit)([^a-z]|$)"),
    "rotation": (
        ANGULAR_SPEED,
        r"(^|[^a-z])(rpm|rps|top[ _-]?(drive)?[ _-]?(speed|rpm)|rotary[ _-]?speed|rotation)([^a-z]|$)",
    ),
}
"""Quantity -> its dimension and the pattern of its column's name, if the scene does not give it."""

_MOST_NAMES, _LONGEST_NAME = 20, 60  # in a message
_UNIT_IN_NAME = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]")
_UNIT_BY_NAME = {"rpm": "rpm", "rps": "rev/s"}


@dataclass(frozen=True)
class Table:
    """Recorded set-points on one time axis, in SI, without spikes and gaps."""

    path: Path
    """Source file."""
    time: Array
    """Stamps [s], increasing, shape (rows,)."""
    weight_on_bit: Array | None
    """Weight on bit [N], shape (rows,)."""
    rotation: Array | None
    """Speed of the top drive [rad/s], shape (rows,)."""
    cleaning: dict[str, Cleaning]
    """Corrections by column."""
    report: str
    """The corrections and the length of the record as text."""

    @property
    def duration(self) -> float:
        """Time from first to last stamp [s]."""
        return float(self.time[-1] - self.time[0])

    def column(self, name: str) -> Array:
        """Values of `weight_on_bit` or `rotation`, shape (rows,).

        Raises:
            TableError: The record was read without it.
        """
        values: Array | None = getattr(self, name)
        if values is None:
            raise TableError(f"{self.path}: expected a column for {name}, found none")
        return values


def read_table(
    path: str | Path,
    *,
    time: Column | None = None,
    weight_on_bit: Column | None = None,
    rotation: Column | None = None,
    wanted: Collection[str] = ("weight_on_bit", "rotation"),
    longest_gap: float = 1.0,
    spike_window: float = 0.1,
) -> Table:
    """Read a CSV or MAT record; a column that is not given is found by a common name and the unit in its header.

    Gaps (missing stamps, NaN) up to `longest_gap` [s] are interpolated linearly; spikes are detected against a running
    median over `spike_window` [s] (0 keeps them).

    Raises:
        TableError: No such file or column, an unknown unit, decreasing time, or a gap longer than `longest_gap`.
    """
    file = Path(path)
    columns = read_columns(file)
    given = {"time": time, "weight_on_bit": weight_on_bit, "rotation": rotation}
    raw = {name: _si(file, columns, name, given[name]) for name in ("time", *wanted)}
    lengths = {name: len(values) for name, values in raw.items()}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise TableError(f"{file}: expected columns of one length, found {said}")
    rows, note = _increasing(file, raw["time"])
    stamps = raw["time"][rows]
    cleaned: dict[str, Array] = {}
    cleaning: dict[str, Cleaning] = {}
    for name in wanted:
        cleaned[name], cleaning[name] = clean(
            stamps, raw[name][rows], name=f"{file}: {name}", longest_gap=longest_gap, spike_window=spike_window
        )
    return Table(
        path=file,
        time=stamps,
        weight_on_bit=cleaned.get("weight_on_bit"),
        rotation=cleaned.get("rotation"),
        cleaning=cleaning,
        report=_report(file, stamps, cleaning, note),
    )


def _si(file: Path, columns: Columns, name: str, given: Column | None) -> Array:
    dimension, pattern = _WANTED[name]
    there = ", ".join([name[:_LONGEST_NAME] for name in columns][:_MOST_NAMES]) or "no column of numbers"
    if given is None:
        found = [column for column in columns if re.search(pattern, column, re.IGNORECASE)]
        if len(found) != 1:
            what = f"{len(found)} ({', '.join(found[:3])[:_LONGEST_NAME]})" if found else "none"
            raise TableError(
                f"{file}: expected one column for {name}, found {what}; name it (`rig.table.{name}`) out of: {there}"
            )
        given = Column(column=found[0], unit=_unit_of(file, found[0], name))
    if given.column not in columns:
        close = difflib.get_close_matches(given.column, columns, n=1, cutoff=0.5)
        hint = f', did you mean "{close[0]}"?' if close else ""
        raise TableError(f'{file}: expected a column "{given.column}" for {name}, found {there}{hint}')
    try:
        return columns[given.column] * factor_of(given.unit, dimension)
    except UnitError as error:
        raise TableError(f'{file}: column "{given.column}" for {name}: {error}') from None


def _unit_of(file: Path, column: str, name: str) -> str:
    in_name = _UNIT_IN_NAME.search(column)
    if in_name:
        return in_name.group(1)
    for word, unit in _UNIT_BY_NAME.items():
        if name == "rotation" and word in column.lower():
            return unit
    raise TableError(
        f'{file}: expected a unit in the header, such as "{column[:_LONGEST_NAME]} [{_WANTED[name][0].unit}]", '
        f'found "{column[:_LONGEST_NAME]}"; '
        f"or give column and unit in `rig.table.{name}`"
    )


def _increasing(file: Path, stamps: Array) -> tuple[npt.NDArray[np.intp], str]:
    """Rows with a distinct stamp, and a note on those left out."""
    rows = np.flatnonzero(np.isfinite(stamps))
    missing = len(stamps) - len(rows)
    steps = np.diff(stamps[rows])
    if np.any(steps < 0.0):
        place = int(np.flatnonzero(steps < 0.0)[0])
        before, after = stamps[rows[place]], stamps[rows[place + 1]]
        raise TableError(f"{file}: expected time that increases, found {after:.6g} s after {before:.6g} s")
    if len(rows):
        rows = rows[np.concatenate(([True], steps > 0.0))]
    if len(rows) < 2:
        raise TableError(f"{file}: expected at least two time stamps, found {len(rows)}")
    twice = len(stamps) - missing - len(rows)
    said = [f"{_count(missing, 'row')} without a stamp"] * bool(missing) + [_count(twice, "repeated stamp")] * bool(
        twice
    )
    return rows, f"; left out {' and '.join(said)}" if said else ""


def _report(file: Path, stamps: Array, cleaning: dict[str, Cleaning], note: str) -> str:
    spacing = float(np.median(np.diff(stamps)))
    head = f"{file.name}: {len(stamps)} rows over {stamps[-1] - stamps[0]:.6g} s, {1.0 / spacing:.6g} per second{note}"
    return "; ".join([head, *(f"{name}: {_cleaning_text(done)}" for name, done in cleaning.items())])


def _cleaning_text(done: Cleaning) -> str:
    spikes = f"{_count(done.spikes, 'spike')} ({_count(done.spike_samples, 'sample')}) taken out"
    gaps = (
        f"{_count(done.gaps, 'gap')} ({_count(done.gap_samples, 'sample')}, longest {done.longest_gap:.3g} s) bridged"
    )
    return f"{spikes if done.spikes else 'no spikes'}, {gaps if done.gaps else 'no gaps'}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
