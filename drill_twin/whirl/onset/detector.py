# SPDX-License-Identifier: Apache-2.0
"""Onset of whirl, found on the stream.

A mark whirls when the radius of its asynchronous part stays over its threshold for one revolution, and has by then
turned by at least 30 degrees as seen from the hole and from the string. The threshold is 5 % of the clearance. Where
that is not 4.5 times the noise that is left after averaging over half a revolution at most, the threshold is raised to
4.5 times that noise. The time reported is when the radius first crossed 5 %, found by looking back (`dating`).

A radius that has not turned in six revolutions belongs to a string that leans over or has got a new bow: its new
place is learned, and the watch begins anew. A string that is thrown out and begins to turn within six revolutions has
whirled since it was thrown out; so has one that stays out and turns by 30 degrees about its old place within 28
revolutions, or when another mark whirls by then. In the first six revolutions the string's steady place is not known
yet (in an inclined hole it falls to the low side): a radius that crosses then must turn about the hole's axis.

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

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, History
from drill_twin.whirl.onset.swept_angle import Turned
from drill_twin.whirl.onset.threshold_crossing import Crossing, Evidence, asynchronous_crossing, old_place
from drill_twin.whirl.orbit.noise import Noise
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.runout_separation import Baseline
from drill_twin.whirl.sample_bins import BINS

OFTEN = 4
"""A mark that was thrown out is looked at again with every fourth bin."""


@dataclass
class _Candidate:
    """A radius above its threshold, not certain yet."""

    bin: int
    time: float
    travel: float
    noise: float


@dataclass
class _Lean:
    """A candidate that did not turn in time, and the place it was thrown out from."""

    candidate: _Candidate
    offset: complex
    synchronous: complex
    floor: int


class OnsetDetector:
    """Watches the asynchronous part of each mark: has it begun to whirl, and does it still?"""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self.noise = Noise(m)
        self._candidates: list[_Candidate | None] = [None] * m
        self._leans: list[_Lean | None] = [None] * m
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
            self._leans = [None] * len(self._leans)
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
        certain: list[tuple[int, _Lean]] = []
        for mark, (size, threshold) in enumerate(zip(radius.tolist(), self.threshold.tolist(), strict=True)):
            if self.began[mark] is not None:
                continue
            whirl = self._watch(mark, size, threshold, release[mark], history, baseline)
            if self._leans[mark] is not None:
                whirl = self._revisit(mark, threshold, history, certain=whirl is not None) or whirl
            if whirl is not None:
                certain.append((mark, whirl))
        if certain or self.active.any():
            certain += self._thrown_out_with_it([mark for mark, _ in certain])
        return [
            self._enter(
                mark, whirl, float(radius[mark]), width, history, float(pace[mark]), float(coherence[mark]), baseline
            )
            for mark, whirl in certain
        ]

    def _enter(
        self,
        mark: int,
        whirl: _Lean,
        size: float,
        width: int,
        history: History,
        pace: float,
        coherence: float,
        baseline: Baseline,
    ) -> Crossing:
        """A mark is certain to whirl since its candidate crossed."""
        noise = float(self.noise.level[mark])
        if self.noise.learned:
            noise = min(noise, whirl.candidate.noise)  # being thrown about is not noise
        known = Evidence(
            mark=mark,
            clearance=float(self._clearance[mark]),
            threshold=self._criteria.onset_radius,
            size=size,
            noise=noise,
            width=self._width(noise, width),
            coherence=coherence,
            offset=whirl.offset,
            synchronous=whirl.synchronous,
            arm=complex(baseline.arm[mark]) if self._early(whirl.candidate) else None,
        )
        since = history.count - whirl.candidate.bin + 1
        crossing = asynchronous_crossing(history, known, pace, since, history.count - whirl.floor)
        self._candidates[mark] = self._leans[mark] = None
        self.began[mark] = crossing.time
        self.active[mark] = True
        self.certain[mark] = history.travel[history.newest(1).start]
        return crossing

    def _thrown_out_with_it(self, but: list[int]) -> list[tuple[int, _Lean]]:
        """The marks that stay where they were thrown out: the string whirls as one."""
        return [(mark, lean) for mark, lean in enumerate(self._leans) if lean is not None and mark not in but]

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
        still = self._still(history)
        for mark in np.flatnonzero(self.active & still & ~small).tolist():
            still[mark] = not self._turned(history, mark, history.span(self._criteria.patience)).creeps
        ended = self.active & (small | still)
        marks: list[int] = np.flatnonzero(ended).tolist()
        for mark in marks:
            self.active[mark] = False
            self.certain[mark] = math.inf
            self.began[mark] = self._candidates[mark] = self._leans[mark] = None
            self._floor[mark] = history.count
        return marks

    def _still(self, history: History) -> Mask:
        """Whether the asynchronous part has not turned for `patience` revolutions, in the hole or in the string."""
        window = history.newest(history.span(self._criteria.patience))
        travel = history.travel[window]
        if travel[-1] - travel[0] < self._criteria.patience - 0.5:
            return np.zeros(self.active.shape, bool)
        turned = history.turned[window, ASYNCHRONOUS]
        relative = turned - history.angle[window][:, None]
        turn = np.minimum(np.ptp(turned, axis=0), np.ptp(relative, axis=0))
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
        width = self._width(float(level.max()), most)
        return width, level / math.sqrt(width)

    def _width(self, noise: float, most: int) -> int:
        """Bins, at `most` so many, that bring the noise of a bin down enough."""
        width = 1
        while width * 2 <= most and noise * self._criteria.false_alarm_factor > self._criteria.onset_radius * math.sqrt(
            width
        ):
            width *= 2
        return width

    def _watch(
        self, mark: int, size: float, threshold: float, release: float, history: History, baseline: Baseline
    ) -> _Lean | None:
        """The candidate of a mark, with the place it left, if it has become certain."""
        rules, candidate = self._criteria, self._candidates[mark]
        if candidate is None or size < release:
            above = size > threshold
            self._candidates[mark] = self._start(history, float(self.noise.level[mark])) if above else None
            return None
        revolutions = float(history.travel[history.newest(1).start]) - candidate.travel
        if revolutions < rules.sustain:
            return None
        since = history.count - candidate.bin + 1
        early = self._early(candidate)
        turned = self._turned(history, mark, since, complex(baseline.arm[mark]) if early else None)
        floor = self._floor[mark]
        if turned.least >= rules.least_turn:
            return _Lean(candidate, complex(baseline.offset[mark]), complex(baseline.synchronous[mark]), floor)
        if revolutions > rules.patience:
            if not early and self._leans[mark] is None:
                old = old_place(history, mark, since, history.count - floor)
                offset, synchronous = old or (complex(baseline.offset[mark]), complex(baseline.synchronous[mark]))
                self._leans[mark] = _Lean(candidate, offset, synchronous, floor)
            self._floor[mark] = history.count
            self._candidates[mark] = None
            self.leaning.append(mark)
        return None

    def _revisit(self, mark: int, threshold: float, history: History, *, certain: bool) -> _Lean | None:
        """A mark that was thrown out, if it has turned about its old place by now, or is `certain` to whirl."""
        lean = self._leans[mark]
        if lean is None or (history.count % OFTEN and not certain):
            return None
        bins = history.count - lean.candidate.bin + 1
        newest = history.newest(1).start
        window = history.newest(min(bins, history.length))
        place, turn = history.sample[window, 0, mark], history.sample[window, 1, mark]
        vector = place - lean.offset - lean.synchronous * turn
        half = history.span(0.5)
        back = abs(complex(vector[-half:].sum())) < half * threshold * float(self._clearance[mark])
        late = history.travel[newest] - lean.candidate.travel > self._criteria.longest_patience
        if back or late or bins > history.length:
            self._leans[mark] = None
            return None
        if certain:
            return lean
        turned = Turned(vector, history.angle[window], half)
        return lean if turned.least >= self._criteria.least_turn else None

    @staticmethod
    def _turned(history: History, mark: int, bins: int, arm: complex | None = None) -> Turned:
        """Turn over the newest `bins` of the asynchronous part, or, with an `arm` [m], about the hole's axis."""
        window = history.newest(min(bins, history.length))
        rotation, half = history.angle[window], history.span(0.5)
        if arm is not None:
            return Turned(history.sample[window, 0, mark] - arm * history.sample[window, 1, mark], rotation, half)
        return Turned(
            history.vector[window, ASYNCHRONOUS, mark], rotation, half, history.turned[window, ASYNCHRONOUS, mark]
        )

    def _early(self, candidate: _Candidate) -> bool:
        """Whether it crossed before the string's steady place was known."""
        return candidate.travel < self._criteria.baseline_window

    @staticmethod
    def _start(history: History, noise: float) -> _Candidate:
        newest = history.newest(1).start
        return _Candidate(history.count, float(history.time[newest]), float(history.travel[newest]), noise)
