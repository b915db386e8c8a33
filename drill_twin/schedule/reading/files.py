# SPDX-License-Identifier: Apache-2.0
"""Choice of the reader of a record by the ending of its file."""

from __future__ import annotations

import stat
from pathlib import Path

from drill_twin.errors import TableError
from drill_twin.schedule.reading.columns import Columns
from drill_twin.schedule.reading.csv_file import read_csv
from drill_twin.schedule.reading.las_file import read_las
from drill_twin.schedule.reading.matlab_file import read_matlab
from drill_twin.schedule.reading.witsml_file import read_witsml

LARGEST_FILE = 200_000_000
KINDS = "CSV, MAT, LAS or WITSML"
_READERS = {".mat": read_matlab, ".las": read_las, ".xml": read_witsml, ".witsml": read_witsml}
RECORDS = frozenset((*_READERS, ".csv", ".txt"))
"""Endings of records."""


def read_columns(path: Path) -> Columns:
    """Read all columns of numbers of a file; what is not MAT, LAS or WITSML by its ending is read as CSV.

    Raises:
        TableError: No such file, not a table, or a cell that is not a number (with its line).
        ArgumentError: A LAS file, and the package lasio is not installed.
    """
    try:
        kind = path.stat()
    except FileNotFoundError:
        raise TableError(f"{path}: expected a {KINDS} file, found nothing there") from None
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or error
        raise TableError(f"{str(path)[:200]}: expected a {KINDS} file, found {found}") from None
    if not stat.S_ISREG(kind.st_mode):
        what = "a folder" if stat.S_ISDIR(kind.st_mode) else "a pipe or a device"
        raise TableError(f"{path}: expected a {KINDS} file, found {what}")
    size = kind.st_size
    if size == 0:
        raise TableError(f"{path}: expected a {KINDS} file, found an empty one; export it again")
    if size > LARGEST_FILE:
        raise TableError(f"{path}: expected a table of up to {LARGEST_FILE} bytes, found {size} bytes")
    return _READERS.get(path.suffix.lower(), read_csv)(path)
