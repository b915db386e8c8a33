# SPDX-License-Identifier: Apache-2.0
"""Motion of the bit and its stick-slip, detected on the stream from the speeds of bit and top drive.

The motion is that of the stick-slip index (`stick_slip_index`). Cycles date it: the speed, low-passed at 15 Hz by two
equal poles, oscillates about its own slow mean. A cycle runs from one crossing of the mean plus a quarter to the next,
once the speed has been below the mean less a quarter in between; crossings are interpolated. Its severity is the same
index, over the cycle. Two cycles in a row with a severity of 1 start a period of stick-slip; two others in a row, or
three periods without a cycle, end it. The start-up has no cycles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import as_python, copy, strict_kernel
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.findings import StickSlipPeriod
from drill_twin.whirl.motion.stick_slip_index import CYCLES as WINDOW_CYCLES
from drill_twin.whirl.motion.stick_slip_index import (
    CYCLES_SEEN,
    FULL,
    INDEX,
    LARGEST,
    MODERATE,
    MOTION,
    SETTLED,
    TIME_BASE,
    TURNING,
    WINDOW_FASTEST,
    WINDOW_MEAN,
    WINDOW_SLOWEST,
    SpeedWindow,
    add_speeds,
    restart,
)

CORNER = 15.0
"""Corner frequency of each pole of the low-pass [Hz]."""
MEAN_MEMORY, CYCLES, LONGEST_MEMORY = 3.0, 4.0, 60.0
"""Memory of the slow mean: four cycles, at least 3 s and at most 60 s."""
BAND = 0.25
"""Half width of the band that a cycle must cross, over the mean."""
IN_A_ROW = 2
"""Equal cycles in a row that begin or end a period of stick-slip."""
QUIET = 3.0
"""Periods without a cycle after which a period of stick-slip is over."""
LONGEST_GAP = 0.5
"""Longest interval between samples within a cycle [s]."""
LARGEST_COUNT = 2000
"""Largest number of periods stored."""


_MOTIONS = (
    BitMotion.AT_REST, BitMotion.STARTING, BitMotion.STANDS, BitMotion.STEADY, BitMotion.VIBRATION,
    BitMotion.STICK_SLIP,
)  # fmt: skip
"""In the order of the codes of `stick_slip_index`."""


class _Cycle(NamedTuple):
    start: float
    end: float
    slowest: float
    fastest: float
    fell: float
    area: float
    span: float


FIRST, LAST, POLE, SECOND_POLE, MEAN, PERIOD = range(6)
"""Indices into `BitSpeed.numbers`: first time since the filters began and last time [s]; the poles of the low-pass and
the slow mean [rad/s]; length of the last cycle [s], nan without one."""
CYCLE_START, CYCLE_END, SLOWEST, FASTEST, FELL, AREA, SPAN = range(7)
"""Indices into a cycle: times [s]; speeds of the bit, low-passed [rad/s]; 1 after a fall below the band; integral of
the speed [rad] over a time [s]."""
SAMPLES, IN_CYCLE, NO_TOP = range(3)
"""Indices into `BitSpeed.counts`: samples, 1 in a cycle, 1 if the speed of the top drive is that of the bit."""
NOTHING, JUDGED, COMPLETED, STOPPED = range(4)
"""Outcome of a sample: nothing to decide, the motion has changed, a cycle is complete, there have been no cycles."""


class BitSpeed(NamedTuple):
    """Low-passed speed of the bit and its present cycle."""

    numbers: Array
    counts: Integers
    cycle: Array
    complete: Array  # the cycle that was completed last
    window: SpeedWindow

    @classmethod
    def empty(cls, *, top_known: bool) -> BitSpeed:
        """Before the first sample."""
        numbers, counts = np.array([math.nan, math.nan, 0.0, 0.0, 0.0, math.nan]), np.array([0, 0, not top_known])
        cycle, complete = np.zeros((2, 7))
        return cls(numbers, counts, cycle, complete, SpeedWindow.empty())


@strict_kernel
def add_bit_speed(bit: BitSpeed, time: float, bit_speed: float, top_speed: float) -> int:
    """Add the speeds of bit and top drive [rad/s] at a time [s]; a bit's that is not finite or not later is ignored.

    Returns:
        What `StickSlip.decide` has to decide.
    """
    numbers, counts, window = bit.numbers, bit.counts, bit.window
    if not math.isfinite(bit_speed) or (counts[SAMPLES] and time <= numbers[LAST]):
        return NOTHING
    counts[SAMPLES] += 1
    step = time - numbers[LAST]
    numbers[LAST] = time
    if counts[SAMPLES] == 1 or step > LONGEST_GAP:
        numbers[POLE] = numbers[SECOND_POLE] = bit_speed
        restart(window)
        return JUDGED
    before = numbers[SECOND_POLE]
    gain = 1.0 - math.exp(-math.tau * CORNER * step)
    numbers[POLE] += gain * (bit_speed - numbers[POLE])
    numbers[SECOND_POLE] += gain * (numbers[POLE] - numbers[SECOND_POLE])
    turned = window.counts[TURNING]
    changed = add_speeds(window, time, numbers[SECOND_POLE], math.nan if counts[NO_TOP] else top_speed)
    outcome = NOTHING
    if window.counts[TURNING]:
        if not turned:
            # The slow mean begins at the speed that the bit follows.
            numbers[FIRST], numbers[PERIOD], counts[IN_CYCLE] = time - MEAN_MEMORY, math.nan, 0
            numbers[MEAN] = bit_speed if counts[NO_TOP] or not math.isfinite(top_speed) else top_speed
        # Until a cycle is complete, the mean is that of all samples; afterwards it fades over several cycles.
        period = numbers[PERIOD] if math.isfinite(numbers[PERIOD]) else LONGEST_MEMORY
        memory = max(min(max(MEAN_MEMORY, CYCLES * period), LONGEST_MEMORY, time - numbers[FIRST]), step)
        numbers[MEAN] += (bit_speed - numbers[MEAN]) * (1.0 - math.exp(-step / memory))
        sense = math.copysign(1.0, numbers[MEAN])
        outcome = _track_cycle(bit, sense * before, sense * numbers[SECOND_POLE], step)
    return JUDGED if changed and outcome == NOTHING else outcome


@strict_kernel
def _track_cycle(bit: BitSpeed, before: float, now: float, step: float) -> int:
    """Check the low-passed speed [rad/s], before and now, for the start and end of a cycle."""
    cycle, counts, time, mean = bit.cycle, bit.counts, bit.numbers[LAST], abs(bit.numbers[MEAN])
    within = counts[IN_CYCLE] != 0
    if within:
        cycle[SLOWEST], cycle[FASTEST] = min(cycle[SLOWEST], now), max(cycle[FASTEST], now)
        cycle[AREA] += step * now
        cycle[SPAN] += step
        if now < (1.0 - BAND) * mean:
            cycle[FELL] = 1.0
    rise = (1.0 + BAND) * mean
    if before < rise <= now and (not within or cycle[FELL]):
        start = time - step * (now - rise) / (now - before)
        if within:
            cycle[CYCLE_END] = start
            copy(cycle, bit.complete)
            bit.numbers[PERIOD] = start - cycle[CYCLE_START]
            bit.window.counts[WINDOW_CYCLES] += 1
        cycle[CYCLE_START], cycle[SLOWEST], cycle[FASTEST], cycle[FELL] = start, now, now, 0.0
        cycle[AREA] = cycle[SPAN] = 0.0
        counts[IN_CYCLE] = 1
        return COMPLETED if within else NOTHING
    if within and time - cycle[CYCLE_START] > QUIET * bit.numbers[PERIOD]:
        counts[IN_CYCLE] = 0
        return STOPPED
    return NOTHING


class StickSlip:
    """Motion of the bit, and its periods of stick-slip."""

    def __init__(self, *, top_known: bool = True) -> None:
        """Begin before the first sample; `top_known`: the speed of the top drive is measured by itself."""
        self.speed = BitSpeed.empty(top_known=top_known)
        """Speed of the bit: low-passed, its window and its present cycle."""
        self.motion = BitMotion.UNKNOWN
        """Present motion of the bit."""
        self.criterion = "no speed of the bit so far"
        """The criterion that decided it, as text."""
        self.periods: list[StickSlipPeriod] = []
        """Periods of stick-slip so far; the last one grows while it lasts."""
        self._sticks = self._lasts = False  # the last cycle; a period
        self._repeats = 0
        self._pending: StickSlipPeriod | None = None

    @property
    def samples(self) -> int:
        """Samples with a speed of the bit."""
        return int(self.speed.counts[SAMPLES])

    @property
    def index(self) -> float:
        """Stick-slip index over the last 20 s; nan while it is not known."""
        return float(self.speed.window.numbers[INDEX])

    @property
    def largest_index(self) -> float:
        """Largest index so far; nan while none was known."""
        return float(self.speed.window.numbers[LARGEST])

    def push(self, time: float, bit_speed: float, top_speed: float = math.nan) -> None:
        """Add the speeds of bit and top drive [rad/s] at a time [s]; nan for an unknown speed of the top drive.

        A speed of the bit that is not finite or not later is ignored.
        """
        if outcome := as_python(add_bit_speed)(self.speed, time, bit_speed, top_speed):
            self.decide(outcome)

    def decide(self, outcome: int) -> None:
        """Decide on motion and periods after a sample with this outcome."""
        if outcome == COMPLETED:
            self._complete(_Cycle(*self.speed.complete.tolist()))
        elif outcome == STOPPED:
            self._pending, self._repeats, self._lasts = None, 0, False
        motion = _MOTIONS[self.speed.window.counts[MOTION]]
        if motion is not self.motion:
            self.motion, self.criterion = motion, self._criterion(motion)
        if not self.speed.window.counts[TURNING]:
            self._pending, self._repeats, self._lasts = None, 0, False

    def _criterion(self, motion: BitMotion) -> str:
        """Text of what decided a motion."""
        if motion is BitMotion.AT_REST:
            return "the top drive does not turn"
        if motion is BitMotion.STARTING:
            return f"an index needs {SETTLED} s or {CYCLES_SEEN} cycles after the bit has come up to speed"
        numbers = self.speed.window.numbers
        if motion is BitMotion.STANDS:
            return f"mean speed {numbers[WINDOW_MEAN]:.2f} rad/s while the top drive turns"
        bound = {BitMotion.STEADY: f"below {MODERATE:g}", BitMotion.VIBRATION: f"{MODERATE:g} to {FULL:g}"}
        return (
            f"stick-slip index {self.index:.2f}, {bound.get(motion, f'at least {FULL:g}')}: "
            f"{numbers[WINDOW_SLOWEST]:.2f} to {numbers[WINDOW_FASTEST]:.2f} rad/s in at most {TIME_BASE} s"
        )

    def _complete(self, cycle: _Cycle) -> None:
        """Add a completed cycle to its period of stick-slip, or end one."""
        mean = cycle.area / cycle.span
        severity = (cycle.fastest - cycle.slowest) / (2.0 * mean) if mean > 0.0 else math.inf
        sticks = FULL <= severity < math.inf
        self._repeats = self._repeats + 1 if sticks is self._sticks else 1
        self._sticks = sticks
        if sticks:
            self._add_cycle(cycle, severity)
        elif self._repeats >= IN_A_ROW:
            self._pending, self._lasts = None, False

    def _add_cycle(self, cycle: _Cycle, severity: float) -> None:
        """Add a cycle that sticks to its period of stick-slip."""
        length = cycle.end - cycle.start
        one = StickSlipPeriod(cycle.start, cycle.end, 1, length, length, length, cycle.slowest, cycle.fastest, severity)
        if self._lasts:
            self.periods[-1] = _joined(self.periods[-1], one)
        elif self._repeats == 1 or self._pending is None:
            self._pending = one
        elif len(self.periods) < LARGEST_COUNT:
            self.periods.append(_joined(self._pending, one))
            self._lasts = True


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
