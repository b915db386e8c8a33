# SPDX-License-Identifier: Apache-2.0
"""LAS 2.0 file over time (Canadian Well Logging Society 1992), read by lasio."""

from __future__ import annotations

import io
import logging
import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.extras import import_lasio
from drill_twin.errors import TableError
from drill_twin.schedule.reading.cells import date, from_first, number
from drill_twin.schedule.reading.columns import Columns
from drill_twin.schedule.reading.mnemonics import null_values

_LONGEST_HEADER, _LONGEST_LINE = 1_000_000, 100_000  # characters
logging.getLogger("lasio").addHandler(logging.NullHandler())  # else it tells of each column of text on stderr
_MOST_CURVES = 1000
_USED = ("STRT", "STOP", "STEP", "NULL")
"""Lines of the section ~Well that decide how data are read."""
_DEPTH = ("DEPT", "DEPTH", "MD", "TVD")


def read_las(path: Path) -> Columns:
    """Read a LAS file over time; its NULL and -999.25 are missing values.

    Raises:
        TableError: It is no such file, or one over depth.
        ArgumentError: The package lasio is not installed.
    """
    lasio = import_lasio()
    text = _lean(path, _text(path))
    try:
        engine = "normal" if re.search(r"(?im)^[ \t]*WRAP[ \t]*\.[ \t]*YES", text[:_LONGEST_HEADER]) else "numpy"
        las = lasio.read(io.StringIO(text), engine=engine)
        curves = [(str(curve.mnemonic), str(curve.unit), np.asarray(curve.data)) for curve in las.curves]
        null = str(las.well["NULL"].value) if "NULL" in las.well else ""
    except Exception as error:  # noqa: BLE001  lasio raises many kinds, KeyError and IndexError among them
        found = " ".join(str(error).split())[:200] or type(error).__name__
        raise TableError(f"{path}: expected a LAS 2.0 file, found a damaged one ({found}); export it again") from None
    if not curves or not curves[0][2].size:
        raise TableError(
            f"{path}: expected curves and rows of data, found {len(curves)} curves without; export it again"
        )
    if curves[0][0].upper() in _DEPTH:
        raise TableError(f"{path}: expected a log over time, found one over {curves[0][0]}; export the log over time")
    nulls = list(null_values(null, f"{path}: NULL"))
    values, units, texts = {}, {}, {}
    for name, given, data in curves:
        column, unit, odd = _numbers(data)
        units[name] = unit or given
        if odd:
            texts[name] = odd
        else:
            values[name] = np.where(np.isin(column, nulls), math.nan, column)
    return Columns(path, values, units, texts)


def _text(path: Path) -> str:
    """Text of the file; lasio is not asked to open it, since it takes a text without line ends for an address.

    Raises:
        TableError: It is not readable, has no data, or a line that is too long.
    """
    try:
        text = path.read_bytes().decode("latin-1")  # ASCII by the standard; writers put degree signs in
    except OSError as error:
        raise TableError(f"{path}: expected a LAS file, found {error.strerror or error}") from None
    if text[:2] in {"\xff\xfe", "\xfe\xff"}:
        raise TableError(f"{path}: expected a LAS file in ASCII, found UTF-16; save it as UTF-8")
    begin = text.upper().find("\n~A")
    if "~V" not in text[:_LONGEST_HEADER].upper() or not 0 < begin < _LONGEST_HEADER:
        raise TableError(f"{path}: expected a LAS 2.0 file with ~V and ~A sections, found none; export it again")
    if longest := next((k for k, line in enumerate(text.splitlines(), 1) if len(line) > _LONGEST_LINE), 0):
        raise TableError(f"{path}:{longest}: expected a line of at most {_LONGEST_LINE} characters, found a longer one")
    return text


def _lean(path: Path, text: str) -> str:
    """The file without the lines of its header that are not used: lasio compares each line with all before it.

    Raises:
        TableError: It has more than `_MOST_CURVES` curves.
    """
    begin = min(place for mark in ("\n~A", "\n~a") if (place := text.find(mark)) >= 0)
    kept, section, curves = [], "", 0
    for line in text[:begin].splitlines():
        bare = line.strip()
        if bare.startswith("~"):
            section = bare[1:2].upper()
        elif bare.startswith("#") or not bare:
            continue
        elif section == "C":
            curves += 1
        elif section == "W" and not bare.upper().startswith(_USED):
            continue
        if section in {"V", "W", "C"}:
            kept.append(line)
    if curves > _MOST_CURVES:
        raise TableError(f"{path}: expected at most {_MOST_CURVES} curves, found {curves}; export fewer")
    return "\n".join(kept) + text[begin:]


def _numbers(data: Any) -> tuple[Array, str, str]:
    """Numbers of a curve; the unit s where they were dates; the first text where it is neither."""
    if data.dtype.kind in "fiu":
        return data.astype(np.float64), "", ""
    cells = [str(cell).strip() for cell in data.tolist()]
    for read, unit in ((date, "s"), (number, "")):
        found = [read(cell) for cell in cells]
        if None not in found:
            column = np.array(found, np.float64)
            return from_first(column) if unit else column, unit, ""
    row = found.index(None)
    return np.empty(0), "", f'"{cells[row][:40]}" in row {row + 1}'
