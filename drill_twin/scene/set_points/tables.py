# SPDX-License-Identifier: Apache-2.0
"""Recorded set-points of a rig: columns selected, converted to SI, spikes removed, gaps interpolated, with a report."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import TableError
from drill_twin.scene.blocks.rig import Column
from drill_twin.scene.records import Taken, read_columns


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
    given = {"time": time, "weight_on_bit": weight_on_bit, "rotation": rotation}
    columns = read_columns(file, [f"{name}={one.column}:{one.unit}" for name, one in given.items() if one])
    chosen = {name: columns.channel(name) for name in ("time", *wanted)}
    stamps = chosen["time"].values
    cleaned: dict[str, Array] = {}
    cleaning: dict[str, Cleaning] = {}
    for name in wanted:
        cleaned[name], cleaning[name] = clean(
            stamps, chosen[name].values, name=f"{file}: {name}", longest_gap=longest_gap, spike_window=spike_window
        )
    return Table(
        path=file,
        time=stamps,
        weight_on_bit=cleaned.get("weight_on_bit"),
        rotation=cleaned.get("rotation"),
        cleaning=cleaning,
        report="; ".join((_report(file, stamps, cleaning, chosen), *columns.notes)),
    )


def _report(file: Path, stamps: Array, cleaning: dict[str, Cleaning], chosen: Mapping[str, Taken]) -> str:
    spacing = float(np.median(np.diff(stamps)))
    head = f"{file.name}: {len(stamps)} rows over {stamps[-1] - stamps[0]:.6g} s, {1.0 / spacing:.6g} per second"
    read = ", ".join(map(_text, chosen.values()))
    return "; ".join([f"{head}; read: {read}", *(f"{name}: {_cleaning_text(done)}" for name, done in cleaning.items())])


def _text(column: Taken) -> str:
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
