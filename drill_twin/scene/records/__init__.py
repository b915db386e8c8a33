# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers over time from files: CSV, MATLAB, LAS 2.0 and WITSML 1.4.1 time logs."""

from __future__ import annotations

from pathlib import Path

from drill_twin.scene.records.columns import CHANNELS, Columns
from drill_twin.scene.records.las_file import read_las
from drill_twin.scene.records.matlab_file import read_matlab
from drill_twin.scene.records.rows import read_csv
from drill_twin.scene.records.witsml_file import read_witsml

__all__ = ["CHANNELS", "RECORDS", "Columns", "read_columns"]

_READERS = {".mat": read_matlab, ".las": read_las, ".xml": read_witsml, ".witsml": read_witsml}
RECORDS = frozenset((*_READERS, ".csv", ".txt"))
"""Endings of records."""


def read_columns(path: Path) -> Columns:
    """Read all columns of numbers of a file; what is not MAT, LAS or WITSML by its ending is read as CSV.

    Raises:
        TableError: No such file, not a table, or a cell that is not a number (with its line).
    """
    return _READERS.get(path.suffix.lower(), read_csv)(path)
