# SPDX-License-Identifier: Apache-2.0
"""Motion of the bit and its stick-slip, detected on the stream from the speeds of bit and top drive.

The stick-slip index gives the motion (`stick_slip_index`). Cycles date the motion: the speed, low-passed at 15 Hz by
two equal poles, oscillates about its own slow mean. A cycle runs from one crossing of the mean plus a quarter to the
next, once the speed has been below the mean less a quarter in between; crossings are interpolated. Its severity is the
same index, over the cycle. Two cycles in a row with a severity of 1 start a period of stick-slip; two others in a row,
or three periods without a cycle, end it. The start-up has no cycles.

A swing that nothing feeds dies away: its height falls from cycle to cycle by the same factor, whose logarithm is the
logarithmic decrement (2 pi times the damping ratio). It is the slope of the logarithm of the height over the last
cycles. Where that slope is below 0 beyond `CHANCE`, the height has fallen by `FALLEN` over these cycles and was never
lower since the swing began, the swing is decaying, not stick-slip, whatever its index. The first fall of a swing that
comes and goes (a beat) is not told from a decay.
"""

import math

import numpy as np

from drill_twin.core.compile.jit import as_python, strict_kernel
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.findings import StickSlipPeriod
from drill_twin.whirl.motion.stick_slip_index import (
    CYCLES_SEEN,
    FULL,
    MODERATE,
    SETTLED,
    TIME_BASE,
    add_speeds,
    new_window,
    restart,
)

CORNER = 15.0
"""Corner frequency of each pole of the low-pass [Hz].

The numbers of this file were chosen, not measured by themselves; the bounds of the index follow from its definition."""
MEAN_MEMORY, CYCLES, LONGEST_MEMORY = 3.0, 4.0, 60.0
"""Memory of the slow mean: four cycles, at least 3 s and at most 60 s."""
BAND = 0.25
"""Half width of the band that a cycle must cross, over the mean."""
IN_A_ROW = 2
"""Equal cycles in a row that begin or end a period of stick-slip."""
QUIET = 3.0
"""Periods without a cycle that end a period of stick-slip."""
FEWEST_HEIGHTS, MOST_HEIGHTS = 3, 8
"""Cycles over which the decrement is fitted: a line and a scatter about it; chosen: not much longer than the index."""
CHANCE, FALLEN = 0.01, 0.1
"""A decay: largest chance, in either sense, that scatter alone gives the slope (Student); least logarithm lost."""
LONGEST_GAP = 0.5
"""Longest interval between samples within a cycle [s]."""
LARGEST_COUNT = 2000
"""Largest number of periods stored."""

_MOTIONS = (
    BitMotion.AT_REST, BitMotion.STARTING, BitMotion.STANDS, BitMotion.STEADY, BitMotion.VIBRATION,
    BitMotion.STICK_SLIP, BitMotion.EARLY,
)  # fmt: skip
"""In the order of the codes of `stick_slip_index`."""
SWINGS = (BitMotion.VIBRATION, BitMotion.STICK_SLIP)
"""Motions that are sustained, or not known to decay."""
SMALLEST_HEIGHT = 1e-9
"""Height of a swing whose logarithm is taken [rad/s], far below what a sensor resolves."""

NOTHING, JUDGED, COMPLETED, STOPPED = range(4)
"""Outcome of a sample: nothing to decide, the motion has changed, a cycle is complete, there have been no cycles."""
PRESENT, COMPLETE = range(2)
"""Rows of `cycle`: the present cycle, and the cycle that was completed last."""


def new_bit_speed(*, top_known: bool) -> Columns:
    """Speed of the bit and its present cycle, before the first sample."""
    names = ("start", "end", "slowest", "fastest", "fell", "area", "span")
    return columns(
        "BitSpeed",
        1,
        first=math.nan,  # time since which the slow mean runs [s]
        last=math.nan,  # time of the last sample [s]
        pole=0.0,  # of the low-pass [rad/s]
        speed=0.0,  # low-passed by both poles [rad/s]
        mean=0.0,  # slow mean [rad/s]
        period=math.nan,  # length of the last cycle [s], nan without one
        samples=0,
        in_cycle=False,
        no_top=not top_known,  # the speed of the top drive is the bit's
        # times [s]; speeds [rad/s]; 1 after a fall below the band; integral of the speed [rad] over a time [s]
        cycle=columns("Cycle", 2, **dict.fromkeys(names, 0.0)),
        window=new_window(),
    )


@strict_kernel
def add_bit_speed(bit: Columns, time: float, bit_speed: float, top_speed: float) -> int:
    """Add the speeds of bit and top drive [rad/s] at a time [s].

    A sample whose speed of the bit is not finite, or whose time is not later, is ignored.

    Returns:
        What `StickSlip.decide` has to decide.
    """
    window = bit.window
    if not math.isfinite(bit_speed) or (bit.samples[0] and time <= bit.last[0]):
        return NOTHING
    bit.samples[0] += 1
    step = time - bit.last[0]
    bit.last[0] = time
    if bit.samples[0] == 1 or step > LONGEST_GAP:
        bit.pole[0] = bit.speed[0] = bit_speed
        restart(window)
        return JUDGED
    before = bit.speed[0]
    gain = 1.0 - math.exp(-math.tau * CORNER * step)
    bit.pole[0] += gain * (bit_speed - bit.pole[0])
    bit.speed[0] += gain * (bit.pole[0] - bit.speed[0])
    turned = window.turning[0]
    changed = add_speeds(window, time, bit.speed[0], math.nan if bit.no_top[0] else top_speed)
    outcome = NOTHING
    if window.turning[0]:
        if not turned:
            # The slow mean begins at the speed that the bit follows.
            bit.first[0], bit.period[0], bit.in_cycle[0] = time - MEAN_MEMORY, math.nan, False
            bit.mean[0] = bit_speed if bit.no_top[0] or not math.isfinite(top_speed) else top_speed
        # Until a cycle is complete, the mean is over all samples; afterwards it fades over several cycles.
        period = bit.period[0] if math.isfinite(bit.period[0]) else LONGEST_MEMORY
        memory = max(min(max(MEAN_MEMORY, CYCLES * period), LONGEST_MEMORY, time - bit.first[0]), step)
        bit.mean[0] += (bit_speed - bit.mean[0]) * (1.0 - math.exp(-step / memory))
        sense = math.copysign(1.0, bit.mean[0])
        outcome = _track_cycle(bit, sense * before, sense * bit.speed[0], step)
    return JUDGED if changed and outcome == NOTHING else outcome


@strict_kernel
def _track_cycle(bit: Columns, before: float, now: float, step: float) -> int:
    """Check the low-passed speed [rad/s], before and now, for the start and end of a cycle."""
    cycle, time, mean, within = bit.cycle, bit.last[0], abs(bit.mean[0]), bit.in_cycle[0]
    if within:
        cycle.slowest[0], cycle.fastest[0] = min(cycle.slowest[0], now), max(cycle.fastest[0], now)
        cycle.area[0] += step * now
        cycle.span[0] += step
        if now < (1.0 - BAND) * mean:
            cycle.fell[0] = 1.0
    rise = (1.0 + BAND) * mean
    if before < rise <= now and (not within or cycle.fell[0]):
        start = time - step * (now - rise) / (now - before)
        if within:
            cycle.end[0] = start
            bit.period[0] = start - cycle.start[0]
            for column in cycle:
                column[COMPLETE] = column[PRESENT]
            bit.window.cycles[0] += 1
        cycle.start[0], cycle.slowest[0], cycle.fastest[0] = start, now, now
        cycle.fell[0] = cycle.area[0] = cycle.span[0] = 0.0
        bit.in_cycle[0] = True
        return COMPLETED if within else NOTHING
    if within and time - cycle.start[0] > QUIET * bit.period[0]:
        bit.in_cycle[0] = False
        return STOPPED
    return NOTHING


class StickSlip:
    """Motion of the bit, and its periods of stick-slip."""

    def __init__(self, *, top_known: bool = True) -> None:
        """Begin before the first sample; `top_known`: the speed of the top drive is measured by itself."""
        self.speed = new_bit_speed(top_known=top_known)
        """Speed of the bit: low-passed, its window and its present cycle."""
        self.motion = BitMotion.UNKNOWN
        """Present motion of the bit."""
        self.criterion = "no speed of the bit so far"
        """Criterion that decided the motion, as text."""
        self.periods: list[StickSlipPeriod] = []
        """Periods of stick-slip so far; the last one grows while it lasts."""
        self._sticks = self._lasts = False  # the last cycle; a period
        self._repeats = 0
        self._pending: StickSlipPeriod | None = None
        self._heights: list[tuple[float, float]] = []  # start [s] of the last cycles, log of fastest less slowest
        self._lowest = math.inf  # of all heights of the swing
        self._decays = False

    @property
    def index(self) -> float:
        """Stick-slip index over the last 20 s; nan while it is not known."""
        return float(self.speed.window.index[0])

    @property
    def largest_index(self) -> float:
        """Largest index so far; nan while none was known."""
        return float(self.speed.window.largest[0])

    @property
    def decrement(self) -> tuple[float, float, float] | None:
        """Logarithmic decrement of the swing, its standard error and its chance; None for fewer than three cycles."""
        if len(self._heights) < FEWEST_HEIGHTS:
            return None
        from scipy.special import stdtr  # takes 0.1 s, which a run without stick-slip does not need

        count = len(self._heights)
        (slope, _), covariance = np.polyfit(range(count), [height for _, height in self._heights], 1, cov=True)
        error = math.sqrt(covariance[0, 0])
        return -float(slope), error, 2.0 * float(stdtr(count - 2, -abs(slope) / max(error, 1e-300)))

    def push(self, time: float, bit_speed: float, top_speed: float = math.nan) -> None:
        """Add the speeds of bit and top drive [rad/s] at a time [s]; nan for an unknown speed of the top drive.

        A speed of the bit that is not finite or not later is ignored.
        """
        if outcome := as_python(add_bit_speed)(self.speed, time, bit_speed, top_speed):
            self.decide(outcome)

    def decide(self, outcome: int) -> None:
        """Decide on motion and periods after a sample with this outcome."""
        if outcome == COMPLETED:
            self._complete()
        elif outcome == STOPPED:
            self._forget()
        if not self.speed.window.turning[0]:
            self._forget()
            self._decays = False
        motion = _MOTIONS[self.speed.window.motion[0]]
        if self._decays and motion in SWINGS:
            motion = BitMotion.DECAYING
        if motion is not self.motion:
            self.motion, self.criterion = motion, self._criterion(motion)

    def _forget(self) -> None:
        """Forget the cycles so far; a swing that has died away keeps its name while the index holds it."""
        self._pending, self._repeats, self._lasts = None, 0, False
        self._heights.clear()
        self._lowest = math.inf

    def _criterion(self, motion: BitMotion) -> str:
        """Text of what decided a motion."""
        if motion is BitMotion.AT_REST:
            return "the top drive does not turn"
        if motion in {BitMotion.STARTING, BitMotion.EARLY}:
            return f"an index needs {SETTLED} s or {CYCLES_SEEN} cycles after the bit has come up to speed"
        window = self.speed.window
        if motion is BitMotion.STANDS:
            return f"mean speed {window.mean[0]:.2f} rad/s while the top drive turns"
        bound = {BitMotion.STEADY: f"below {MODERATE:g}", BitMotion.VIBRATION: f"{MODERATE:g} to {FULL:g}"}
        bound |= {BitMotion.STICK_SLIP: f"at least {FULL:g}", BitMotion.DECAYING: "of a swing that dies away"}
        fell = self.decrement
        known = f"decrement {fell[0]:.3f} +- {fell[1]:.3f} a cycle" if fell else "whether it dies away is not known yet"
        return (
            f"stick-slip index {self.index:.2f}, {bound[motion]}: {window.slowest[0]:.2f} to {window.fastest[0]:.2f} "
            f"rad/s in at most {TIME_BASE} s{f'; {known}' if motion in (*SWINGS, BitMotion.DECAYING) else ''}"
        )

    def _complete(self) -> None:
        """Add the completed cycle to its period of stick-slip, or end one."""
        start, end, slowest, fastest, _, area, span = (float(column[COMPLETE]) for column in self.speed.cycle)
        mean, length = area / span, end - start
        severity = (fastest - slowest) / (2.0 * mean) if mean > 0.0 else math.inf
        sticks = FULL <= severity < math.inf
        self._repeats = self._repeats + 1 if sticks is self._sticks else 1
        self._sticks = sticks
        height = math.log(max(fastest - slowest, SMALLEST_HEIGHT))
        self._heights = [*self._heights[1 - MOST_HEIGHTS :], (start, height)]
        self._lowest = min(self._lowest, height)
        fell = self.decrement
        surely = fell is not None and fell[2] < CHANCE and fell[0] * (len(self._heights) - 1) > FALLEN
        self._decays = surely and height == self._lowest
        if self._decays:
            # The first cycles of a swing that dies away are no stick-slip either.
            if self.periods and self.periods[-1].start_s >= self._heights[0][0]:
                self.periods.pop()
            self._pending, self._repeats, self._lasts = None, 0, False
            return
        if sticks:
            self._add_cycle(StickSlipPeriod(start, end, 1, length, length, length, slowest, fastest, severity))
        elif self._repeats >= IN_A_ROW:
            self._pending, self._lasts = None, False

    def _add_cycle(self, one: StickSlipPeriod) -> None:
        """Add a cycle that sticks to its period of stick-slip."""
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
        one.start_s, other.end_s, cycles,
        (one.cycles * one.period_s + other.cycles * other.period_s) / cycles,
        min(one.shortest_s, other.shortest_s),
        max(one.longest_s, other.longest_s),
        min(one.slowest_rad_s, other.slowest_rad_s),
        max(one.fastest_rad_s, other.fastest_rad_s),
        (one.cycles * one.severity + other.cycles * other.severity) / cycles,
    )  # fmt: skip
