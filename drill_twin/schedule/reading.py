# SPDX-License-Identifier: Apache-2.0
"""Reading of columns of numbers from CSV and MATLAB files."""

import csv
import math
import stat
import subprocess
import sys
from array import array
from collections import Counter
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.child_environment import child_environment
from drill_twin.base.json_reader import read_json
from drill_twin.errors import TableError

Columns = dict[str, Array]
"""Column name -> its numbers, shape (rows,); a missing value is NaN."""

LARGEST_FILE = 200_000_000
MOST_COLUMNS = 10_000
_MATLAB = (".mat",)
_PATIENCE = 60  # s
_NOT_SUPPORTED = 3
_LOAD_MATLAB = """
import io, json, resource, sys
import numpy as np
from scipy.io import loadmat
with open("/proc/self/statm") as statm:
    size = int(statm.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + (1 << 30),) * 2)
try:
    content = loadmat(sys.argv[1])
    columns = {}
    for name, value in content.items():
        array = np.asarray(value)
        is_column = array.size > 1 and array.size == max(array.shape) and array.dtype.kind in "fiu"
        if is_column and not name.startswith("__"):
            columns[name] = array.ravel().astype(np.float64)
    if sum(column.nbytes for column in columns.values()) > LARGEST:
        raise ValueError(f"columns of more than {LARGEST} bytes")
    out = io.BytesIO()
    np.savez(out, np.frombuffer(json.dumps(list(columns)).encode(), np.uint8), *columns.values())
except NotImplementedError:
    sys.exit(3)
except MemoryError:
    print("more than 1 GB in it", file=sys.stderr)
    sys.exit(2)
except BaseException as error:
    print(str(error)[:300], file=sys.stderr)
    sys.exit(2)
sys.stdout.buffer.write(out.getvalue())
""".replace("LARGEST", str(LARGEST_FILE))
_DELIMITERS = ",;\t|"
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "inf", "-inf", "+inf"}


def read_columns(path: Path) -> Columns:
    """Read all columns of numbers of a file.

    Raises:
        TableError: No such file, not a table, or a cell that is not a number (with its line).
    """
    try:
        kind = path.stat()
    except FileNotFoundError:
        raise TableError(f"{path}: expected a CSV or MAT file, found nothing there") from None
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or error
        raise TableError(f"{str(path)[:200]}: expected a CSV or MAT file, found {found}") from None
    if not stat.S_ISREG(kind.st_mode):
        what = "a folder" if stat.S_ISDIR(kind.st_mode) else "a pipe or a device"
        raise TableError(f"{path}: expected a CSV or MAT file, found {what}")
    size = kind.st_size
    if size == 0 or size > LARGEST_FILE:
        raise TableError(f"{path}: expected a table of up to {LARGEST_FILE} bytes, found {size} bytes")
    return _read_matlab(path) if path.suffix.lower() in _MATLAB else _read_csv(path)


def _read_matlab(path: Path) -> Columns:
    """Read a MAT file by scipy in a separate process: a damaged one can crash it or request any amount of memory."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", _LOAD_MATLAB, str(path)],
            capture_output=True,
            timeout=_PATIENCE,
            check=False,
            env=child_environment(),
        )
    except subprocess.TimeoutExpired:
        raise TableError(f"{path}: expected a MAT file, found one not read within {_PATIENCE} s") from None
    said = " ".join(done.stderr.decode("utf-8", "replace").split())
    if done.returncode == _NOT_SUPPORTED:
        raise TableError(f"{path}: expected a MAT file of version 5 to 7, found 7.3; save it with -v7")
    if done.returncode:
        raise TableError(f"{path}: expected a MAT file, found {said[-200:] or 'a damaged one'}")
    with np.load(BytesIO(done.stdout), allow_pickle=False) as archive:
        names = read_json(archive["arr_0"].tobytes())
        return {name: archive[f"arr_{place}"] for place, name in enumerate(names, 1)}


def _read_csv(path: Path) -> Columns:
    try:
        with path.open(encoding="utf-8-sig") as stream:
            return _columns(path, stream)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TableError(f"{path}: expected a CSV file in UTF-8, found {error}") from None


def _columns(path: Path, stream: Iterable[str]) -> Columns:
    rows = ((number, line) for number, line in enumerate(stream, 1) if line.strip() and not line.startswith("#"))
    begun, first = next(rows, (0, ""))
    delimiter = _delimiter(first)
    header = _cells(path, first, delimiter)
    if len(header) > MOST_COLUMNS:
        raise TableError(f"{path}:{begun}: expected at most {MOST_COLUMNS} columns, found {len(header)}")
    if header and all(_number(cell, delimiter) is not None for cell in header):
        raise TableError(f"{path}:{begun}: expected a header with column names, found numbers")
    if twice := sorted(name for name, count in Counter(header).items() if count > 1):
        raise TableError(f"{path}:{begun}: expected each column once, found {', '.join(twice)[:100]} again")
    numbers = array("d")
    for line, text in rows:
        cells = _cells(path, text, delimiter)
        if len(cells) != len(header):
            raise TableError(f"{path}:{line}: expected {len(header)} values as in the header, found {len(cells)}")
        for name, cell in zip(header, cells, strict=True):
            value = _number(cell, delimiter)
            if value is None:
                raise TableError(f'{path}:{line}: expected a number in column "{name[:40]}", found "{cell[:40]}"')
            numbers.append(value)
    if not numbers:
        raise TableError(f"{path}: expected a header and rows of numbers, found {1 if begun else 0} lines")
    table = np.frombuffer(numbers).reshape(-1, len(header))
    return {name: table[:, column].copy() for column, name in enumerate(header)}


def _cells(path: Path, line: str, delimiter: str) -> list[str]:
    if "\0" in line:
        raise TableError(f"{path}: expected a CSV or MAT file, found binary data")
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def _delimiter(header: str) -> str:
    """Most frequent delimiter of the header; a space if there is no other."""
    best = max(_DELIMITERS, key=header.count)
    return best if header.count(best) else " "


def _number(cell: str, delimiter: str) -> float | None:
    """Value of a cell, NaN if it is missing, None if it is text; decimal commas are read."""
    if cell.lower() in _MISSING:
        return math.nan
    try:
        return float(cell.replace(",", ".") if delimiter != "," else cell)
    except ValueError:
        return None
