# SPDX-License-Identifier: Apache-2.0
"""Sequence of the estimates for each bin, and the decision on the onset of whirl."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.findings import Onset
from drill_twin.whirl.history import History
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.motion.classifier import MotionClassifier
from drill_twin.whirl.onset.asynchronous_onset import OnsetDetector
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsetDetector
from drill_twin.whirl.onset.threshold_crossing import Crossing
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.runout_separation import RunoutSeparation
from drill_twin.whirl.orbit.string_shape import StringShape
from drill_twin.whirl.sample_bins import BINS, Bin

INTERVAL_REV = 4.0 / BINS
"""Interval of the estimates of orbit and motion state [rev]; the onset is checked with every bin."""
INTERVAL_S = 0.5
"""Longest interval of these estimates [s]."""


class WhirlEstimator:
    """Separation of offset and synchronous part, then onset, orbit and motion state."""

    def __init__(self, marks: tuple[MarkInfo, ...], criteria: Criteria) -> None:
        m = len(marks)
        self.criteria = criteria
        self._names = tuple(mark.name for mark in marks)
        self._clearance = np.array([mark.clearance for mark in marks])
        self._vectors = np.zeros((3, m), complex)
        self.separation = RunoutSeparation(marks, criteria)
        self.history = History(m)
        self.orbit = Orbit(self._clearance, criteria)
        self.detector = OnsetDetector(self._clearance, np.array([mark.inclined for mark in marks]), criteria)
        self._synchronous = SynchronousOnsetDetector(self._clearance, criteria)
        self.motion = MotionClassifier(marks, criteria)
        self.shape = StringShape(marks, criteria)
        self.origin = 0.0
        """Time of the first sample [s]."""
        self.onset: Onset | None = None
        """The onset, once it is decided."""
        self._candidates: list[tuple[Crossing, bool]] = []
        self.crossed: list[float | None] = [None] * m
        """Time at which each mark first crossed its threshold [s]."""
        self.gaps = 0
        """Gaps between bins."""
        self._next_estimate = (-math.inf, -math.inf)
        self.precession = np.full(m, math.nan)
        """Precession [rev/s], positive = forward, shape (m,)."""
        self.ratio = np.full(m, math.nan)
        """Precession over rotation, shape (m,)."""
        self.confidence = np.zeros(m)
        """Confidence in both, shape (m,)."""

    def update(self, full: Bin) -> bool:
        """Add a full bin; return whether orbit and motion state were estimated."""
        history, orbit, detector, separation = self.history, self.orbit, self.detector, self.separation
        distance = separation.separate(full, self._vectors)
        contact = full.contact
        if contact is None:
            contact = (distance > self.criteria.contact_radius * self._clearance).astype(float)
        self.gaps += history.append(full, self._vectors, contact)
        crossings = detector.update(history, separation, orbit.rate[0], orbit.coherence[0])
        for crossing in crossings:
            if crossing.refit is not None:
                separation.correct(crossing.mark, crossing.refit)
        self._record(crossings, synchronous=False)
        self._restart_separation(detector.moved)
        separation.hold(detector.candidates, detector.active)
        if self.onset is None and self._candidates:
            self._decide_onset(full.time)
        if history.count < 2 or (full.revolutions < self._next_estimate[0] and full.time < self._next_estimate[1]):
            return False
        self._next_estimate = (full.revolutions + INTERVAL_REV - 0.25 / BINS, full.time + INTERVAL_S)
        self._estimate(full)
        return True

    def _estimate(self, full: Bin) -> None:
        """Estimate orbit, precession and motion state."""
        history, orbit, detector, synchronous = self.history, self.orbit, self.detector, self._synchronous
        noise = detector.noise.level
        orbit.update(history, noise)
        self._record(synchronous.update(history, orbit, noise), synchronous=True)
        self._restart_separation(detector.release(orbit, history))
        whirling = (detector.active, synchronous.active)
        self.precession, self.ratio, self.confidence = orbit.precession(detector.active, noise)
        self.shape.update(history)
        at = (full.time, full.revolutions, self.origin)
        began = [
            first if first is not None else second
            for first, second in zip(detector.began, synchronous.began, strict=True)
        ]
        self.motion.update(orbit, self.shape, whirling, began, detector.detected, self.ratio, at)

    def _restart_separation(self, marks: list[int]) -> None:
        """Estimate offset and synchronous part of marks from the last revolution alone."""
        window = self.history.newest(self.history.bins_in(1.0))
        for mark in marks:
            self.separation.restart(mark, self.history.sample[window, :, mark])

    def _record(self, crossings: list[Crossing], *, synchronous: bool) -> None:
        """Record first crossings of the marks; until the onset is decided, each is a candidate for it."""
        for crossing in crossings:
            if self.crossed[crossing.mark] is None:
                self.crossed[crossing.mark] = self.origin + crossing.time
            if self.onset is None:
                self._candidates.append((crossing, synchronous))

    def _decide_onset(self, time: float) -> None:
        """Set the onset to the earliest crossing, once no undecided mark may have crossed earlier."""
        first, synchronous = min(self._candidates, key=lambda candidate: candidate[0].time)
        if self.detector.earliest_candidate(exclude=self._synchronous.active) < first.time:
            return
        self.onset = Onset(
            time_s=self.origin + first.time,
            mark=self._names[first.mark],
            confidence=first.confidence,
            kind="synchronous" if synchronous else "asynchronous",
            detected_s=self.origin + time,
            criterion=first.criterion,
        )
        self.motion.hysteresis.timelines[-1].move_first_whirl(self.onset.time_s)
