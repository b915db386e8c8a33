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
from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.exact_jit import Integers, copy, exact_kernel
from drill_twin.base.jit import as_python

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


class _Cycle(NamedTuple):
    start: float
    end: float
    slowest: float
    fastest: float
    fell: float


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


FIRST, LAST, POLE, SECOND_POLE, MEAN, PERIOD = range(6)
"""Indices into `BitSpeed.numbers`: first time since the filters began and last time [s]; the poles of the low-pass and
the slow mean [rad/s]; length of the last cycle [s], nan without one."""
CYCLE_START, CYCLE_END, SLOWEST, FASTEST, FELL = range(5)
"""Indices into a cycle: times [s], speeds of the bit, low-passed [rad/s], and 1 after a fall below the band."""
SAMPLES, IN_CYCLE, UNSTEADY_NOW = range(3)
"""Indices into `BitSpeed.counts`: samples, 1 in a cycle, 1 while the motion is not steady."""
NOTHING, RESTARTED, COMPLETED, STOPPED = range(4)
"""Outcome of a sample: nothing to decide, the filters began anew, a cycle is complete, there have been no cycles."""


class BitSpeed(NamedTuple):
    """Low-passed speed of the bit and its present cycle."""

    numbers: Array
    counts: Integers
    cycle: Array
    complete: Array  # the cycle that was completed last

    @classmethod
    def empty(cls) -> BitSpeed:
        """Before the first sample."""
        return cls(np.array([math.nan, math.nan, 0.0, 0.0, 0.0, math.nan]), np.zeros(3, np.int64), *np.zeros((2, 5)))


@exact_kernel
def add_bit_speed(bit: BitSpeed, time: float, bit_speed: float) -> int:
    """Add the speed of the bit [rad/s] at a time [s]; values that are not finite or not later are ignored.

    Returns:
        What `StickSlip.decide` has to decide.
    """
    numbers, counts = bit.numbers, bit.counts
    if not math.isfinite(bit_speed) or (counts[SAMPLES] and time <= numbers[LAST]):
        return NOTHING
    counts[SAMPLES] += 1
    step = time - numbers[LAST]
    numbers[LAST] = time
    if counts[SAMPLES] == 1 or step > LONGEST_GAP:
        numbers[FIRST], numbers[PERIOD] = time, math.nan
        numbers[POLE] = numbers[SECOND_POLE] = numbers[MEAN] = bit_speed
        counts[IN_CYCLE] = 0
        return RESTARTED
    before = numbers[SECOND_POLE]
    gain = 1.0 - math.exp(-math.tau * CORNER * step)
    numbers[POLE] += gain * (bit_speed - numbers[POLE])
    numbers[SECOND_POLE] += gain * (numbers[POLE] - numbers[SECOND_POLE])
    # Until a cycle is complete, the mean is that of all samples; afterwards it fades over several cycles.
    period = numbers[PERIOD] if math.isfinite(numbers[PERIOD]) else LONGEST_MEMORY
    memory = max(min(max(MEAN_MEMORY, CYCLES * period), LONGEST_MEMORY, time - numbers[FIRST]), step)
    numbers[MEAN] += (bit_speed - numbers[MEAN]) * (1.0 - math.exp(-step / memory))
    sense = math.copysign(1.0, numbers[MEAN])
    return _track_cycle(bit, sense * before, sense * numbers[SECOND_POLE], step)


@exact_kernel
def _track_cycle(bit: BitSpeed, before: float, now: float, step: float) -> int:
    """Check the low-passed speed [rad/s], before and now, for the start and end of a cycle."""
    cycle, counts, time, mean = bit.cycle, bit.counts, bit.numbers[LAST], abs(bit.numbers[MEAN])
    within = counts[IN_CYCLE] != 0
    if within:
        cycle[SLOWEST], cycle[FASTEST] = min(cycle[SLOWEST], now), max(cycle[FASTEST], now)
        if now < (1.0 - BAND) * mean:
            cycle[FELL] = 1.0
    rise = (1.0 + BAND) * mean
    if before < rise <= now and (not within or cycle[FELL]):
        start = time - step * (now - rise) / (now - before)
        if within:
            cycle[CYCLE_END] = start
            copy(cycle, bit.complete)
            bit.numbers[PERIOD] = start - cycle[CYCLE_START]
        cycle[CYCLE_START], cycle[SLOWEST], cycle[FASTEST], cycle[FELL] = start, now, now, 0.0
        counts[IN_CYCLE] = 1
        return COMPLETED if within else NOTHING
    if within and time - cycle[CYCLE_START] > QUIET * bit.numbers[PERIOD] and counts[UNSTEADY_NOW]:
        return STOPPED
    return NOTHING


class StickSlip:
    """Detector of stick-slip in the speed of the bit."""

    def __init__(self) -> None:
        self.speed = BitSpeed.empty()
        """Low-passed speed of the bit."""
        self.motion = BitMotion.UNKNOWN
        """Present motion of the bit."""
        self.criterion = "no speed of the bit so far"
        """The criterion that decided it, as text."""
        self.periods: list[StickSlipPeriod] = []
        """Periods of stick-slip so far; the last one grows while it lasts."""
        self._last_class = BitMotion.UNKNOWN
        self._repeats = 0
        self._pending: StickSlipPeriod | None = None
        self._full = False

    @property
    def samples(self) -> int:
        """Samples with a speed of the bit."""
        return int(self.speed.counts[SAMPLES])

    def push(self, time: float, bit_speed: float) -> None:
        """Add the speed of the bit [rad/s] at a time [s]; values that are not finite or not later are ignored."""
        self.decide(as_python(add_bit_speed)(self.speed, time, bit_speed))

    def decide(self, outcome: int) -> None:
        """Decide on the motion after a sample with this outcome."""
        mean = abs(float(self.speed.numbers[MEAN]))
        if outcome == RESTARTED:
            self._reset_count()
            self._set(BitMotion.STEADY, "no cycle so far")
        elif outcome == COMPLETED:
            self._complete(_Cycle(*self.speed.complete.tolist()), mean)
        elif outcome == STOPPED:
            self._reset_count()
            self._set(BitMotion.STEADY, f"no cycle for {QUIET:.0f} periods, mean speed {mean:.2f} rad/s")

    def _complete(self, cycle: _Cycle, mean: float) -> None:
        """Classify a completed cycle."""
        severity = (cycle.fastest - cycle.slowest) / (2.0 * mean)
        if severity > SEVERE and cycle.slowest < STICKING * mean:
            motion = BitMotion.STICK_SLIP
        else:
            motion = BitMotion.VIBRATION if severity > UNSTEADY else BitMotion.STEADY
        self._repeats = self._repeats + 1 if motion is self._last_class else 1
        self._last_class = motion
        if motion is BitMotion.STICK_SLIP:
            self._add_cycle(cycle, severity)
        elif self._repeats >= IN_A_ROW:
            self._pending = None
        if self._repeats >= IN_A_ROW:
            text = (
                f"cycles of {cycle.end - cycle.start:.3f} s, from {cycle.slowest:.2f} to {cycle.fastest:.2f} rad/s, "
                f"severity {severity:.2f}"
            )
            self._set(motion, text)

    def _add_cycle(self, cycle: _Cycle, severity: float) -> None:
        """Add a cycle that sticks to its period of stick-slip."""
        length = cycle.end - cycle.start
        one = StickSlipPeriod(cycle.start, cycle.end, 1, length, length, length, cycle.slowest, cycle.fastest, severity)
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
            self.speed.counts[UNSTEADY_NOW] = motion is not BitMotion.STEADY


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
