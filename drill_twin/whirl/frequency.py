# SPDX-License-Identifier: Apache-2.0
"""Whirl frequency of a run: the mean over the last settled stretch of its whirl, with an interval from windows.

The frequency is the angle that a mark sweeps over the time it takes: the slope of its phase. The stretch is cut into
windows of equal rotation, and the scatter of their means tells the interval (method of batch means, Law 2007, section
9.5.3), wider where neighbours are alike, as in an autoregression of first order. A trend of the windows means that the
motion is still changing. `python -m drill_twin_evidence.detection.frequency 200 9000` counts intervals that hold.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod, Summary
from drill_twin.whirl.motion.states import Timeline, lasting_motion

WINDOWS, FEWEST, SHORTEST = 8, 5, 3.0
"""Windows of a settled stretch, the fewest that tell a trend, and the shortest [rev]: of 12 or 16 windows fewer
intervals hold; chosen. With windows of two revolutions `pa6_bench` seemed settled after 15 s, in the midst of a
change."""
FEWEST_TURNS = 2.0
"""Least rotation with a frequency [rev], and least turns of a whirl that lasts for less than two windows; so short a
whirl has none while its centre is not known (`criteria.SEPARATION_MEMORY`): of 1 s of rolling it was half; chosen."""
SHARE, LIKE = 0.95, 0.5
"""Share of the intervals that would hold if windows were independent: with 0.9, eight of ten wandering frequencies are
held (seeds 2000 to 2199), with 0.95 nine. Largest correlation of neighbours; with 0.4 as many of them hold."""
CHANCE = 0.01
"""Chance with which windows of a settled whirl have a trend (F test); chosen, not measured."""
MATTERS = 0.02
"""Least trend over a stretch that counts, over the rotation; chosen, not measured."""
BEGINS = (0.25, 0.5, 0.75)
"""Shares of a stretch that are left out at its begin, until the rest has no trend. Chosen, not measured."""
_FORWARD = {MotionState.SYNCHRONOUS_WHIRL, MotionState.FORWARD_WHIRL}
_BACKWARD = {MotionState.BACKWARD_WHIRL, MotionState.ROLLING, MotionState.CREEPING}


def whirl_frequency(
    statistics: Columns,
    names: Sequence[str],
    timelines: Sequence[Timeline],
    onset: float,
    end: float,
    origin: float,
    *,
    irregular: bool,
) -> Summary | None:
    """Frequency over the settled part of the longest stretch in which a mark keeps the sense of the motion that lasts.

    The mark is the one with the most power in the second half of the whirl.

    Args:
        statistics: Sums over the bins.
        names: Of the marks.
        timelines: Motion states of the marks, then of the string.
        onset: Time of the onset [s].
        end: End of the whirl [s].
        origin: Time of the first sample [s].
        irregular: Whether the motion that lasts is irregular, and never settled.

    Returns:
        The fields of a summary that tell it; None without a precession there, or for too short a time.
    """
    late = (statistics.end > 0.5 * (onset + end) - origin) & (statistics.end <= end - origin)
    power = statistics.power[late].sum(axis=0)
    if not power.size or not power.max() > 0.0:
        return None
    mark, found = int(np.argmax(power)), None
    begin, end = _stretch(timelines[mark].periods, onset, end)
    for share in BEGINS:
        last = _over(statistics, mark, begin + share * (end - begin), end, origin, irregular=irregular)
        settles = last is not None and last.whirl_frequency_changes is False
        if found is None or (settles and found.whirl_frequency_changes is not False):
            found = last
    return found and replace(found, frequency_mark=names[mark])


def _stretch(periods: Sequence[MotionPeriod], onset: float, end: float) -> tuple[float, float]:
    """Longest time [s] between onset and end in which a mark keeps the sense of the motion that lasts."""
    periods = [period for period in periods if period.start_s < end]
    lasting = lasting_motion(periods, onset, end)
    senses = next((group for group in (_FORWARD, _BACKWARD) if lasting in group), {lasting})
    runs: list[tuple[float, float]] = []
    for period, stop in zip(periods, [*(after.start_s for after in periods[1:]), end], strict=True):
        if period.state in senses:
            begin = runs.pop()[0] if runs and runs[-1][1] == period.start_s else max(period.start_s, onset)
            runs.append((begin, stop))
    return max(runs, key=lambda run: run[1] - run[0], default=(onset, end))


def _over(
    statistics: Columns, mark: int, begin: float, end: float, origin: float, *, irregular: bool
) -> Summary | None:
    """Frequency over a time [s]."""
    within = (statistics.end > begin - origin) & (statistics.end <= end - origin)
    cells = np.flatnonzero(within & (statistics.length[:, mark] > 0.0))
    if not cells.size:
        return None
    each = max(math.ceil(SHORTEST / statistics.width.item()), cells.size // WINDOWS)  # cells of a window
    cells = cells[cells.size % each if cells.size > each else 0 :]
    length, swept, rotated = (one[cells, mark] for one in (statistics.length, statistics.swept, statistics.rotated))
    window = float(statistics.end[cells[0]] - length[0]) + origin, float(statistics.end[cells[-1]]) + origin
    early = statistics.first[0] + cells[0] * statistics.width[0] < criteria.SEPARATION_MEMORY
    short = cells.size < 2 * each and (early or abs(swept.sum()) < FEWEST_TURNS)
    if short or not rotated.sum() >= FEWEST_TURNS:
        return None
    hz, ratio = float(swept.sum() / length.sum()), float(swept.sum() / rotated.sum())
    share = float(statistics.left[cells, mark].sum() / statistics.power[cells, mark].sum())
    found = Summary(
        mean_frequency_hz=hz, mean_ratio=ratio, irregular_share=share, whirl_frequency_window_s=window,
        whirl_frequency_hz=None if irregular else hz, whirl_ratio=None if irregular else ratio,
    )  # fmt: skip
    if cells.size < 2 * each:
        return found
    means = swept.reshape(-1, each).sum(axis=1) / length.reshape(-1, each).sum(axis=1)
    count, centred = means.size, means - means.mean()
    changes = _trend(means) > MATTERS * rotated.sum() / length.sum()
    square = max(float(centred @ centred), np.finfo(float).tiny)
    alike = max(float(centred[1:] @ centred[:-1]) / square + 1.0 / count, 0.0)  # Kendall 1954
    if changes or irregular or count < WINDOWS or alike > LIKE:
        spread = float(means.min()), float(means.max())
        still = True if changes and not irregular else None
        return replace(found, whirl_frequency_interval_hz=spread, whirl_frequency_changes=still)
    from scipy import special  # takes 0.1 s, which a run without a steady whirl does not need

    error = math.sqrt(square / (count - 1) / count * (1.0 + alike) / (1.0 - alike))
    half = float(special.stdtrit(count - 1, 0.5 + 0.5 * SHARE)) * error
    return replace(found, whirl_frequency_interval_hz=(hz - half, hz + half), whirl_frequency_changes=False)


def _trend(means: Array) -> float:
    """Range of a parabola through means of windows; 0 where chance explains it (F test), or where they are too few."""
    if means.size < FEWEST:
        return 0.0
    place = np.linspace(-1.0, 1.0, means.size)
    curve = np.polynomial.Polynomial.fit(place, means, 2)(place)
    shown, rest = float(np.sum((curve - means.mean()) ** 2)), float(np.sum((means - curve) ** 2))
    left = means.size - 3
    sure = shown > (CHANCE ** (-2.0 / left) - 1.0) * rest  # quantile of F for 2 and `left` degrees, in closed form
    return float(np.ptp(curve)) if sure else 0.0
