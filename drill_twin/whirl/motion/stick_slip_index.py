# SPDX-License-Identifier: Apache-2.0
"""Stick-slip index of the bit over the last 20 s, and the start-up before which it means nothing.

The index is (fastest - slowest) / (2 mean) of the bit's speed in a sliding window (Pavone and Desplans 1994, SPE
28324). A swing about its mean that just reaches standstill has the index 1; half of it has 0.5. Vendors' windows and
classes differ; these two bounds follow from the definition alone.

Rotation from rest winds the string up first: the bit stands, breaks loose and catches up. This start-up is
no stick-slip. It lasts until the top drive no longer gains 2 % in a second and the bit has been as fast as the top
drive. The index is known when the window then holds 10 s or two cycles. Where the samples show neither rest nor a rise
of the top drive, as of a run that begins at speed, there was no start-up, and the motion is too early to tell.
"""

import math

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import as_python, strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns

TIME_BASE = 20
"""Length of the window [s]; two periods of the slowest string, 0.1 Hz."""
SETTLED, CYCLES_SEEN = 10, 2
"""The index is known after so many seconds, a period of the slowest string, or cycles since the start-up; chosen."""
MODERATE, FULL = 0.5, 1.0
"""Index from which the swing is torsional vibration, and stick-slip: half of a swing to standstill, and a swing to
standstill, by the definition of the index."""
REST = math.tau * criteria.REST_ROTATION
"""Slower than this the string is at rest [rad/s]."""
STOPPING = 0.1
"""A top drive slower than this share of its mean is being stopped; chosen, not measured."""
RISE, REACHED = 0.02, 0.95
"""Gain of the top drive in a second while it starts; share of its speed that the bit reaches then; both chosen, not
measured."""
MOST_STUCK = 10
"""Seconds at rest after which a bit without a known top drive has been stopped; chosen, not measured."""

AT_REST, STARTING, STANDS, STEADY, VIBRATION, STICK_SLIP, EARLY = range(7)
"""Codes of the motion."""
NOW = TIME_BASE
"""Row of the second that is being filled."""


def new_window() -> Columns:
    """Extremes and sums of each of the last seconds, before the first sample."""
    names = ("number", "slowest", "fastest", "bit", "top", "samples", "first_top", "last_top")
    return columns(
        "SpeedWindow",
        1,
        index=math.nan,  # nan while it is not known
        largest=math.nan,  # index so far
        rows=columns("Seconds", TIME_BASE + 1, **dict.fromkeys(names, 0.0)),  # the last row is being filled
        slowest=math.nan,  # speed in the window [rad/s]
        fastest=math.nan,  # speed in the window [rad/s]
        mean=math.nan,  # speed in the window [rad/s]
        motion=EARLY,
        turning=False,  # True after the start-up
        seconds=0,  # since the start-up
        cycles=0,  # since the start-up
        resting=0,  # seconds at rest
    )


def stick_slip_index(speed: Array) -> float:
    """Index of speeds [rad/s] over one time base, shape (n,); infinite about a mean of zero, 0 where none changes."""
    slowest, fastest, mean = float(speed.min()), float(speed.max()), abs(float(speed.mean()))
    if slowest == fastest:
        return 0.0
    return as_python(_index)(slowest, fastest, mean) if mean else math.inf


@strict_kernel
def _index(slowest: float, fastest: float, mean: float) -> float:
    return (fastest - slowest) / (2.0 * mean)


@strict_kernel
def restart(window: Columns) -> None:
    """Begin anew, after a gap."""
    window.rows.samples[NOW], window.index[0], window.motion[0] = 0.0, math.nan, EARLY
    window.turning[0] = False
    window.seconds[0] = window.resting[0] = 0


@strict_kernel
def add_speeds(window: Columns, time: float, bit: float, top: float) -> bool:
    """Add the speeds of bit and top drive [rad/s] at a time [s]; an unknown speed of the top drive is nan.

    Returns:
        Whether the motion has changed.
    """
    now, second = window.rows, math.floor(time)
    changed = now.samples[NOW] > 0.0 and now.number[NOW] != second and _close(window)
    if now.samples[NOW] == 0.0 or now.number[NOW] != second:
        now.number[NOW], now.slowest[NOW], now.fastest[NOW], now.first_top[NOW] = second, bit, bit, top
        now.bit[NOW] = now.top[NOW] = now.samples[NOW] = 0.0
    now.slowest[NOW], now.fastest[NOW] = min(now.slowest[NOW], bit), max(now.fastest[NOW], bit)
    now.last_top[NOW] = top
    now.bit[NOW] += bit
    now.top[NOW] += top
    now.samples[NOW] += 1.0
    return bool(changed)


@strict_kernel
def _close(window: Columns) -> bool:
    """Judge the motion at the end of a second; return whether it has changed."""
    now, before = window.rows, window.motion[0]
    top = now.top[NOW] / now.samples[NOW]
    known = math.isfinite(top)
    drive = top if known else now.bit[NOW] / now.samples[NOW]
    stopping = known and window.seconds[0] > 0 and abs(drive) < STOPPING * _mean(window, now.top)
    window.resting[0] = window.resting[0] + 1 if abs(drive) < REST or stopping else 0
    if window.resting[0] >= (1 if known else MOST_STUCK):
        restart(window)
        window.motion[0], window.resting[0] = AT_REST, MOST_STUCK
    elif window.turning[0]:
        for column in now:
            column[window.seconds[0] % TIME_BASE] = column[NOW]
        window.seconds[0] += 1
        _judge(window, known)
    else:
        rises = known and abs(now.last_top[NOW]) > (1.0 + RISE) * abs(now.first_top[NOW])
        fastest = max(now.fastest[NOW], -now.slowest[NOW])
        if not rises and fastest >= max(REACHED * abs(drive), REST):
            window.turning[0], window.seconds[0], window.cycles[0] = True, 0, 0
        if rises or before == AT_REST:
            window.motion[0] = STARTING
    return bool(window.motion[0] != before)


@strict_kernel
def _judge(window: Columns, known: bool) -> None:
    """Compute index and motion from the seconds of the window."""
    slowest, fastest = math.inf, -math.inf
    for k in range(min(window.seconds[0], TIME_BASE)):
        slowest, fastest = min(slowest, window.rows.slowest[k]), max(fastest, window.rows.fastest[k])
    mean = _mean(window, window.rows.bit)
    window.slowest[0], window.fastest[0], window.mean[0] = slowest, fastest, mean
    window.index[0] = math.nan
    if window.seconds[0] < SETTLED and window.cycles[0] < CYCLES_SEEN:
        return  # STARTING, or EARLY, goes on
    if (known and mean < criteria.STANDSTILL * _mean(window, window.rows.top)) or mean == 0.0:
        window.motion[0] = STANDS
    else:
        index = window.index[0] = _index(slowest, fastest, mean)
        window.largest[0] = index if math.isnan(window.largest[0]) else max(window.largest[0], index)
        window.motion[0] = STICK_SLIP if index >= FULL else VIBRATION if index >= MODERATE else STEADY


@strict_kernel
def _mean(window: Columns, speeds: Array) -> float:
    """Mean over the window, without its sign [rad/s], of `speeds`, a sum for each second."""
    total = samples = 0.0
    for k in range(min(window.seconds[0], TIME_BASE)):
        total += speeds[k]
        samples += window.rows.samples[k]
    return float(abs(total) / samples)
