# SPDX-License-Identifier: Apache-2.0
"""Ranges of numbers as they are typed, the same in each command and argument: `LO..HI[:N] UNIT`."""

import math
import re
from typing import NamedTuple

import numpy as np

from drill_twin.core.errors import ArgumentError
from drill_twin.core.units.dimension import DIMENSIONLESS
from drill_twin.core.units.parse import short, split
from drill_twin.core.units.registry import UnitError

_COUNT = re.compile(r":\s*(\d{1,6})(?=\s|$)", re.ASCII)


class Range(NamedTuple):
    """Range of a number, with the unit of both ends."""

    low: float
    high: float
    unit: str = ""
    number: int = 0
    """Points over the range; 0: left open."""

    @property
    def ends(self) -> tuple[str, str]:
        """Both ends as text with their unit."""
        return f"{self.low!r} {self.unit}".strip(), f"{self.high!r} {self.unit}".strip()

    def points(self, number: int) -> list[float]:
        """Equally spaced numbers, as many as the range states, else `number` of them."""
        found: list[float] = np.linspace(self.low, self.high, self.number or number).tolist()
        return found


def parse_range(name: str, text: str) -> Range:
    """Parse a text such as `1..300 N` or `0.15..0.35:5`; the unit may stand at both ends.

    Args:
        name: Name of the argument, for the message.
        text: The range.

    Raises:
        ArgumentError: The text is no range, or its ends are not in order; equal ends are a range of one point.
    """
    counted = _COUNT.search(text)
    low, dots, high = _COUNT.sub("", text).partition("..")
    number = int(counted[1]) if counted else 0
    try:
        (first, begin), (last, end) = split(low, DIMENSIONLESS), split(high, DIMENSIONLESS)
    except UnitError:
        first, begin, last, end = math.nan, "", math.nan, ""
    ordered = -math.inf < first < last < math.inf or (first == last and number == 1)
    if not (dots and ordered and begin in {"", end} and (number or not counted) and number <= 10_000):
        raise ArgumentError(
            f'{name}: expected LO..HI or LO..HI:N with LO below HI and a unit, such as "1..300 N", '
            f'found "{short(text)}"'
        )
    return Range(first, last, end, number)
