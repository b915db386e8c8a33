# SPDX-License-Identifier: Apache-2.0
"""Named tuples of arrays, which hold the state of the analysis for Python and for compiled code."""

from collections import namedtuple
from functools import cache
from typing import Any

import numpy as np

Columns = Any
"""Named tuple of arrays, as `columns` makes it: Python and compiled code read and write `found.radius[k]`."""


def columns(name: str, rows: int, /, **first: Any) -> Columns:
    """Make a named tuple of arrays, which declares each of them once, with its value before the first sample.

    Args:
        name: Name of the class. numba tells types by the class, so equal names and fields have the same type.
        rows: Length of the arrays.
        first: Value that fills the array of a name; an array, or a tuple of arrays, is taken as it is.
    """
    filled = (value if isinstance(value, np.ndarray | tuple) else np.full(rows, value) for value in first.values())
    return _class_of(name, tuple(first))(*filled)


@cache
def _class_of(name: str, fields: tuple[str, ...]) -> Any:
    """Class of the columns, kept in this module: compiled code on disk names the types of its arguments by module."""
    globals()[name] = found = namedtuple(name, fields, module=__name__)  # noqa: PYI024
    return found
