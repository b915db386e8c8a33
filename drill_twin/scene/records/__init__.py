# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers over time from files: CSV, MATLAB, LAS 2.0 and WITSML 1.4.1 time logs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.yaml_reader import plain_yaml
from drill_twin.scene.records.channels import CHANNELS
from drill_twin.scene.records.columns import Columns, Taken
from drill_twin.scene.records.las_file import read_las
from drill_twin.scene.records.matlab_file import read_matlab
from drill_twin.scene.records.order import set_in_order
from drill_twin.scene.records.rows import read_csv
from drill_twin.scene.records.witsml_file import read_witsml

__all__ = ["CHANNELS", "RECORDS", "Columns", "Taken", "read_columns"]

_READERS = {".mat": read_matlab, ".las": read_las, ".xml": read_witsml, ".witsml": read_witsml}
_BESIDE = ForeignFile("names of columns", 100_000, TableError)
RECORDS = frozenset((*_READERS, ".csv", ".txt"))
"""Endings of records."""


BESIDE = ".yaml"
"""Ending, after the name of the record, of the file that names its columns."""


def read_columns(path: Path, choices: Iterable[str] = ()) -> Columns:
    """Read all columns of numbers of a file, in order of time; what is not MAT, LAS or WITSML is read as CSV.

    Args:
        path: The file; where `path.yaml` is beside it, its pairs come before the choices.
        choices: Channels and their columns as `CHANNEL=COLUMN:UNIT`, and null values as `null_value=NUMBER`.

    Raises:
        TableError: No such file, not a table, or a time that goes back and forth.
    """
    columns, beside = _READERS.get(path.suffix.lower(), read_csv)(path), path.with_name(path.name + BESIDE)
    pairs = plain_yaml(_BESIDE.text(beside), str(beside)) if beside.exists() else {}
    if not isinstance(pairs, dict):
        raise TableError(f'{beside}: expected lines such as "weight_on_bit: WOB:klbf", found none')
    columns.choose((*(f"{name}={value}" for name, value in pairs.items()), *choices))
    set_in_order(columns)
    return columns
