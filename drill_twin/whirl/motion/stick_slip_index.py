# SPDX-License-Identifier: Apache-2.0
"""Stick-slip index of the bit over the last 20 s, and the start-up before which it means nothing.

The index is (fastest - slowest) / (2 mean) of the bit's speed in a sliding window (Pavone and Desplans 1994, SPE
28324). A swing about its mean that just reaches standstill has the index 1; half of it has 0.5. Vendors' windows and
classes differ; these two bounds follow from the definition alone.

Rotation from rest winds the string up first: the bit stands, breaks loose and catches up. That is no stick-slip. It
lasts until the top drive no longer gains 2 % in a second and the bit has been as fast as it, and the index is known
when the window then holds 10 s or two cycles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import as_python, copy, strict_kernel

TIME_BASE = 20
"""Length of the window [s]; two periods of the slowest string, 0.1 Hz."""
SETTLED, CYCLES_SEEN = 10, 2
"""The index is known after so many seconds or cycles since the start-up."""
MODERATE, FULL = 0.5, 1.0
"""Index from which the swing is torsional vibration, and stick-slip."""
REST = 0.05 * math.tau
"""Slower than this the string is at rest [rad/s]."""
STOPPING = 0.1
"""A top drive slower than this share of its mean is being stopped."""
RISE, REACHED = 0.02, 0.95
"""Gain of the top drive in a second while it starts; share of its speed that the bit reaches then."""
STUCK = 0.05
"""A bit slower than this share of the top drive stands still."""
LONGEST_STICK = 10
"""Seconds at rest after which a bit without a known top drive has been stopped."""

AT_REST, STARTING, STANDS, STEADY, VIBRATION, STICK_SLIP = range(6)
"""Codes of the motion, `SpeedWindow.counts[MOTION]`."""
SECOND, SLOWEST, FASTEST, BIT, TOP, SAMPLES, FIRST_TOP, LAST_TOP = range(8)
"""Indices into a second: its number, speeds of the bit [rad/s], sums of the speeds of bit and top drive, samples, first
and last speed of the top drive [rad/s]."""
INDEX, LARGEST, WINDOW_SLOWEST, WINDOW_FASTEST, WINDOW_MEAN = range(5)
"""Indices into `SpeedWindow.numbers`: index, nan while it is not known, and the largest so far; speeds [rad/s]."""
MOTION, TURNING, SECONDS, CYCLES, RESTING = range(5)
"""Indices into `SpeedWindow.counts`: motion, 1 after the start-up, seconds and cycles since, seconds at rest."""


class SpeedWindow(NamedTuple):
    """Extremes and sums of each of the last seconds."""

    rows: Array  # (TIME_BASE, 8) whole seconds
    present: Array  # (8,) the second that is being filled
    numbers: Array
    counts: Integers

    @classmethod
    def empty(cls) -> SpeedWindow:
        """Before the first sample."""
        counts = np.zeros(5, np.int64)
        counts[MOTION] = STARTING
        return cls(np.zeros((TIME_BASE, 8)), np.zeros(8), np.full(5, math.nan), counts)


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
def restart(window: SpeedWindow) -> None:
    """Begin anew, after a gap."""
    window.present[SAMPLES] = 0.0
    window.numbers[INDEX] = math.nan
    window.counts[MOTION] = STARTING
    window.counts[TURNING] = window.counts[SECONDS] = window.counts[RESTING] = 0


@strict_kernel
def add_speeds(window: SpeedWindow, time: float, bit: float, top: float) -> bool:
    """Add the speeds of bit and top drive [rad/s], nan for an unknown one of the top drive, at a time [s].

    Returns:
        Whether the motion has changed.
    """
    now, second = window.present, math.floor(time)
    changed = now[SAMPLES] > 0.0 and now[SECOND] != second and _close(window)
    if now[SAMPLES] == 0.0 or now[SECOND] != second:
        now[SECOND], now[SLOWEST], now[FASTEST], now[FIRST_TOP] = second, bit, bit, top
        now[BIT] = now[TOP] = now[SAMPLES] = 0.0
    now[SLOWEST], now[FASTEST], now[LAST_TOP] = min(now[SLOWEST], bit), max(now[FASTEST], bit), top
    now[BIT] += bit
    now[TOP] += top
    now[SAMPLES] += 1.0
    return changed


@strict_kernel
def _close(window: SpeedWindow) -> bool:
    """Judge the motion at the end of a second; return whether it has changed."""
    now, counts, before = window.present, window.counts, window.counts[MOTION]
    top = now[TOP] / now[SAMPLES]
    known = math.isfinite(top)
    drive = top if known else now[BIT] / now[SAMPLES]
    stopping = known and counts[SECONDS] > 0 and abs(drive) < STOPPING * _mean(window, TOP)
    counts[RESTING] = counts[RESTING] + 1 if abs(drive) < REST or stopping else 0
    if counts[RESTING] >= (1 if known else LONGEST_STICK):
        restart(window)
        counts[MOTION], counts[RESTING] = AT_REST, LONGEST_STICK
    elif counts[TURNING]:
        copy(now, window.rows[counts[SECONDS] % TIME_BASE])
        counts[SECONDS] += 1
        _judge(window, known)
    else:
        rises = known and abs(now[LAST_TOP]) > (1.0 + RISE) * abs(now[FIRST_TOP])
        fastest = max(now[FASTEST], -now[SLOWEST])
        if not rises and fastest >= max(REACHED * abs(drive), REST):
            counts[TURNING], counts[SECONDS], counts[CYCLES] = 1, 0, 0
        counts[MOTION] = STARTING
    return bool(counts[MOTION] != before)


@strict_kernel
def _judge(window: SpeedWindow, known: bool) -> None:
    """Compute index and motion from the seconds of the window."""
    rows, numbers, counts = window.rows, window.numbers, window.counts
    slowest, fastest = math.inf, -math.inf
    for k in range(min(counts[SECONDS], TIME_BASE)):
        slowest, fastest = min(slowest, rows[k, SLOWEST]), max(fastest, rows[k, FASTEST])
    mean = _mean(window, BIT)
    numbers[WINDOW_SLOWEST], numbers[WINDOW_FASTEST], numbers[WINDOW_MEAN] = slowest, fastest, mean
    numbers[INDEX] = math.nan
    if counts[SECONDS] < SETTLED and counts[CYCLES] < CYCLES_SEEN:
        counts[MOTION] = STARTING
    elif (known and mean < STUCK * _mean(window, TOP)) or mean == 0.0:
        counts[MOTION] = STANDS
    else:
        index = numbers[INDEX] = _index(slowest, fastest, mean)
        numbers[LARGEST] = index if math.isnan(numbers[LARGEST]) else max(numbers[LARGEST], index)
        counts[MOTION] = STICK_SLIP if index >= FULL else VIBRATION if index >= MODERATE else STEADY


@strict_kernel
def _mean(window: SpeedWindow, column: int) -> float:
    """Mean speed over the window, without its sign [rad/s]."""
    total = samples = 0.0
    for k in range(min(window.counts[SECONDS], TIME_BASE)):
        total += window.rows[k, column]
        samples += window.rows[k, SAMPLES]
    return abs(total) / samples
