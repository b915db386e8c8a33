# SPDX-License-Identifier: Apache-2.0
"""Soundness of a rig's signal: its value, stamp and unit, judged at each reading."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drill_twin.core.units.registry import UnitError, si_factor
from drill_twin.gateway.signals import RigSignal

_AHEAD = 2.0  # s by which a stamp may be later than the clock of this machine


@dataclass(frozen=True)
class CheckedValue:
    """Reading of a node."""

    value: object
    """Value as the server gave it."""
    status: str
    """Name of a status that is not good; empty for a good one."""
    stamp: float
    """Source timestamp [s since 1970]; NaN without one."""


@dataclass(frozen=True)
class Judged:
    """Value with the verdict on it."""

    value: float = math.nan
    """Value [SI]; NaN if it is not sound."""
    stamp: float = math.nan
    """Source timestamp, or time of the reading where the server gives none [s since 1970]."""
    fault: str = "no value yet"
    """Reason why it is not used; empty if it is sound."""


class SoundnessCheck:
    """Judges one signal."""

    def __init__(self, signal: RigSignal) -> None:
        self._signal = signal
        self._last: float | None = None
        self._changed = 0.0

    def judge(self, reading: CheckedValue, now: float) -> Judged:
        """Judge a reading at a time [s since 1970]."""
        fault = self._fault(reading, now)
        if fault or not isinstance(reading.value, int | float):
            return Judged(fault=fault)
        stamp = reading.stamp if math.isfinite(reading.stamp) else now
        return Judged(float(reading.value) * self._signal.factor, stamp, "")

    def _fault(self, reading: CheckedValue, now: float) -> str:
        signal, value = self._signal, reading.value
        if reading.status:
            return f"status {reading.status}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            return f"expected a number, found {type(value).__name__}"
        if not math.isfinite(value):
            return f"expected a finite number, found {value}"
        if not signal.low <= value <= signal.high:
            return f"expected {signal.low:g} to {signal.high:g} {signal.unit}, found {value:g}"
        if signal.stale_after and not math.isfinite(reading.stamp):
            return "no source timestamp"
        if signal.stale_after and now - reading.stamp > signal.stale_after:
            return "stale stamp"
        if reading.stamp - now > _AHEAD:
            return "stamp in the future"
        return self._frozen(float(value), now)

    def _frozen(self, value: float, now: float) -> str:
        if value != self._last:
            self._last, self._changed = value, now
        frozen = 0.0 < self._signal.frozen_after <= now - self._changed
        return f"frozen for more than {self._signal.frozen_after:g} s" if frozen else ""


def unit_fault(signal: RigSignal, found: str) -> str:
    """Reason why the unit that a server gives to a signal is not that of its line; empty if it is.

    Args:
        signal: The signal.
        found: Text of the unit on the server; empty where it gives none.
    """
    if not found:
        return ""
    try:
        same = si_factor(found) == si_factor(signal.unit)
    except UnitError:
        same = False
    return "" if same else f"wrong unit: expected {signal.unit}, found {found} on the server"
