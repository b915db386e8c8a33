# SPDX-License-Identifier: Apache-2.0
"""Published numbers of the paper, from `config/paper/published.yaml`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from drill_twin.core.errors import SceneError
from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin_evidence import CONFIG
from drill_twin_evidence.paper.runs.cases import Case

CRITICAL_TIME, FREQUENCY, RATIO, DISPLACEMENT = (
    "critical time", "whirl frequency", "whirl ratio", "largest displacement",
)  # fmt: skip


@dataclass(frozen=True)
class Number:
    """One published number of the bench."""

    q: str
    """Label in the table."""
    what: str
    """Quantity."""
    weight_on_bit: float
    """[N]"""
    speed: float
    """[rev/s]"""
    value: float
    """Value [unit]."""
    unit: str
    where: str
    """Place in the paper."""
    mark: str = ""
    """Mark of the number; empty where it has none."""
    doubt: str = ""
    """Uncertainty of the number."""

    @property
    def name(self) -> str:
        """Unique name, as `critical time, 20 N, 2 rev/s`."""
        mark = f" {self.mark}" if self.mark else ""
        return f"{self.what}{mark}, {self.weight_on_bit:g} N, {self.speed:g} rev/s"

    @property
    def case(self) -> Case:
        """Run that it is of."""
        return Case(self.weight_on_bit, self.speed)

    def shown(self, value: float) -> str:
        """A value of this quantity with its unit."""
        return f"{value:.3g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Range:
    """One published value or range of the full-size assembly or of the surge; a single value has low = high."""

    q: str
    what: str
    low: float
    high: float
    unit: str
    where: str


@dataclass(frozen=True)
class Published:
    """All published numbers."""

    bench: tuple[Number, ...]
    surge: Range
    """Speeds of the steep rise of the whirl frequency [rev/s]."""
    similarity: float
    """Speed in the field per speed of the rod [r/min per rev/s]."""
    full_size: tuple[Range, ...]


@cache
def published() -> Published:
    """Read the published numbers.

    Raises:
        SceneError: The file is missing or invalid.
    """
    file = CONFIG / "paper" / "published.yaml"
    try:
        data = plain_yaml(file.read_text("utf-8"))
        return Published(
            tuple(Number(**{**row, "value": float(row["value"])}) for row in data["bench"]),
            _range({"what": "surge", **data["surge"]}),
            float(data["similarity"]["factor"]),
            tuple(_range(row) for row in data["full_size"]),
        )
    except (OSError, YamlError, KeyError, TypeError, ValueError) as error:
        raise SceneError(f"{file}: expected the published numbers of the paper, found {error!r}; reinstall") from error


def _range(row: dict[str, Any]) -> Range:
    low, high = (row["value"],) * 2 if "value" in row else (row["low"], row["high"])
    return Range(row["q"], row["what"], float(low), float(high), row["unit"], row["where"])
