# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, dominant precession, largest radius."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers, Mask
from drill_twin.core.compile.jit import copy, strict_kernel
from drill_twin.whirl.orbit.dominant_precession import DominantPrecession, add_power
from drill_twin.whirl.orbit.orbit import RECENT_ROTATION, Orbit
from drill_twin.whirl.sample_bins import ANGLE, BINS, REVOLUTIONS, TIME, Bin
from drill_twin.whirl.sample_bins import SAMPLES as BIN_SAMPLES

SECONDS, TURNS, SAMPLES, REVOLUTIONS_SEEN, LAST_ESTIMATE, SAMPLE_RATE = range(6)
"""Indices into `RunStatistics.numbers`: time [s] and turns [rev] of rotation, since the onset if there was one; samples
and revolutions since rotation began; time of the last estimate [s]; accepted samples in a revolution, nan before
rotation."""
BEGUN, WHIRLED, COUNTED, ESTIMATED = range(4)
"""Indices into `RunStatistics.flags`: 1 after the first bin; 1 after the onset; 1 after the first bin since; 1 where
the orbit was estimated with the newest bin."""


class RunStatistics(NamedTuple):
    """Sums over the bins of a run."""

    dominant: DominantPrecession
    numbers: Array
    flags: Integers
    last: Array  # time [s], angle [rad] and revolutions [rev] of the last bin

    @classmethod
    def of(cls, m: int) -> RunStatistics:
        """Before the first bin of m marks."""
        numbers = np.array([0.0, 0.0, 0.0, 0.0, 0.0, math.nan])
        return cls(DominantPrecession.of(m), numbers, np.zeros(4, np.int64), np.zeros(3))


@strict_kernel
def add_bin(
    statistics: RunStatistics, orbit: Orbit, whirling: Mask, full: Bin, length: int, least_rotation: float
) -> None:
    """Add a bin, with its `flags`.

    Args:
        statistics: The sums.
        orbit: Orbits of the marks.
        whirling: Marks in asynchronous whirl, shape (m,).
        full: The bin.
        length: Number of bins since the last gap.
        least_rotation: Slowest rotation [rev/s].
    """
    numbers, flags, last, now = statistics.numbers, statistics.flags, statistics.last, full.numbers
    begun = flags[BEGUN]
    flags[BEGUN] = 1
    seconds, angle, revolutions = now[TIME] - last[TIME], now[ANGLE] - last[ANGLE], now[REVOLUTIONS] - last[REVOLUTIONS]
    copy(now, last)
    if flags[WHIRLED] and not flags[COUNTED]:
        flags[COUNTED] = 1
        numbers[SECONDS] = numbers[TURNS] = 0.0
    if not begun or length < 2:
        return
    if abs(orbit.numbers[RECENT_ROTATION]) >= least_rotation:
        numbers[SECONDS] += seconds
        numbers[TURNS] += angle / math.tau
        numbers[SAMPLES] += full.counts[BIN_SAMPLES]
        numbers[REVOLUTIONS_SEEN] += revolutions
        if numbers[REVOLUTIONS_SEEN] > 1.0 / BINS:
            numbers[SAMPLE_RATE] = numbers[SAMPLES] / numbers[REVOLUTIONS_SEEN]
    if not flags[ESTIMATED]:
        return
    if flags[WHIRLED]:
        add_power(statistics.dominant, orbit, whirling, now[TIME] - numbers[LAST_ESTIMATE])
    numbers[LAST_ESTIMATE] = now[TIME]
