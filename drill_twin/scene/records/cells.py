# SPDX-License-Identifier: Apache-2.0
"""Cells of a table: numbers, dates, and texts that stand for no value."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np

from drill_twin.core.arrays import Array

_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "inf", "-inf", "+inf"}


def number(cell: str) -> float | None:
    """Value of a cell, NaN if it is missing, None if it is text."""
    if cell.lower() in _MISSING:
        return math.nan
    if not cell.isascii() or "_" in cell:  # Python reads 1_0 and digits of other scripts as numbers
        return None
    try:
        return float(cell)
    except ValueError:
        return None


def date(cell: str) -> float | None:
    """Time of an ISO 8601 date [s since 1970], UTC where it names no zone; NaN if it is missing, None if it is text."""
    if cell.lower() in _MISSING:
        return math.nan
    try:
        found = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()


def from_first(times: Array) -> Array:
    """Dates [s since 1970] as times from the first of them [s]."""
    known = times[np.isfinite(times)]
    first: float = known[0] if known.size else 0.0
    return np.round(times - first, 6)  # a double has 0.2 us at today's dates
