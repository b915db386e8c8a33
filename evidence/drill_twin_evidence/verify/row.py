# SPDX-License-Identifier: Apache-2.0
"""Row of the table: a computed number and its reference."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

TWIN = "this twin: "
"""Beginning of the source of a consistency check: the reference is another computation of the twin."""


@dataclass(frozen=True)
class Row:
    """A computed number and its reference."""

    what: str
    """Quantity, with its unit in brackets."""
    reference: str
    """Formula of the reference."""
    source: str
    """Author, year and equation or table of the formula; `TWIN` and what was computed for a consistency check."""
    expected: float
    """Value of the reference."""
    computed: float
    """Value that the twin computed."""
    tolerance: float
    """Largest error that the discretisation explains; the docstring of the case gives the reason."""
    relative: bool = True
    """True if error and tolerance are relative to the expected number; else they have its unit."""

    def __post_init__(self) -> None:
        """Refuse a relative error of zero."""
        if self.relative and self.expected == 0.0:
            raise ValueError(f"{self.what}: expected a reference other than 0 for a relative error; say relative=False")

    @property
    def error(self) -> float:
        """Computed minus expected, over the expected number if `relative`."""
        difference = float(self.computed) - float(self.expected)
        return difference / abs(float(self.expected)) if self.relative else difference

    @property
    def ok(self) -> bool:
        """True if the error is finite and within the tolerance."""
        return math.isfinite(self.error) and abs(self.error) <= self.tolerance

    @property
    def is_consistency(self) -> bool:
        """True if twin is compared with twin: it shows that two of its parts agree, not that they are right."""
        return self.source.startswith(TWIN)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON (`drill_twin.core.files.plain_json`)."""
        numbers = {"expected": float(self.expected), "computed": float(self.computed), "error": self.error}
        return asdict(self) | numbers | {"ok": self.ok, "consistency": self.is_consistency}


__all__ = ["TWIN", "Row"]
