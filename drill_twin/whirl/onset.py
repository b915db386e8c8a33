# SPDX-License-Identifier: Apache-2.0
"""Onset of whirl, found on the stream.

A mark whirls when the radius of its asynchronous part stays over its threshold for one revolution, and has by then
turned by at least 30 degrees as seen from the hole and from the string. The threshold is 5 % of the clearance. Where
that is not 4.5 times the noise that is left after averaging over half a revolution at most, the threshold is raised to
4.5 times that noise. The time reported is when the radius first crossed 5 %, found by looking back (`dating`).

A radius that has not turned in six revolutions belongs to a string that leans over or has got a new bow: its new
place is learned, and the watch begins anew. A string that is thrown out and begins to turn within six revolutions has
whirled since it was thrown out.

False alarms: white noise of standard deviation s per axis (after averaging) is above 4.5 s with probability
exp(-4.5^2 / 2) = 4e-5, and must be so in each of the two or more independent averages of a revolution, so the stated
rate is below 1e-8 per revolution and mark: one in a year for four marks at 2 rev/s. `test/whirl/test_steady.py` holds
it to none in as many revolutions as four marks see in a day, with noise of 5 % of the clearance. Noise that is not
white over a revolution (slow drift of a camera) is not covered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.whirl.bins import BINS, Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.crossing import Crossing, Evidence, asynchronous_crossing
from drill_twin.whirl.history import ASYNCHRONOUS, History
from drill_twin.whirl.noise import Noise
from drill_twin.whirl.orbit import Orbit
from drill_twin.whirl.separation import Baseline


@dataclass
class _Candidate:
    """A radius above its threshold, not certain yet."""

    bin: int
    time: float
    travel: float
    angle: float
    turned: float


class OnsetDetector:
    """Watches the asynchronous part of each mark: has it begun to whirl, and does it still?"""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self.noise = Noise(m)
        self._candidates: list[_Candidate | None] = [None] * m
        self._floor = [0] * m  # bin before which the motion stood still
        self.leaning: list[int] = []
        """Marks found to stand still at a new place with the newest bin."""
        self.active: Mask = np.zeros(m, bool)
        """Marks in asynchronous whirl now."""
        self.began: list[float | None] = [None] * m
        """When the present whirl of each mark began, since the first sample [s]."""
        self.certain = np.full(m, math.inf)
        """When the whirl of each mark was certain [rev]; inf without whirl."""
        self.threshold = np.full(m, criteria.onset_radius)
        """Threshold of the radius over the clearance, shape (m,)."""

    def update(self, history: History, baseline: Baseline, pace: Array, coherence: Array) -> list[Crossing]:
        """Takes in the newest bin; `pace` of the asynchronous part [rad/s], shape (m,). Returns whirl that began."""
        self.leaning = []
        if history.length < 4:
            self._candidates = [None] * len(self._candidates)
            return []
        bins = min(BINS // 2, max(1, history.span(0.5)))
        window = history.newest(max(4, bins))
        time = history.time[window]
        back = history.vector[window, ASYNCHRONOUS] * np.exp((-1j * pace) * (time - time[-1])[:, None])
        back /= self._clearance
        self.noise.update(back[-4:], self.active)
        width, remaining = self._averaging(bins)
        radius = np.abs(back[-width:].sum(axis=0)) / width
        self.threshold = np.maximum(self._criteria.onset_radius, self._criteria.false_alarm_factor * remaining)
        release = (self.threshold - remaining).tolist()
        found = []
        for mark, (size, threshold) in enumerate(zip(radius.tolist(), self.threshold.tolist(), strict=True)):
            if self.began[mark] is not None:
                continue
            since = self._watch(mark, size, threshold, release[mark], history)
            if since:
                known = Evidence(
                    mark=mark,
                    clearance=float(self._clearance[mark]),
                    threshold=self._criteria.onset_radius,
                    size=size,
                    noise=float(self.noise.level[mark]),
                    width=width,
                    coherence=float(coherence[mark]),
                    offset=complex(baseline.offset[mark]),
                    synchronous=complex(baseline.synchronous[mark]),
                )
                trusted = history.count - self._floor[mark]
                crossing = asynchronous_crossing(history, known, float(pace[mark]), since, trusted)
                self._candidates[mark] = None
                self.began[mark] = crossing.time
                self.active[mark] = True
                self.certain[mark] = history.travel[history.newest(1).start]
                found.append(crossing)
        return found

    @property
    def candidates(self) -> Mask:
        """Marks that may have begun to whirl, shape (m,)."""
        return np.array([candidate is not None for candidate in self._candidates])

    def release(self, orbit: Orbit, history: History) -> list[int]:
        """Ends the whirl of marks whose orbit has become small or stands still; returns them."""
        if not self.active.any():
            return []
        rules = self._criteria
        fall = rules.release_radius / rules.onset_radius
        small = (orbit.lasting < fall * self.threshold) | (orbit.radius[0] < 0.5 * fall * self.threshold)
        ended = self.active & (small | self._still(history))
        marks: list[int] = np.flatnonzero(ended).tolist()
        for mark in marks:
            self.active[mark] = False
            self.certain[mark] = math.inf
            self.began[mark] = self._candidates[mark] = None
            self._floor[mark] = history.count
        return marks

    def _still(self, history: History) -> Mask:
        """Whether the asynchronous part has not turned for `patience` revolutions, in the hole or in the string."""
        window = history.newest(history.span(self._criteria.patience))
        travel = history.travel[window]
        if travel[-1] - travel[0] < self._criteria.patience - 0.5:
            return np.zeros(self.active.shape, bool)
        turned = history.turned[window, ASYNCHRONOUS]
        turned = turned[-1] - turned[0]
        angle = history.angle[window]
        turn = np.minimum(np.abs(turned), np.abs(turned - (angle[-1] - angle[0])))
        still: Mask = (turn < self._criteria.least_turn) & (travel[0] > self.certain)
        return still

    def earliest(self, but: Mask) -> float:
        """When the oldest candidate crossed [s], `but` some marks left out; inf if there is none."""
        open_ones = [
            candidate.time
            for candidate, left_out in zip(self._candidates, but.tolist(), strict=True)
            if candidate is not None and not left_out
        ]
        return min(open_ones, default=math.inf)

    def _averaging(self, most: int) -> tuple[int, Array]:
        """Bins to average over, as few as bring the noise down enough, and the noise that remains."""
        level = self.noise.level
        width = 1
        largest = float(level.max()) * self._criteria.false_alarm_factor
        while width * 2 <= most and largest > self._criteria.onset_radius * math.sqrt(width):
            width *= 2
        return width, level / math.sqrt(width)

    def _watch(self, mark: int, size: float, threshold: float, release: float, history: History) -> int:
        """For how many bins the candidate of a mark has been above, if it has become certain; else 0."""
        candidate = self._candidates[mark]
        if candidate is None or size < release:
            above = size > threshold
            self._candidates[mark] = self._start(mark, history) if above else None
            return 0
        newest = history.newest(1).start
        revolutions = float(history.travel[newest]) - candidate.travel
        if revolutions < self._criteria.sustain:
            return 0
        turned = float(history.turned[newest, ASYNCHRONOUS, mark]) - candidate.turned
        relative = turned - (float(history.angle[newest]) - candidate.angle)
        turn = min(abs(turned), abs(relative))
        if turn >= self._criteria.least_turn:
            return history.count - candidate.bin + 1
        if revolutions > self._criteria.patience:
            self._floor[mark] = history.count
            self._candidates[mark] = None
            self.leaning.append(mark)
        return 0

    @staticmethod
    def _start(mark: int, history: History) -> _Candidate:
        newest = history.newest(1).start
        return _Candidate(
            history.count,
            float(history.time[newest]),
            float(history.travel[newest]),
            float(history.angle[newest]),
            float(history.turned[newest, ASYNCHRONOUS, mark]),
        )
