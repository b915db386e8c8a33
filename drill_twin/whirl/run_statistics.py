# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, dominant precession, largest radius.

Each bin adds (radius / clearance)^2 x its duration to a histogram over the precession ratio, which becomes the power of
the motion by ratio, in bounded memory. The dominant ratio is the centroid of the cells around the highest peak: a run
that alternates between forward whirl and backward rolling gets the ratio of the stronger motion, not the mean ratio.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.sample_bins import BINS

WIDTH = 0.02
"""Width of a cell, in whirl ratio, up to `EVEN`; chosen, not measured."""
EVEN = 6.0
"""Ratio from which cells keep their width over their ratio."""
LARGEST_RATIO = 60.0
"""Largest ratio; a larger ratio is counted in an outermost cell. A stabiliser rolls at up to 50 times the rotation."""
EVEN_CELLS = round(EVEN / WIDTH)
CELLS = 2 * (EVEN_CELLS + math.ceil(EVEN_CELLS * math.log(LARGEST_RATIO / EVEN)))
PEAK_CELLS = 3
"""Cells on each side of a peak that belong to the peak; chosen, not measured."""


def new_statistics(m: int) -> Columns:
    """Sums over the bins of a run, before the first bin of m marks."""
    return columns(
        "RunStatistics",
        1,
        power=np.zeros((m, CELLS)),  # of the motion over its precession ratio [s]: the weight of a cell
        ratio=np.zeros((m, CELLS)),  # the same times the ratio
        precession=np.zeros((m, CELLS)),  # the same times the precession [rev/s]
        left=np.zeros(m),  # the power times its irregular share [s]
        seconds=0.0,  # of rotation [s], since the onset if there was one
        turns=0.0,  # of rotation [rev], since the onset if there was one
        samples=0.0,  # since rotation began
        revolutions=0.0,  # since rotation began
        per_revolution=math.nan,  # accepted samples in a revolution; nan before rotation
        last_estimate=0.0,  # time [s]
        begun=False,  # True after the first bin
        whirled=False,  # True after the onset
        counted=False,  # True after the first bin since the onset
        estimated=False,  # True where the orbit was estimated with the newest bin
        last_time=0.0,  # of the last bin [s]
        last_angle=0.0,  # of the last bin [rad]
        last_revolutions=0.0,  # of the last bin [rev]
    )


def dominant_precession(statistics: Columns) -> tuple[int, float, float, float] | None:
    """Mark with the largest power, its dominant ratio, precession [rev/s] and irregular share; None without power."""
    total = statistics.power.sum(axis=1)
    mark = int(np.argmax(total))
    if total[mark] <= 0.0:
        return None
    weight = statistics.power[mark]
    smooth = np.convolve(weight, np.ones(2 * PEAK_CELLS + 1), mode="same")
    centre = int(np.argmax(smooth))
    around = slice(max(0, centre - PEAK_CELLS), centre + PEAK_CELLS + 1)
    power = float(weight[around].sum())
    ratio = float(statistics.ratio[mark, around].sum()) / power
    precession = float(statistics.precession[mark, around].sum()) / power
    return mark, ratio, precession, float(statistics.left[mark] / total[mark])


@strict_kernel
def _add_power(statistics: Columns, orbit: Columns, whirling: Mask, seconds: float) -> None:
    """Add the orbits of a bin of a length [s]; nan ratios add nothing."""
    for k in range(whirling.size):
        radius, ratio = orbit.radius[0 if whirling[k] else 1, k], orbit.ratio[k]
        weight = radius * radius * seconds
        if math.isfinite(ratio) and weight > 0.0:
            size = abs(ratio)
            place = size / WIDTH if size < EVEN else EVEN_CELLS * (1.0 + math.log(size / EVEN))
            cell = min(max(int(CELLS // 2 + (place if ratio > 0.0 else -place)), 0), CELLS - 1)
            statistics.power[k, cell] += weight
            statistics.ratio[k, cell] += weight * ratio
            statistics.precession[k, cell] += weight * orbit.precession[k]
            statistics.left[k] += weight * orbit.left[k]


@strict_kernel
def add_bin(statistics: Columns, orbit: Columns, whirling: Mask, full: Columns, length: int) -> None:
    """Add a bin.

    Args:
        statistics: The sums.
        orbit: Orbits of the marks.
        whirling: Marks in asynchronous whirl, shape (m,).
        full: The bin.
        length: Number of bins since the last gap.
    """
    begun, statistics.begun[0] = statistics.begun[0], True
    seconds, angle = full.time[0] - statistics.last_time[0], full.angle[0] - statistics.last_angle[0]
    revolutions = full.revolutions[0] - statistics.last_revolutions[0]
    statistics.last_time[0], statistics.last_angle[0] = full.time[0], full.angle[0]
    statistics.last_revolutions[0] = full.revolutions[0]
    if statistics.whirled[0] and not statistics.counted[0]:
        statistics.counted[0] = True
        statistics.seconds[0] = statistics.turns[0] = 0.0
    if not begun or length < 2:
        return
    if abs(orbit.recent_rotation[0]) >= criteria.REST_ROTATION:
        statistics.seconds[0] += seconds
        statistics.turns[0] += angle / math.tau
        statistics.samples[0] += full.samples[0]
        statistics.revolutions[0] += revolutions
        if statistics.revolutions[0] > 1.0 / BINS:
            statistics.per_revolution[0] = statistics.samples[0] / statistics.revolutions[0]
    if not statistics.estimated[0]:
        return
    if statistics.whirled[0]:
        _add_power(statistics, orbit, whirling, full.time[0] - statistics.last_estimate[0])
    statistics.last_estimate[0] = full.time[0]
