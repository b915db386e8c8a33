# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, and the whirl over time.

The whirl since the onset is kept in cells of some revolutions: the angle that each mark swept, the angle of rotation
meanwhile and the power of the motion. When all cells are taken, each two become one, so that memory is bounded.
"""

import math

import numpy as np

from drill_twin.core.arrays import Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import end_of
from drill_twin.whirl.sample_bins import BINS

CELLS = 256
"""Cells of the whirl; it takes 128 or more once they have a second revolution. Chosen, not measured."""

EQUAL = 0.9
"""Least size of the second line over the first at which neither is the stronger; chosen."""


def new_statistics(m: int) -> Columns:
    """Sums over the bins of a run, before the first bin of m marks."""
    length, swept, rotated, power, left = np.zeros((5, CELLS, m))
    return columns(
        "RunStatistics",
        1,
        width=1.0,  # revolutions of a cell
        first=0.0,  # revolutions at the begin of the first cell
        end=np.zeros(CELLS),  # time of the last estimate in a cell [s]; 0 for none
        length=length,  # time for which the precession of a mark is known [s], (cells, m)
        swept=swept,  # by the mark meanwhile [rev], positive = forward
        rotated=rotated,  # by the string meanwhile [rev]
        power=power,  # radius over the clearance, squared, times the time [s]
        left=left,  # the same times the irregular share of the motion [s]
        seconds=0.0,  # of rotation [s], since the onset if there was one
        turns=0.0,  # of rotation [rev], since the onset if there was one
        samples=0.0,  # since rotation began
        revolutions=0.0,  # since rotation began
        per_revolution=math.nan,  # accepted samples in a revolution; nan before rotation
        last_estimate=0.0,  # time [s]
        estimated_angle=0.0,  # of rotation at the last estimate [rad]
        unwrapped=np.full((2, m), math.nan),  # angle of each mark's motion there [rad], as in `History`
        begun=False,  # True after the first bin
        whirled=False,  # True after the onset
        counted=False,  # True after the first bin since the onset
        estimated=False,  # True where the orbit was estimated with the newest bin
    )


@strict_kernel
def _halve(statistics: Columns) -> None:
    """Make one cell of each two."""
    for i in range(CELLS):
        here = 2 * i < CELLS
        statistics.end[i] = max(statistics.end[2 * i], statistics.end[2 * i + 1]) if here else 0.0
        for sums in (statistics.length, statistics.swept, statistics.rotated, statistics.power, statistics.left):
            for k in range(sums.shape[1]):
                sums[i, k] = sums[2 * i, k] + sums[2 * i + 1, k] if here else 0.0
    statistics.width[0] *= 2.0


@strict_kernel
def _add_whirl(
    statistics: Columns, orbit: Columns, whirling: Mask, full: Columns, history: Columns, motion: Columns
) -> None:
    """Add what the marks swept since the last estimate; a mark without a precession, or with two equal, adds nothing.

    The phase of two lines of like size follows neither: the rate of the stronger tells what it swept.
    """
    while full.revolutions[0] - statistics.first[0] >= CELLS * statistics.width[0]:
        _halve(statistics)
    cell, last = int((full.revolutions[0] - statistics.first[0]) / statistics.width[0]), end_of(history) - 1
    seconds, turned = full.time[0] - statistics.last_estimate[0], full.angle[0] - statistics.estimated_angle[0]
    statistics.end[cell] = full.time[0]
    for k in range(whirling.size):
        row = 0 if whirling[k] else 1
        swept = history.unwrapped[last, row, k] - statistics.unwrapped[row, k]
        lines, irregular = motion.lines, motion.irregularity.active[k]
        second = lines[k, 1, 1] / lines[k, 0, 1] if row == 0 and lines[k, 0, 1] > 0.0 else 0.0
        two = irregular and second > 0.5 and orbit.left[k] < criteria.LEFT
        if two:
            swept = lines[k, 0, 0] * seconds
        if math.isfinite(orbit.ratio[k]) and math.isfinite(swept) and not (two and second > EQUAL):
            statistics.length[cell, k] += seconds
            statistics.swept[cell, k] += (-swept if orbit.rotation[0] < 0.0 else swept) / math.tau
            statistics.rotated[cell, k] += abs(turned) / math.tau
            power = seconds * orbit.radius[row, k] ** 2
            statistics.power[cell, k] += power
            statistics.left[cell, k] += power * orbit.left[k]


@strict_kernel
def add_bin(
    statistics: Columns, orbit: Columns, whirling: Mask, full: Columns, history: Columns, motion: Columns
) -> None:
    """Add a bin.

    Args:
        statistics: The sums.
        orbit: Orbits of the marks.
        whirling: Marks in asynchronous whirl, shape (m,).
        full: The bin.
        history: The last revolutions.
        motion: Two lines of each mark, and whether its motion is irregular, as a growing orbit with two lines is not.
    """
    begun, statistics.begun[0] = statistics.begun[0], True
    if statistics.whirled[0] and not statistics.counted[0]:
        statistics.counted[0] = True
        statistics.seconds[0] = statistics.turns[0] = 0.0
        statistics.first[0] = full.revolutions[0]
    if not begun or history.length[0] < 2:
        statistics.unwrapped[:] = math.nan  # the angle over a gap is not known
        return
    if abs(orbit.recent_rotation[0]) >= criteria.REST_ROTATION:
        statistics.seconds[0] += full.seconds[0]
        statistics.turns[0] += full.turned[0] / math.tau
        statistics.samples[0] += full.samples[0]
        statistics.revolutions[0] += full.elapsed[0]
        if statistics.revolutions[0] > 1.0 / BINS:
            statistics.per_revolution[0] = statistics.samples[0] / statistics.revolutions[0]
    if not statistics.estimated[0]:
        return
    if statistics.whirled[0]:
        _add_whirl(statistics, orbit, whirling, full, history, motion)
    statistics.last_estimate[0], statistics.estimated_angle[0] = full.time[0], full.angle[0]
    for row in range(2):
        for k in range(whirling.size):
            statistics.unwrapped[row, k] = history.unwrapped[end_of(history) - 1, row, k]
