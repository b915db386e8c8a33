# SPDX-License-Identifier: Apache-2.0
"""Recorded set-points of a rig: columns selected, converted to SI, spikes removed, gaps interpolated, with a report."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import TableError
from drill_twin.scene.blocks.rig import Column
from drill_twin.scene.records import CHANNELS, Columns, read_columns

_LONGEST_NAME = 60  # in a message
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
            TableError: The record was read without these values.
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
    """Read a record; a column that is not given is found by its mnemonic or a common name, its unit by the header.

    Gaps (missing stamps, NaN) up to `longest_gap` [s] are interpolated linearly; spikes are detected against a running
    median over `spike_window` [s] (0 keeps them).

    Raises:
        TableError: No such file or column, an unknown unit, decreasing time, or a gap longer than `longest_gap`.
    """
    file = Path(path)
    columns = read_columns(file)
    given = {"time": time, "weight_on_bit": weight_on_bit, "rotation": rotation}
    chosen = {name: given[name] or _found(columns, name) for name in ("time", *wanted)}
    raw = {
        name: columns.si(column.column, column.unit, CHANNELS[name].dimension, name) for name, column in chosen.items()
    }
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
        report=_report(file, stamps, cleaning, note, chosen),
    )


def _found(columns: Columns, name: str) -> Column:
    found = columns.named(name) or [c for c in columns if re.search(CHANNELS[name].pattern, c, re.IGNORECASE)]
    if len(found) != 1:
        what = f"{len(found)} ({', '.join(found[:3])[:_LONGEST_NAME]})" if found else "none"
        raise TableError(
            f"{columns.file}: expected one column for {name}, found {what}; name it (`rig.table.{name}`) out of: "
            f"{columns.listed}"
        )
    return Column(column=found[0], unit=_unit_of(columns, found[0], name))


def _unit_of(columns: Columns, column: str, name: str) -> str:
    dimension = CHANNELS[name].dimension
    if unit := columns.unit(column, dimension):
        return unit
    for word, unit in _UNIT_BY_NAME.items():
        if name == "rotation" and word in column.lower():
            return unit
    raise TableError(
        f'{columns.file}: expected a unit in the header, such as "{column[:_LONGEST_NAME]} [{dimension.unit}]", '
        f'found "{column[:_LONGEST_NAME]}"; '
        f"or give column and unit in `rig.table.{name}`"
    )


def _increasing(file: Path, stamps: Array) -> tuple[npt.NDArray[np.intp], str]:
    """Rows with a distinct stamp, and a note on the rows left out."""
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
    said = [f"{_count(missing, 'row')} without a stamp"] * (missing > 0) + [_count(twice, "repeated stamp")] * (
        twice > 0
    )
    return rows, f"; left out {' and '.join(said)}" if said else ""


def _report(file: Path, stamps: Array, cleaning: dict[str, Cleaning], note: str, chosen: Mapping[str, Column]) -> str:
    spacing = float(np.median(np.diff(stamps)))
    head = f"{file.name}: {len(stamps)} rows over {stamps[-1] - stamps[0]:.6g} s, {1.0 / spacing:.6g} per second{note}"
    read = ", ".join(map(_text, chosen.values()))
    return "; ".join([f"{head}; read: {read}", *(f"{name}: {_cleaning_text(done)}" for name, done in cleaning.items())])


def _text(column: Column) -> str:
    """Name and unit of a column."""
    return column.column if f"[{column.unit}]" in column.column else f"{column.column} [{column.unit}]"


def _cleaning_text(done: Cleaning) -> str:
    spikes = f"{_count(done.spikes, 'spike')} ({_count(done.spike_samples, 'sample')}) taken out"
    gaps = (
        f"{_count(done.gaps, 'gap')} ({_count(done.gap_samples, 'sample')}, longest {done.longest_gap:.3g} s) bridged"
    )
    return f"{spikes if done.spikes else 'no spikes'}, {gaps if done.gaps else 'no gaps'}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


CORE = 0.5
"""Least deviation of a spike's peak from the running median, over the 5 to 95 percentile range [-]."""
FLANK = 0.1
"""Least deviation of the other samples of a spike from the median, over the same range [-]."""
SCATTER = 6.0
"""Least deviation in standard deviations of the scatter about the median [-]."""


@dataclass(frozen=True)
class Cleaning:
    """Counts of the corrections to one column."""

    spikes: int = 0
    """Number of spikes removed."""
    spike_samples: int = 0
    """Samples in the spikes."""
    gaps: int = 0
    """Number of gaps interpolated."""
    gap_samples: int = 0
    """Samples missing in the gaps, at the record's median spacing."""
    longest_gap: float = 0.0
    """Longest gap interpolated [s]."""


def clean(time: Array, values: Array, *, name: str, longest_gap: float, spike_window: float) -> tuple[Array, Cleaning]:
    """Remove spikes and gaps from one column, shape (rows,), and count them; `time` [s] must increase.

    Raises:
        TableError: No value at all, or a gap longer than `longest_gap`.
    """
    spacing = float(np.median(np.diff(time)))
    valid = np.isfinite(values)
    if valid.sum() < 2:
        raise TableError(f"{name}: expected at least two finite values, found {int(valid.sum())}")
    gaps = _gaps(time, valid, spacing)
    too_long = [(begin, end) for begin, end in gaps if end - begin > longest_gap]
    if too_long:
        begin, end = too_long[0]
        raise TableError(
            f"{name}: expected gaps of at most {longest_gap:g} s, found {len(too_long)} longer, the first from "
            f"{begin:.6g} s to {end:.6g} s; raise `longest_gap` to bridge it"
        )
    spikes = np.zeros(len(values), dtype=bool)
    spikes[valid] = find_spikes(values[valid], window=round(spike_window / spacing))
    good = valid & ~spikes
    cleaned = np.interp(time, time[good], values[good])
    return cleaned, Cleaning(
        spikes=int(np.count_nonzero(np.diff(spikes.astype(np.int8), prepend=0) == 1)),
        spike_samples=int(spikes.sum()),
        gaps=len(gaps),
        gap_samples=sum(max(1, round((end - begin) / spacing) - 1) for begin, end in gaps),
        longest_gap=max((end - begin for begin, end in gaps), default=0.0),
    )


def find_spikes(values: Array, *, window: int) -> Mask:
    """Mask of the samples in spikes: excursions from a running median over `window` samples, shape (rows,).

    A window below three samples finds none.
    """
    from scipy.ndimage import label, median_filter

    if window < 3 or len(values) < window:
        return np.zeros(len(values), dtype=bool)
    distance = np.abs(values - median_filter(values, window | 1, mode="nearest"))
    low, high = np.percentile(values, [5.0, 95.0])
    scatter = SCATTER * 1.4826 * float(np.median(distance))
    core = distance > max(CORE * (high - low), scatter)
    region, _ = label(distance > max(FLANK * (high - low), scatter))
    return np.isin(region, np.unique(region[core]))


def _gaps(time: Array, valid: Mask, spacing: float) -> list[tuple[float, float]]:
    """Start and end of the intervals without a value that exceed the median spacing by half or more."""
    known = time[valid]
    edges = [(float(known[i]), float(known[i + 1])) for i in np.flatnonzero(np.diff(known) > 1.5 * spacing)]
    if known[0] > time[0]:
        edges.insert(0, (float(time[0]), float(known[0])))
    if known[-1] < time[-1]:
        edges.append((float(known[-1]), float(time[-1])))
    return edges
