# SPDX-License-Identifier: Apache-2.0
"""Statistics of a whole run for its summary: rotation, sample rate, dominant precession, largest radius."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import Quality, Summary
from drill_twin.whirl.motion.lasting import lasting_motion, whirl_end
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.orbit.dominant_precession import DominantPrecession
from drill_twin.whirl.sample_bins import BINS, Bin
from drill_twin.whirl.whirl_estimator import WhirlEstimator

ALIASING_NOTE = 6.0
"""Samples in a revolution below which a note states the limit set by aliasing."""


class RunStatistics:
    """Sums over the bins of a run."""

    def __init__(self, marks: int) -> None:
        self.largest = np.full(marks, math.nan)
        """Largest distance of each mark's centre line from the hole's axis [m], shape (m,)."""
        self._dominant = DominantPrecession(marks)
        self._seconds = self._turns = 0.0  # of rotation, since the onset if there was one
        self._samples = self._revolutions = 0.0  # since rotation began
        self._onset = False
        self._last: Bin | None = None
        self._last_estimate = 0.0  # time of the last new estimate [s]

    def update(self, full: Bin, estimator: WhirlEstimator, *, new_estimate: bool) -> None:
        """Add a bin; `new_estimate` tells that the orbit was estimated with it."""
        last, self._last = self._last, full
        if estimator.onset is not None and not self._onset:
            self._onset = True
            self._seconds = self._turns = 0.0
        if last is None or estimator.history.length < 2:
            return
        seconds = full.time - last.time
        orbit = estimator.orbit
        if abs(orbit.recent_rotation) >= estimator.criteria.rest_rotation:
            self._seconds += seconds
            self._turns += (full.angle - last.angle) / math.tau
            self._samples += full.samples
            self._revolutions += full.revolutions - last.revolutions
        if not new_estimate:
            return
        if self._onset:
            radius = np.where(estimator.detector.active, orbit.radius[0], orbit.radius[1])
            self._dominant.add(estimator.ratio, estimator.precession, radius, full.time - self._last_estimate)
        self._last_estimate = full.time

    @property
    def samples_per_revolution(self) -> float:
        """Accepted samples in a revolution; nan before rotation."""
        return self._samples / self._revolutions if self._revolutions > 1.0 / BINS else math.nan

    def summary(self, names: Sequence[str], estimator: WhirlEstimator, bit: StickSlip, quality: Quality) -> Summary:
        """The findings of the run so far."""
        mark, ratio, precession = self._dominant.peak() or (None, None, None)
        timelines = estimator.motion.hysteresis.timelines
        motion, onset = timelines[-1].periods, estimator.onset
        end = estimator.origin + (self._last.time if self._last is not None else 0.0)
        lasting = lasting_motion(motion, estimator.origin if onset is None else onset.time_s, end)
        single = lasting is not MotionState.IRREGULAR
        unseen = [name for name, radius in zip(names, self.largest.tolist(), strict=True) if not math.isfinite(radius)]
        return Summary(
            onset=onset,
            mark_onset_s=dict(zip(names, estimator.crossed, strict=True)),
            whirl_frequency_hz=precession if single else None,
            precession_ratio=ratio if single else None,
            frequency_mark=None if mark is None else names[mark],
            max_radius_m=dict(zip(names, _finite(self.largest), strict=True)),
            rotation_rev_s=self._turns / self._seconds if self._seconds > 0.0 else None,
            motion=motion,
            mark_motion={name: timeline.periods for name, timeline in zip(names, timelines[:-1], strict=True)},
            stick_slip=tuple(bit.periods),
            bit=bit.motion,
            quality=quality,
            lasting_motion=lasting,
            whirl_end_s=whirl_end(motion),
            mode_frequency_hz=precession,
            mode_ratio=ratio,
            notes=_notes(quality, timelines[-1].dropped, estimator.criteria.fewest_samples, unseen),
        )


def _notes(quality: Quality, dropped: int, fewest: float, unseen: list[str]) -> tuple[str, ...]:
    """Limits of the findings, as sentences."""
    notes = []
    rate = quality.samples_per_revolution
    if quality.accepted == 0:
        notes.append("no sample could be analysed")
    elif math.isnan(rate):
        notes.append("the string did not rotate: whirl is not defined")
    elif rate < fewest:
        notes.append(
            f"{rate:.1f} samples in a revolution: too few for the rotation, at least {fewest:g} are needed; the "
            "pace and the kind of a whirl would be another's (aliasing) and are not reported"
        )
    elif rate < ALIASING_NOTE:
        notes.append(
            f"{rate:.1f} samples in a revolution: precession beyond {rate / 2:.1f} times the rotation "
            "cannot be told from slower precession"
        )
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
