# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, dominant precession, largest radius."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers, Mask
from drill_twin.core.compile.jit import copy, strict_kernel
from drill_twin.core.missing import number_or_none
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.findings import Quality, Summary
from drill_twin.whirl.motion.lasting import lasting_motion, whirl_end
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.orbit.dominant_precession import DominantPrecession, add_power
from drill_twin.whirl.orbit.orbit import RECENT_ROTATION, Orbit
from drill_twin.whirl.sample_bins import ANGLE, BINS, REVOLUTIONS, TIME, Bin
from drill_twin.whirl.sample_bins import SAMPLES as BIN_SAMPLES
from drill_twin.whirl.text import doubt

if TYPE_CHECKING:
    from drill_twin.whirl.whirl_estimator import WhirlEstimator

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

    def summary(
        self, names: Sequence[str], estimator: WhirlEstimator, largest: Array, bit: StickSlip, quality: Quality
    ) -> Summary:
        """The findings of the run so far."""
        mark, ratio, precession = self.dominant.peak() or (None, None, None)
        timelines = estimator.timelines
        motion, onset = timelines[-1].periods, estimator.onset
        seconds, turns = self.numbers[SECONDS : TURNS + 1].tolist()
        end = estimator.origin + float(self.last[TIME])
        lasting = lasting_motion(motion, estimator.origin if onset is None else onset.time_s, end)
        single = lasting is not MotionState.IRREGULAR
        unseen = [name for name, radius in zip(names, largest.tolist(), strict=True) if not math.isfinite(radius)]
        return Summary(
            onset=onset,
            mark_onset_s=dict(zip(names, estimator.crossed, strict=True)),
            whirl_frequency_hz=precession if single else None,
            precession_ratio=ratio if single else None,
            frequency_mark=None if mark is None else names[mark],
            max_radius_m=dict(zip(names, _finite(largest), strict=True)),
            rotation_rev_s=turns / seconds if seconds > 0.0 else None,
            motion=motion,
            mark_motion={name: timeline.periods for name, timeline in zip(names, timelines[:-1], strict=True)},
            stick_slip=tuple(bit.periods),
            bit=bit.motion,
            stick_slip_index=number_or_none(bit.index),
            largest_stick_slip_index=number_or_none(bit.largest_index),
            quality=quality,
            lasting_motion=lasting,
            whirl_end_s=whirl_end(motion),
            mode_frequency_hz=precession,
            mode_ratio=ratio,
            notes=_notes(quality, timelines[-1].dropped, estimator.criteria, estimator.rolling_ratio, unseen),
        )


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


def _notes(
    quality: Quality, dropped: int, criteria: Criteria, rolling_ratio: float, unseen: list[str]
) -> tuple[str, ...]:
    """Limits of the findings, as sentences."""
    notes = []
    rate, fewest = quality.samples_per_revolution, criteria.fewest_samples
    if quality.accepted == 0:
        notes.append("no sample could be analysed")
    elif math.isnan(rate):
        notes.append("the string did not rotate: whirl is not defined")
    elif rate < fewest:
        notes.append(
            f"{rate:.1f} samples in a revolution: too few for the rotation, at least {fewest:g} are needed; the "
            "pace and the kind of a whirl would be another's (aliasing) and are not reported"
        )
    elif why := doubt(criteria, rate, rolling_ratio):
        notes.append(why)
    counts = {
        "duplicate samples": quality.duplicate,
        "samples from before one already seen (time running backwards)": quality.late,
        "incomplete samples": quality.incomplete,
        "single marks missing from samples": quality.missing_marks,
    }
    notes += [f"{count} {what} skipped" for what, count in counts.items() if count]
    if quality.gaps:
        notes.append(f"{quality.gaps} gaps of more than 3/4 of a revolution")
    if unseen and quality.accepted:
        notes.append(f"never seen: {', '.join(unseen)}")
    if dropped:
        notes.append(f"{dropped} later changes of the string's motion are not listed")
    return tuple(notes)


def _finite(values: Array) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]
