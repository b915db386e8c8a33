# SPDX-License-Identifier: Apache-2.0
"""Check of the two files against the rules of Drillbotics, read again as a judge would."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from drill_twin.core.errors import TableError
from drill_twin.core.extras import import_extra
from drill_twin.gateway.drillbotics.files import LOWEST_RATE, SUGGESTED, TIMESERIES
from drill_twin.scene.records.csv_file import CSV

_NEEDED_OF_VIRTUAL_TEAMS = {"flow_in_lpm": "flow in", "flow_out_lpm": "flow out", "spp_MPa": "standpipe pressure"}
_STAMP = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z")
_UNIT = re.compile(r"(_[A-Za-z]+|\([^()]+\))$|^rpm$")


class Rule(NamedTuple):
    """Rule and what was found."""

    rule: str
    passed: bool | None
    """None: not the twin's to give; a note."""
    found: str


def check_timeseries(path: Path) -> Iterator[Rule]:
    """Check a `drilling_timeseries.csv`.

    Raises:
        TableError: It cannot be read as CSV.
    """
    try:
        header, *rows = list(csv.reader(line for _, line in CSV.lines(path))) or [[]]
    except csv.Error as error:
        raise TableError(f"{path}: expected a CSV file in UTF-8, found {error}") from None
    yield Rule("name", path.name == TIMESERIES, path.name)
    missing = [column for column in SUGGESTED if column not in header]
    yield Rule(
        "suggested columns", not missing, f"without {', '.join(missing)}" if missing else f"all {len(SUGGESTED)}"
    )
    bare = [column for column in header[1:] if not _UNIT.search(column)]
    yield Rule("a unit in every heading", not bare, ", ".join(bare)[:80] or f"{len(header)} headings")
    ragged = [k for k, row in enumerate(rows, 2) if len(row) != len(header)]
    yield Rule(
        "rows as long as the header", bool(rows) and not ragged, f"line {ragged[0]}" if ragged else f"{len(rows)} rows"
    )
    if missing or ragged or not rows:
        return
    stamps = [row[header.index("timestamp_utc_iso")] for row in rows]
    odd = [stamp for stamp in stamps if not _STAMP.fullmatch(stamp)]
    yield Rule("times in UTC, ISO 8601, with milliseconds", not odd, odd[0] if odd else f"{stamps[0]} to {stamps[-1]}")
    if odd:
        return
    times = [datetime.fromisoformat(stamp).timestamp() for stamp in stamps]
    steps = [later - earlier for earlier, later in pairwise(times)]
    yield Rule(
        "times increase", min(steps, default=1.0) > 0.0, f"steps of {min(steps, default=math.nan):.3g} s at least"
    )
    yield Rule(
        f"{LOWEST_RATE:g} row a second or more",
        max(steps, default=math.inf) <= 1.0 / LOWEST_RATE + 1e-3,
        f"longest step {max(steps, default=math.nan):.3g} s",
    )
    for name, column in ((name, [row[k] for row in rows]) for k, name in enumerate(header) if k):
        text = next((cell for cell in column if cell and not _is_number(cell)), "")
        if text:
            yield Rule("numbers only", False, f'{name}: "{text[:40]}"')
        elif name in SUGGESTED and not any(column):
            needed = (
                f", needed of virtual teams: {_NEEDED_OF_VIRTUAL_TEAMS[name]}"
                if name in _NEEDED_OF_VIRTUAL_TEAMS
                else ""
            )
            yield Rule(f"values of {name}", None, f"not computed in this run{needed}")


def check_log(path: Path) -> Iterator[Rule]:
    """Check a `WELL_logs.las` by lasio.

    Raises:
        ArgumentError: lasio is not installed.
        TableError: It cannot be read as LAS.
    """
    try:
        las = import_extra("lasio").read(str(path), encoding="utf-8")
        version, well = float(las.version["VERS"].value), str(las.well["WELL"].value)
        units = [curve.mnemonic for curve in las.curves if not curve.unit]
        index = las.curves[0].data
    except (OSError, ValueError, KeyError, IndexError, AttributeError) as error:
        raise TableError(f"{path}: expected a LAS 2.0 file, found {' '.join(str(error).split())[:200]}") from None
    yield Rule("name", path.name.endswith("_logs.las"), path.name)
    yield Rule("LAS 2.0", version == 2.0, f"version {version:g}")
    yield Rule("name of the well", bool(well), well or "none")
    yield Rule(
        "an index that increases", bool((index[1:] > index[:-1]).all()), f"{las.curves[0].mnemonic}, {index.size} rows"
    )
    yield Rule("curves", len(las.curves) > 1, f"{len(las.curves)}, without unit: {', '.join(units) or 'none'}")


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False
