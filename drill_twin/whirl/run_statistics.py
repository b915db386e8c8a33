# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, dominant precession, largest radius.

Each bin adds (radius / clearance)^2 x its duration to a histogram over the precession ratio, which becomes the power of
the motion by ratio, in bounded memory. The dominant ratio is the centroid of the cells around the highest peak: a run
that alternates between forward whirl and backward rolling gets the ratio of the stronger one, not the mean of both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers, Mask
from drill_twin.core.compile.jit import copy, strict_kernel
from drill_twin.whirl.orbit.orbit import RECENT_ROTATION, Orbit
from drill_twin.whirl.sample_bins import ANGLE, BINS, REVOLUTIONS, TIME, Bin
from drill_twin.whirl.sample_bins import SAMPLES as BIN_SAMPLES

WIDTH = 0.02
"""Width of a cell, in whirl ratio, up to `EVEN`."""
EVEN = 6.0
"""Ratio from which cells keep their width over their ratio."""
LARGEST_RATIO = 60.0
"""Largest ratio; larger ones are counted in the outermost cells."""
EVEN_CELLS = round(EVEN / WIDTH)
CELLS = 2 * (EVEN_CELLS + math.ceil(EVEN_CELLS * math.log(LARGEST_RATIO / EVEN)))
PEAK_CELLS = 3
"""Cells on each side of the peak that belong to it."""


class DominantPrecession(NamedTuple):
    """Histogram of the power of each mark's motion over its precession ratio."""

    sums: Array  # (3, m, CELLS) of weight, weight x ratio, weight x precession

    @classmethod
    def of(cls, m: int) -> DominantPrecession:
        """Empty histogram of m marks."""
        return cls(np.zeros((3, m, CELLS)))

    def peak(self) -> tuple[int, float, float] | None:
        """Mark with the largest power, its dominant ratio and precession [rev/s]; None if nothing was added."""
        total = self.sums[0].sum(axis=1)
        mark = int(np.argmax(total))
        if total[mark] <= 0.0:
            return None
        weight = self.sums[0, mark]
        smooth = np.convolve(weight, np.ones(2 * PEAK_CELLS + 1), mode="same")
        centre = int(np.argmax(smooth))
        around = slice(max(0, centre - PEAK_CELLS), centre + PEAK_CELLS + 1)
        power = float(weight[around].sum())
        ratio = float(self.sums[1, mark, around].sum()) / power
        return mark, ratio, float(self.sums[2, mark, around].sum()) / power


@strict_kernel
def add_power(dominant: DominantPrecession, orbit: Orbit, whirling: Mask, seconds: float) -> None:
    """Add the orbits of a bin of a length [s]; nan ratios add nothing."""
    sums = dominant.sums
    for k in range(whirling.size):
        radius, ratio = orbit.radius[0 if whirling[k] else 1, k], orbit.ratio[k]
        weight = radius * radius * seconds
        if math.isfinite(ratio) and weight > 0.0:
            size = abs(ratio)
            place = size / WIDTH if size < EVEN else EVEN_CELLS * (1.0 + math.log(size / EVEN))
            cell = min(max(int(CELLS // 2 + (place if ratio > 0.0 else -place)), 0), CELLS - 1)
            sums[0, k, cell] += weight
            sums[1, k, cell] += weight * ratio
            sums[2, k, cell] += weight * orbit.precession[k]


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
