# SPDX-License-Identifier: Apache-2.0
"""One line of the table: what the twin computed beside what is exact."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """One number of the twin against its reference."""

    what: str
    """The number, with its unit in brackets."""
    reference: str
    """The formula, or what the law says."""
    source: str
    """Author, year and equation or table of the formula."""
    expected: float
    """By the formula."""
    computed: float
    """By the twin."""
    tolerance: float
    """Largest error that the discretisation explains; the case says why."""
    relative: bool = True
    """Whether error and tolerance are shares of the expected number; else they have its unit."""

    def __post_init__(self) -> None:
        """Refuse shares of nothing."""
        if self.relative and self.expected == 0.0:
            raise ValueError(f"{self.what}: expected a reference other than 0 for a relative error; say relative=False")

    @property
    def error(self) -> float:
        """Computed less expected; as a share of the expected number if `relative`."""
        difference = float(self.computed) - float(self.expected)
        return difference / abs(float(self.expected)) if self.relative else difference

    @property
    def ok(self) -> bool:
        """Whether the error is a number and within the tolerance."""
        return math.isfinite(self.error) and abs(self.error) <= self.tolerance

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON (`drill_twin.studies.json_io`)."""
        numbers = {"expected": float(self.expected), "computed": float(self.computed), "error": self.error}
        return asdict(self) | numbers | {"ok": self.ok}


__all__ = ["Row"]
