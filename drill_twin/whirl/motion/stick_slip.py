# SPDX-License-Identifier: Apache-2.0
"""Stick-slip of the bit, detected on the stream from its speed alone.

The speed, low-passed at 15 Hz by two equal poles, oscillates about its own slow mean. A cycle runs from one crossing of
the mean plus a quarter to the next, once the speed has been below the mean less a quarter in between; crossings are
interpolated. The severity of a cycle is (fastest - slowest) / (2 mean), the stick-slip index of Pavone and Desplans
(1994). A cycle sticks when its severity is above 0.8 and its slowest speed below 0.15 of the mean. Two such cycles in a
row start stick-slip; two others in a row, or three periods without a cycle, end it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

CORNER = 15.0
"""Corner frequency of each pole of the low-pass [Hz]."""
MEAN_MEMORY, CYCLES, LONGEST_MEMORY = 3.0, 4.0, 60.0
"""Memory of the slow mean: four cycles, at least 3 s and at most 60 s."""
BAND = 0.25
"""Half width of the band that a cycle must cross, over the mean."""
SEVERE, STICKING = 0.8, 0.15
"""Smallest severity and largest slowest speed, over the mean, of a cycle that sticks."""
UNSTEADY = 0.3
"""Cycles of smaller severity are steady rotation."""
IN_A_ROW = 2
"""Equal cycles in a row that change the state."""
QUIET = 3.0
"""Periods without a cycle after which the rotation is steady."""
LONGEST_GAP = 0.5
"""Longest interval between samples within a cycle [s]."""
LARGEST_COUNT = 2000
"""Largest number of periods stored."""


class BitMotion(Enum):
    """Motion of the bit."""

    UNKNOWN = "not observable"
    """No speed of the bit was given."""
    STEADY = "steady rotation"
    """No cycles, or cycles of small severity."""
    VIBRATION = "torsional vibration"
    """Cycles that do not stick."""
    STICK_SLIP = "stick-slip"
    """Cycles in which the bit nearly stands still."""


@dataclass(frozen=True)
class StickSlipPeriod:
    """Period of stick-slip."""

    start_s: float
    """Start of its first cycle [s]."""
    end_s: float
    """End of its last cycle [s]."""
    cycles: int
    """Cycles in it."""
    period_s: float
    """Mean length of a cycle [s]."""
    shortest_s: float
    longest_s: float
    """Shortest and longest cycle [s]."""
    slowest_rad_s: float
    fastest_rad_s: float
    """Slowest and fastest speed of the bit, low-passed [rad/s]."""
    severity: float
    """Mean of (fastest - slowest) / (2 mean) over its cycles."""

    @property
    def frequency_hz(self) -> float:
        """Frequency of the cycles [Hz]."""
        return 1.0 / self.period_s


@dataclass
class _Cycle:
    start: float
    slowest: float = math.inf
    fastest: float = -math.inf
    fell: bool = False


class StickSlip:
    """Detector of stick-slip in the speed of the bit."""

    def __init__(self) -> None:
        self.motion = BitMotion.UNKNOWN
        """Present motion of the bit."""
        self.criterion = "no speed of the bit so far"
        """The criterion that decided it, as text."""
        self.periods: list[StickSlipPeriod] = []
        """Periods of stick-slip so far; the last one grows while it lasts."""
        self.samples = 0
        """Samples with a speed of the bit."""
        self._first = self._last = math.nan
        self._poles = [0.0, 0.0]
        self._mean = 0.0
        self._cycle: _Cycle | None = None
        self._last_class = BitMotion.UNKNOWN
        self._repeats = 0
        self._pending: StickSlipPeriod | None = None
        self._period = math.nan
        self._full = False

    def push(self, time: float, bit_speed: float) -> None:
        """Add the speed of the bit [rad/s] at a time [s]; values that are not finite or not later are ignored."""
        if not math.isfinite(bit_speed) or (self.samples and time <= self._last):
            return
        self.samples += 1
        step = time - self._last
        self._last = time
        if self.samples == 1 or step > LONGEST_GAP:
            self._restart(time, bit_speed)
            return
        before, poles = self._poles[1], self._poles
        gain = 1.0 - math.exp(-math.tau * CORNER * step)
        poles[0] += gain * (bit_speed - poles[0])
        poles[1] += gain * (poles[0] - poles[1])
        # Until a cycle is complete, the mean is that of all samples; afterwards it fades over several cycles.
        period = self._period if math.isfinite(self._period) else LONGEST_MEMORY
        memory = max(min(max(MEAN_MEMORY, CYCLES * period), LONGEST_MEMORY, time - self._first), step)
        self._mean += (bit_speed - self._mean) * (1.0 - math.exp(-step / memory))
        sense = math.copysign(1.0, self._mean)
        self._track_cycle(sense * before, sense * poles[1], time, step)

    def _restart(self, time: float, bit_speed: float) -> None:
        """Restart with the first sample, or after a pause."""
        self._first, self._poles, self._mean, self._cycle = time, [bit_speed, bit_speed], bit_speed, None
        self._period = math.nan
        self._reset_count()
        self._set(BitMotion.STEADY, "no cycle so far")

    def _track_cycle(self, before: float, now: float, time: float, step: float) -> None:
        """Check the low-passed speed [rad/s], before and now, for the start and end of a cycle."""
        mean, cycle = abs(self._mean), self._cycle
        if cycle is not None:
            cycle.slowest, cycle.fastest = min(cycle.slowest, now), max(cycle.fastest, now)
            cycle.fell = cycle.fell or now < (1.0 - BAND) * mean
        rise = (1.0 + BAND) * mean
        if before < rise <= now and (cycle is None or cycle.fell):
            start = time - step * (now - rise) / (now - before)
            if cycle is not None:
                self._complete(cycle, start, mean)
            self._cycle = _Cycle(start, now, now)
        elif cycle is not None and time - cycle.start > QUIET * self._period and self.motion is not BitMotion.STEADY:
            self._reset_count()
            self._set(BitMotion.STEADY, f"no cycle for {QUIET:.0f} periods, mean speed {mean:.2f} rad/s")

    def _complete(self, cycle: _Cycle, end: float, mean: float) -> None:
        """Classify a completed cycle."""
        self._period = end - cycle.start
        severity = (cycle.fastest - cycle.slowest) / (2.0 * mean)
        if severity > SEVERE and cycle.slowest < STICKING * mean:
            motion = BitMotion.STICK_SLIP
        else:
            motion = BitMotion.VIBRATION if severity > UNSTEADY else BitMotion.STEADY
        self._repeats = self._repeats + 1 if motion is self._last_class else 1
        self._last_class = motion
        if motion is BitMotion.STICK_SLIP:
            self._add_cycle(cycle, end, severity)
        elif self._repeats >= IN_A_ROW:
            self._pending = None
        if self._repeats >= IN_A_ROW:
            text = (
                f"cycles of {self._period:.3f} s, from {cycle.slowest:.2f} to {cycle.fastest:.2f} rad/s, "
                f"severity {severity:.2f}"
            )
            self._set(motion, text)

    def _add_cycle(self, cycle: _Cycle, end: float, severity: float) -> None:
        """Add a cycle that sticks to its period of stick-slip."""
        one = StickSlipPeriod(
            cycle.start, end, 1, self._period, self._period, self._period, cycle.slowest, cycle.fastest, severity
        )
        if self.motion is BitMotion.STICK_SLIP and self.periods and not self._full:
            self.periods[-1] = _joined(self.periods[-1], one)
        elif self._repeats == 1 or self._pending is None:
            self._pending = one
        elif len(self.periods) < LARGEST_COUNT:
            self.periods.append(_joined(self._pending, one))
        else:
            self._full = True

    def _reset_count(self) -> None:
        self._pending, self._repeats = None, 0

    def _set(self, motion: BitMotion, criterion: str) -> None:
        if motion is not self.motion:
            self.motion, self.criterion = motion, criterion


def _joined(one: StickSlipPeriod, other: StickSlipPeriod) -> StickSlipPeriod:
    """Merge a period and the cycles that follow it."""
    cycles = one.cycles + other.cycles
    return StickSlipPeriod(
        one.start_s,
        other.end_s,
        cycles,
        (one.cycles * one.period_s + other.cycles * other.period_s) / cycles,
        min(one.shortest_s, other.shortest_s),
        max(one.longest_s, other.longest_s),
        min(one.slowest_rad_s, other.slowest_rad_s),
        max(one.fastest_rad_s, other.fastest_rad_s),
        (one.cycles * one.severity + other.cycles * other.severity) / cycles,
    )
