# SPDX-License-Identifier: Apache-2.0
"""Channels of the rig over the last half hour, as least, mean and largest value of each quarter of a second."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any

CHANNELS = ("wob", "rps", "bit_rps", "torque", "hookload", "rop")
"""Weight on bit [N], speed of top drive and bit [rev/s], torque [N m], hookload [N], rate of penetration [m/s]."""
SECONDS = 0.25
"""Length of an interval [s of simulated time]."""
_MOST = round(1800.0 / SECONDS)
_AGAIN = 8  # intervals sent twice, for a page that missed a snapshot

Row = list[float | None]


class Trends:
    """Intervals of one run; a row is its number, then least, mean and largest value of each channel."""

    def __init__(self, most: int = _MOST) -> None:
        self._rows: deque[Row] = deque(maxlen=most)
        self._present = math.nan
        self._low: list[float] = []
        self._sum: list[float] = []
        self._high: list[float] = []
        self._counts: list[int] = []
        self._sent = 0
        self.run = 0
        """Number of the run; time that goes back begins another."""

    def clear(self) -> None:
        """Begin another run."""
        self._rows.clear()
        self._present, self._sent = math.nan, 0
        self.run += 1

    def push(self, time: float, values: Mapping[str, float]) -> None:
        """Add the values of an instant [s]; a channel that is missing or not finite has no value."""
        place = math.floor(time / SECONDS + 1e-6)
        if place != self._present:
            if place < self._present:
                self.clear()
            else:
                self._close()
            count = len(CHANNELS)
            self._present = place
            self._low, self._high = [math.inf] * count, [-math.inf] * count
            self._sum, self._counts = [0.0] * count, [0] * count
        for k, name in enumerate(CHANNELS):
            value = values.get(name, math.nan)
            if math.isfinite(value):
                self._low[k], self._high[k] = min(self._low[k], value), max(self._high[k], value)
                self._sum[k] += value
                self._counts[k] += 1

    def _close(self) -> None:
        if math.isnan(self._present):
            return
        row: Row = [self._present]
        for low, total, high, count in zip(self._low, self._sum, self._high, self._counts, strict=True):
            row += [_short(low), _short(total / count), _short(high)] if count else [None, None, None]
        self._rows.append(row)

    def recent(self) -> dict[str, Any]:
        """Rows that are new since the last call, and a few before them."""
        rows, first = [], self._sent - _AGAIN
        for row in reversed(self._rows):
            if (row[0] or 0) < first:
                break
            rows.append(row)
        if self._rows:
            self._sent = int(self._rows[-1][0] or 0)
        return {"run": self.run, "rows": rows[::-1]}

    def all(self) -> dict[str, Any]:
        """All rows, with the names of the channels."""
        return {"run": self.run, "channels": list(CHANNELS), "seconds": SECONDS, "rows": list(self._rows)}


def _short(value: float) -> float:
    return float(f"{value:.6g}")
