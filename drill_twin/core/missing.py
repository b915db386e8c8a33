# SPDX-License-Identifier: Apache-2.0
"""Numbers that may be missing."""

from __future__ import annotations

import math


def number_or_nan(value: float | None) -> float:
    """The number, NaN for None."""
    return math.nan if value is None else float(value)


def number_or_none(value: float) -> float | None:
    """The number, None for NaN."""
    return None if math.isnan(value) else value
