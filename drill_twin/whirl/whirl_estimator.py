# SPDX-License-Identifier: Apache-2.0
"""Every estimate of the analysis, in the order in which a bin passes through them."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.findings import Onset
from drill_twin.whirl.history import History
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.motion.classifier import MotionClassifier
from drill_twin.whirl.onset.detector import OnsetDetector
from drill_twin.whirl.onset.synchronous_onset import SurgeDetector
from drill_twin.whirl.onset.threshold_crossing import Crossing
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.runout_separation import Baseline
from drill_twin.whirl.orbit.string_shape import Shape
from drill_twin.whirl.sample_bins import BINS, Bin

OFTEN = 4.0 / BINS
"""Orbit and motion state are estimated this often [rev]; the onset with every bin."""
SELDOM = 0.5
"""And at least this often [s]."""


class Estimates:
    """Offset and synchronous part -> onset -> orbit -> motion state."""

    def __init__(self, marks: tuple[MarkInfo, ...], criteria: Criteria) -> None:
        m = len(marks)
        self.criteria = criteria
        self._names = tuple(mark.name for mark in marks)
        self._clearance = np.array([mark.clearance for mark in marks])
        self._vectors = np.zeros((3, m), complex)
        self.baseline = Baseline(marks, criteria)
        self.history = History(m)
        self.orbit = Orbit(self._clearance, criteria)
        self.detector = OnsetDetector(self._clearance, criteria)
        self._surge = SurgeDetector(self._clearance, criteria)
        self.motion = MotionClassifier(marks, criteria)
        self.shape = Shape(marks, criteria)
        self.origin = 0.0
        """Time of the first sample [s]."""
        self.onset: Onset | None = None
        """The onset, once it is certain."""
        self._pending: list[tuple[Crossing, bool]] = []
        self.crossed: list[float | None] = [None] * m
        """When each mark first began to whirl [s]."""
        self.gaps = 0
        """Gaps between bins."""
        self._due = (-math.inf, -math.inf)
        self.precession = np.full(m, math.nan)
        """Precession [rev/s], positive = forward, shape (m,)."""
        self.ratio = np.full(m, math.nan)
        """Precession over rotation, shape (m,)."""
        self.confidence = np.zeros(m)
        """Confidence in both, shape (m,)."""

    def update(self, full: Bin) -> bool:
        """Takes in a full bin; returns whether orbit and motion state are new."""
        history, orbit, detector, baseline = self.history, self.orbit, self.detector, self.baseline
        distance = baseline.split(full, self._vectors)
        touching = full.contact
        if touching is None:
            touching = (distance > self.criteria.contact_radius * self._clearance).astype(float)
        self.gaps += history.append(full, self._vectors, touching)
        crossings = detector.update(history, baseline, orbit.slope[0], orbit.coherence[0])
        for crossing in crossings:
            if crossing.refit is not None:
                baseline.settle(crossing.mark, crossing.refit)
        self._note(crossings, synchronous=False)
        self._relearn(detector.leaning)
        baseline.keep(detector.candidates, detector.active)
        if self.onset is None and self._pending:
            self._settle_onset(full.time)
        if history.count < 2 or (full.travel < self._due[0] and full.time < self._due[1]):
            return False
        self._due = (full.travel + OFTEN - 0.25 / BINS, full.time + SELDOM)
        self._look(full)
        return True

    def _look(self, full: Bin) -> None:
        """Estimates orbit and motion state."""
        history, orbit, detector = self.history, self.orbit, self.detector
        noise = detector.noise.level
        orbit.update(history, noise)
        surges = self._surge.update(history, orbit, noise)
        self._note(surges, synchronous=True)
        self._relearn(detector.release(orbit, history))
        whirling = (detector.active, self._surge.active)
        self.precession, self.ratio, self.confidence = orbit.precession(detector.active, noise)
        self.shape.update(history)
        at = (full.time, full.travel, self.origin)
        began = [
            mine if mine is not None else surge for mine, surge in zip(detector.began, self._surge.began, strict=True)
        ]
        self.motion.update(orbit, self.shape, whirling, began, detector.certain, self.ratio, at)

    def _relearn(self, marks: list[int]) -> None:
        """Learns the offset and the synchronous part of marks anew from the last revolution."""
        window = self.history.newest(self.history.span(1.0))
        for mark in marks:
            self.baseline.relearn(mark, self.history.sample[window, :, mark])

    def _note(self, crossings: list[Crossing], *, synchronous: bool) -> None:
        """Notes first crossings of the marks; those before the onset is settled are candidates for it."""
        for crossing in crossings:
            if self.crossed[crossing.mark] is None:
                self.crossed[crossing.mark] = self.origin + crossing.time
            if self.onset is None:
                self._pending.append((crossing, synchronous))

    def _settle_onset(self, time: float) -> None:
        """The onset is the earliest crossing, once no mark that crossed still earlier may prove to whirl as well."""
        first, synchronous = min(self._pending, key=lambda pending: pending[0].time)
        if self.detector.earliest(but=self._surge.active) < first.time:
            return
        self.onset = Onset(
            time_s=self.origin + first.time,
            mark=self._names[first.mark],
            confidence=first.confidence,
            kind="synchronous" if synchronous else "asynchronous",
            detected_s=self.origin + time,
            criterion=first.criterion,
        )
        self.motion.votes.timelines[-1].redate(self.onset.time_s)
