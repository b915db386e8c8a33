# SPDX-License-Identifier: Apache-2.0
"""LAS 2.0 file over time (Canadian Well Logging Society 1992), with or without wrapped rows."""

from collections.abc import Iterator
from pathlib import Path

from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.scene.records.columns import Columns
from drill_twin.scene.records.rows import LARGEST_FILE, RecordRows, RowError

LAS = ForeignFile("a LAS file", LARGEST_FILE, TableError, may_be_empty=False)
_LONGEST_LINE, _MOST_CURVES = 100_000, 1000
_DEPTH = ("DEPT", "DEPTH", "MD", "TVD")
_DELIMITERS = {"COMMA": ",", "TAB": "\t"}


def read_las(path: Path) -> Columns:
    """Read a LAS file over time; its NULL and -999.25 are missing values, columns of text are left out.

    Raises:
        TableError: The file is no LAS 2.0 file, or a log over depth.
    """
    # ASCII by the standard; not all keep it
    bare = ((number, line.strip()) for number, line in LAS.lines(path, longest=_LONGEST_LINE, latin=True))
    lines: Iterator[tuple[int, str]] = ((number, line) for number, line in bare if line and not line.startswith("#"))
    version, null, curves = _header(path, lines)
    rows = RecordRows([name for name, _ in curves], _DELIMITERS.get(version.get("DLM", "").upper(), " "))
    if version.get("WRAP", "").upper() == "YES":
        lines = _unwrapped(lines, len(curves))
    for number, line in lines:
        try:
            rows.add(line)
        except RowError as error:
            raise TableError(f"{path}:{number}: {error}; export it again") from None
    if not curves or not rows.count:
        raise TableError(
            f"{path}: expected curves and rows of data, found {len(curves)} curves without; export it again"
        )
    return rows.columns(path, dict(zip(rows.names, (unit for _, unit in curves), strict=True)), null)


def _header(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[dict[str, str], str, list[tuple[str, str]]]:
    """Values of ~Version, the null value of ~Well, and names and units of ~Curve: all up to ~A.

    Raises:
        TableError: There is no ~V or ~A, too many curves, or the log is over depth.
    """
    version, curves, null, section, seen = dict[str, str](), list[tuple[str, str]](), "", "", set[str]()
    for _, line in lines:
        if line.startswith("~"):
            seen.add(section := line[1:2].upper())
            if section == "A":
                break
            continue
        name, unit, value = _parts(line)
        if section == "V":
            version[name] = value
        elif section == "W" and name == "NULL":
            null = value
        elif section == "C":
            curves.append((name, unit))
    if not {"V", "A"} <= seen:
        raise TableError(f"{path}: expected LAS 2.0 with ~V and ~A sections, found none; export it again")
    if len(curves) > _MOST_CURVES:
        raise TableError(f"{path}: expected at most {_MOST_CURVES} curves, found {len(curves)}; take fewer")
    if curves and curves[0][0] in _DEPTH:
        raise TableError(f"{path}: expected a log over time, found one over {curves[0][0]}; export the log over time")
    return version, null, curves


def _parts(line: str) -> tuple[str, str, str]:
    """Mnemonic, unit and value of a line of the header: `MNEM.UNIT VALUE : DESCRIPTION`."""
    name, _, rest = line.partition(".")
    body = rest.rpartition(":")[0] or rest
    unit, *value = body.split(None, 1) if body[:1].strip() else ("", body)
    if unit.isdecimal() and value:  # of the unit 1000 lbf
        more, *value = value[0].split(None, 1)
        unit = f"{unit} {more}"
    return name.strip().upper() or "UNKNOWN", unit, "".join(value).strip()


def _unwrapped(lines: Iterator[tuple[int, str]], count: int) -> Iterator[tuple[int, str]]:
    """Rows of so many values, which the file has on several lines each."""
    parts, found = list[str](), 0
    for number, line in lines:
        parts.append(line)
        found += len(line.split())
        if found >= count:
            yield number, " ".join(parts)
            parts, found = [], 0
    if parts:
        yield number, " ".join(parts)
