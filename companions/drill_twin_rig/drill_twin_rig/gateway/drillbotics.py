# SPDX-License-Identifier: Apache-2.0
"""Files that Drillbotics asks for: `drilling_timeseries.csv` and `WELL_logs.las`, written from a bag, and checked.

Guidelines of the Open Source Drilling Community, repository drillbotics-guidelines, cycle 2025.1 (29 June 2026):
`docs/tracks/group-a/technical-specs.md`, `docs/tracks/group-b/deliverables.md`, `docs/competition/rules-scoring.md`.
The guidelines suggest the ten columns of `SUGGESTED`; the twin's further signals follow by D-WIS name with unit.
The check reads both files again as a judge would.
"""

import csv
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import BagError, MessageError, TableError, import_extra
from drill_twin.core.numerals import number
from drill_twin.core.table import Table
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import RIG_STATE, TWIN_SCENE
from drill_twin.report.rig_table import Channel, las_text
from drill_twin.report.selection import Selection
from drill_twin.scene.records.rows import CSV
from drill_twin_rig.gateway.quantities import QUANTITIES, TwinQuantities
from drill_twin_rig.gateway.signals import ShownSignal, read_signals, signals_path

TIMESERIES = "drilling_timeseries.csv"
LOWEST_RATE = 1.0
"""Fewest rows per second [Hz], of the guidelines."""
SUGGESTED: Mapping[str, str] = {
    "timestamp_utc_iso": "",
    "bit_depth_m": "BitDepth",
    "rpm": "SurfaceRPM",
    "wob_kN": "WOB",
    "torque_kNm": "SurfaceTorque",
    "flow_in_lpm": "",
    "flow_out_lpm": "",
    "spp_MPa": "",
    "rop_mph": "ROP",
    "hookload_kN": "HookLoad",
}
"""Columns that the guidelines suggest, in their order, and the D-WIS names of what the twin has of them."""
_SCALE = {"wob_kN": 1e-3, "torque_kNm": 1e-3, "hookload_kN": 1e-3}
"""Units of the column per unit of the signal: N, N m -> kN, kN m; the others are the same (m, rpm, m/h)."""
_LAST = {"BitDepth", "HookPosition", "TopOfStringPosition", "WhirlState"}
_OF_SIMULATION = {"SimulatedTime", "RealTimeFactor"}


@dataclass(frozen=True, eq=False)
class DrillingLog:
    """Signals over time, each the mean over the time before its row; positions hold at the row."""

    start: datetime
    """Time of the simulation's zero, UTC."""
    time: Array
    """Simulated time [s], shape (rows,)."""
    values: Mapping[str, Array]
    """Values by D-WIS name in the units of `signals`, each of shape (rows,); NaN where there is none."""
    signals: Mapping[str, ShownSignal]
    """Signals by D-WIS name."""

    def stamps(self) -> list[str]:
        """Times as ISO 8601 in UTC with milliseconds."""
        return [
            (self.start + timedelta(milliseconds=round(1e3 * time)))
            .isoformat(timespec="milliseconds")
            .replace("+00:00", "Z")
            for time in self.time.tolist()
        ]

    def csv_text(self) -> str:
        """The suggested columns, then all others by D-WIS name with the unit in parentheses."""
        empty, columns = np.full(self.time.size, math.nan), {}
        for column, name in SUGGESTED.items():
            columns[column] = self.values.get(name, empty) * _SCALE.get(column, 1.0)
        for name, values in self.values.items():
            if name not in SUGGESTED.values():
                columns[f"{name} ({self.signals[name].unit or '-'})"] = values
        del columns["timestamp_utc_iso"]
        rows = [
            (stamp, *(f"{value:.6g}" if math.isfinite(value) else "" for value in row))
            for stamp, *row in zip(self.stamps(), *(values.tolist() for values in columns.values()), strict=True)
        ]
        return Table(("timestamp_utc_iso", *columns), rows).csv()

    def las_text(self, well: str) -> str:
        """All signals over time as LAS 2.0, the D-WIS names as mnemonics.

        Raises:
            ArgumentError: The package lasio is not installed.
        """
        channels = [Channel("TIME", f"time since {self.stamps()[0]}", "s", self.time - self.time[0])]
        for name, values in self.values.items():
            signal = self.signals[name]
            unit = signal.unit.replace(" ", ".")
            channels.append(Channel(name, QUANTITIES[signal.quantity].meaning, unit, values))
        return las_text(channels, well)


def read_log(bag: Bag, selection: Selection, rate: float, start: datetime | None = None) -> DrillingLog:
    """Read the D-WIS signals of a bag.

    Args:
        bag: The bag.
        selection: Part of its time.
        rate: Rows per second [Hz].
        start: Time of the simulation's zero; by default the recording's, or the run's.

    Raises:
        BagError: The bag has no rig states in this time, or does not say when it was recorded and `start` is missing.
    """
    signals = {one.name: one for one in read_signals(signals_path("dwis")).show if one.name not in _OF_SIMULATION}
    topics = sorted({QUANTITIES[signal.quantity].topic for signal in signals.values()} & set(bag.topics))
    twin, next_run = TwinQuantities(), TwinQuantities()
    first: tuple[float, float] | None = None
    rows: list[list[float]] = []
    for topic, recorded, raw in bag.messages((*topics, TWIN_SCENE)):
        if topic == TWIN_SCENE:
            next_run = TwinQuantities()  # of this run, or the next one
            continue
        with suppress(MessageError):
            next_run.take(topic, raw)
            twin.take(topic, raw)
        if topic != RIG_STATE or not selection.holds(twin.stamp):
            continue
        time = twin.values["simulated_time"]
        if rows and time < rows[-1][0]:
            rows.clear()  # the bag holds several runs; the last one counts
            first, twin, next_run = None, next_run, TwinQuantities()
        first = first or (1e-9 * recorded, time)
        rows.append([time, *(twin.values.get(s.quantity, math.nan) / s.factor for s in signals.values())])
    if len(rows) < 2 or first is None:
        raise BagError(f"{bag.path}: expected messages on {RIG_STATE} in this time, found {len(rows)}")
    table = np.array(rows)
    if (covered := table[-1, 0] - table[0, 0]) * rate < 1.0:
        raise BagError(f"{bag.path}: expected rig states over {1.0 / rate:g} s or more, found {covered:g} s")
    ends, means, last = _resampled(table, rate)
    values = {name: (last if name in _LAST else means)[:, k] for k, name in enumerate(signals, 1)}
    return DrillingLog(start or _zero(bag, *first), ends, values, signals)


def _resampled(table: Array, rate: float) -> tuple[Array, Array, Array]:
    """Ends of the intervals of 1/rate [s], means in each, and last rows."""
    edges = table[0, 0] + np.arange(1, int((table[-1, 0] - table[0, 0]) * rate) + 1) / rate
    place = np.searchsorted(edges, table[:, 0] - 1e-9, side="left")
    kept, begin = np.unique(place[place < edges.size], return_index=True)
    end = np.append(begin[1:], np.count_nonzero(place < edges.size))
    means = np.array([table[a:b].mean(axis=0) for a, b in zip(begin, end, strict=True)])
    return edges[kept], means, table[end - 1]


def _zero(bag: Bag, recorded: float, time: float) -> datetime:
    """Time of the simulation's zero: of the recording where it has dates, else the start that the run noted."""
    if recorded - time > 1e8:  # s since 1970; a run without ROS records by simulated time
        return datetime.fromtimestamp(recorded - time, UTC)
    with suppress(BagError, ValueError):
        if found := re.search(r"^[ \t]*started: ['\"]?([0-9T:.+-]+)", bag.scene(), re.MULTILINE):
            return datetime.fromisoformat(found[1])
    raise BagError(f"{bag.path}: expected the time of the run, found none in the bag; give --start")


_STAMP = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z")
_UNIT = re.compile(r"(_[A-Za-z]+|\([^()]+\))$|^rpm$")


Rule = tuple[str, bool | None, str]
"""Rule, whether it is kept (None: not the twin's to give; a note), and what was found."""


def check_timeseries(path: Path) -> Iterator[Rule]:
    """Check a `drilling_timeseries.csv`.

    Raises:
        TableError: The file cannot be read as CSV.
    """
    try:
        header, *rows = list(csv.reader(line for _, line in CSV.lines(path))) or [[]]
    except csv.Error as error:
        raise TableError(f"{path}: expected a CSV file in UTF-8, found {error}") from None
    yield ("name", path.name == TIMESERIES, path.name)
    missing = [column for column in SUGGESTED if column not in header]
    yield ("suggested columns", not missing, f"without {', '.join(missing)}" if missing else f"all {len(SUGGESTED)}")
    bare = [column for column in header[1:] if not _UNIT.search(column)]
    yield ("a unit in every heading", not bare, ", ".join(bare)[:80] or f"{len(header)} headings")
    ragged = [k for k, row in enumerate(rows, 2) if len(row) != len(header)]
    yield (
        "rows as long as the header",
        bool(rows) and not ragged,
        f"line {ragged[0]}" if ragged else f"{len(rows)} rows",
    )
    if missing or ragged or not rows:
        return
    stamps = [row[header.index("timestamp_utc_iso")] for row in rows]
    odd = [stamp for stamp in stamps if not _STAMP.fullmatch(stamp)]
    yield ("times in UTC, ISO 8601, with milliseconds", not odd, odd[0] if odd else f"{stamps[0]} to {stamps[-1]}")
    if odd:
        return
    times = [datetime.fromisoformat(stamp).timestamp() for stamp in stamps]
    steps = [later - earlier for earlier, later in pairwise(times)]
    yield ("times increase", min(steps, default=1.0) > 0.0, f"steps of {min(steps, default=math.nan):.3g} s at least")
    yield (
        f"{LOWEST_RATE:g} row a second or more",
        max(steps, default=math.inf) <= 1.0 / LOWEST_RATE + 1e-3,
        f"longest step {max(steps, default=math.nan):.3g} s",
    )
    for name, column in ((name, [row[k] for row in rows]) for k, name in enumerate(header) if k):
        text = next((cell for cell in column if cell and number(cell.strip()) is None), "")
        if text:
            yield ("numbers only", False, f'{name}: "{text[:40]}"')
        elif name in SUGGESTED and not any(column):
            needed = "" if SUGGESTED[name] else ", needed of virtual teams"  # which have no circulation in the twin
            yield (f"values of {name}", None, f"not computed in this run{needed}")


def check_log(path: Path) -> Iterator[Rule]:
    """Check a `WELL_logs.las` by lasio.

    Raises:
        ArgumentError: lasio is not installed.
        TableError: The file cannot be read as LAS.
    """
    try:
        las = import_extra("lasio").read(str(path), encoding="utf-8")
        version, well = float(las.version["VERS"].value), str(las.well["WELL"].value)
        units = [curve.mnemonic for curve in las.curves if not curve.unit]
        index = las.curves[0].data
    except (OSError, ValueError, KeyError, IndexError, AttributeError) as error:
        raise TableError(f"{path}: expected LAS 2.0, found {' '.join(str(error).split())[:200]}") from None
    yield ("name", path.name.endswith("_logs.las"), path.name)
    yield ("LAS 2.0", version == 2.0, f"version {version:g}")
    yield ("name of the well", bool(well), well or "none")
    yield (
        "an index that increases",
        bool((index[1:] > index[:-1]).all()),
        f"{las.curves[0].mnemonic}, {index.size} rows",
    )
    yield ("curves", len(las.curves) > 1, f"{len(las.curves)}, without unit: {', '.join(units) or 'none'}")
