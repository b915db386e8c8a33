# SPDX-License-Identifier: Apache-2.0
"""Sums over the whole run, for its summary: rotation, rate of the samples, dominant precession, largest radius."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.whirl.findings import Quality, Summary
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.orbit.dominant_precession import Dominant
from drill_twin.whirl.sample_bins import BINS, Bin
from drill_twin.whirl.whirl_estimator import Estimates

FEW = 6.0
"""Fewer samples in a revolution than this limit what can be seen."""


class Tally:
    """What the summary needs and the findings do not."""

    def __init__(self, marks: int) -> None:
        self.largest = np.full(marks, math.nan)
        """Largest distance of each mark's centre line from the hole's axis [m], shape (m,)."""
        self._dominant = Dominant(marks)
        self._seconds = self._turns = 0.0  # of rotation, since the onset if there was one
        self._samples = self._travel = 0.0  # since rotation began
        self._onset = False
        self._last: Bin | None = None
        self._weighed = 0.0  # time up to which the dominant precession is known

    def add(self, full: Bin, estimates: Estimates, *, fresh: bool) -> None:
        """Adds a bin; `fresh` whether the estimates are new with it."""
        last, self._last = self._last, full
        if estimates.onset is not None and not self._onset:
            self._onset = True
            self._seconds = self._turns = 0.0
        if last is None or estimates.history.length < 2:
            return
        seconds = full.time - last.time
        orbit = estimates.orbit
        if abs(orbit.recent_rotation) >= estimates.criteria.rest_rotation:
            self._seconds += seconds
            self._turns += (full.angle - last.angle) / math.tau
            self._samples += full.samples
            self._travel += full.travel - last.travel
        if fresh and self._onset:
            radius = np.where(estimates.detector.active, orbit.radius[0], orbit.radius[1])
            self._dominant.add(estimates.ratio, estimates.precession, radius, full.time - self._weighed)
        if fresh:
            self._weighed = full.time

    @property
    def samples_per_revolution(self) -> float:
        """Accepted samples in a revolution; nan before rotation."""
        return self._samples / self._travel if self._travel > 1.0 / BINS else math.nan

    def summary(self, names: Sequence[str], estimates: Estimates, bit: StickSlip, quality: Quality) -> Summary:
        """The findings of the run so far."""
        peak = self._dominant.peak()
        timelines = estimates.motion.votes.timelines
        unseen = [name for name, radius in zip(names, self.largest.tolist(), strict=True) if not math.isfinite(radius)]
        return Summary(
            onset=estimates.onset,
            mark_onset_s=dict(zip(names, estimates.crossed, strict=True)),
            whirl_frequency_hz=None if peak is None else peak[2],
            precession_ratio=None if peak is None else peak[1],
            frequency_mark=None if peak is None else names[peak[0]],
            max_radius_m=dict(zip(names, _known(self.largest), strict=True)),
            rotation_rev_s=self._turns / self._seconds if self._seconds > 0.0 else None,
            motion=timelines[-1].periods,
            mark_motion={name: timeline.periods for name, timeline in zip(names, timelines[:-1], strict=True)},
            stick_slip=tuple(bit.periods),
            bit=bit.motion,
            quality=quality,
            notes=self._notes(quality, timelines[-1].dropped, estimates.criteria.fewest_samples, unseen),
        )

    @staticmethod
    def _notes(quality: Quality, dropped: int, fewest: float, unseen: list[str]) -> tuple[str, ...]:
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
        elif rate < FEW:
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


def _known(values: Array) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]
