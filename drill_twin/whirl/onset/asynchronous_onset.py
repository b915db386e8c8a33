# SPDX-License-Identifier: Apache-2.0
"""Detection of the onset of asynchronous whirl on the stream.

A mark whirls if the radius of its asynchronous part stays above its threshold for one revolution and sweeps at least
30 degrees meanwhile, in the frames of hole and string. In a hole known to be inclined, or where it precesses at less
than 1/24 of the rotation, it must sweep 90 degrees: a string that settles at another place, as one that friction pushes
up the low side, sweeps less. The threshold is 5 % of the clearance, or 4.5 times the noise that is left after averaging
over at most half a revolution, if that is larger. The reported time is that at which the radius first crossed 5 %,
found backwards (`threshold_crossing`).

A radius that has not swept 30 degrees in six revolutions is a changed offset or bow: the separation is restarted, and
so is the detection. A displaced string that begins to precess within these six revolutions has whirled since it was
displaced; so has one that stays displaced and sweeps 30 degrees about its former position within 28 revolutions, or
until another mark is detected. In the first six revolutions the steady position is not known (in an inclined hole the
string falls to the low side): a radius that crosses then must sweep the angle about the hole's axis, in a hole
known to be inclined what happens in the first two revolutions is the fall.

False alarms: white noise of standard deviation s per axis (after averaging) is above 4.5 s with probability
exp(-4.5^2 / 2) = 4e-5, and must be so in each of the two or more independent averages of a revolution, which gives less
than 1e-8 per revolution and mark: one in a year for four marks at 2 rev/s. `test/whirl/test_steady.py` checks for none
in as many revolutions as four marks make in a day, with noise of 5 % of the clearance. Noise that is not white over a
revolution (slow drift of a camera) is not covered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, History
from drill_twin.whirl.onset.averaged_radius import AveragedRadius
from drill_twin.whirl.onset.swept_angle import SweptAngle
from drill_twin.whirl.onset.threshold_crossing import Crossing, Detection, asynchronous_crossing, steady_position
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.runout_separation import RunoutSeparation

INTERVAL = 4
"""Interval at which a displaced mark is checked [bins]."""


@dataclass
class _Candidate:
    """Crossing of the threshold that is not confirmed."""

    bin: int
    time: float
    revolutions: float
    noise: float


@dataclass
class _Displacement:
    """Candidate with the steady position that it left, which is valid from a bin on."""

    candidate: _Candidate
    offset: complex
    synchronous: complex
    valid_from: int


class OnsetDetector:
    """Detector of asynchronous whirl of each mark, of its begin and its end."""

    def __init__(self, clearance: Array, inclined: Mask, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self._averaged = AveragedRadius(clearance, criteria)
        self.noise = self._averaged.noise
        """Noise of the bins."""
        self._candidates: list[_Candidate | None] = [None] * m
        self._displaced: list[_Displacement | None] = [None] * m
        self._inclined: list[bool] = inclined.tolist()
        self._falling: set[int] = set(np.flatnonzero(inclined).tolist())  # to the low side, in the first revolutions
        self._valid_from = [0] * m  # bin from which the present steady position is valid
        self._rate: Array = np.zeros(m)
        self.moved: list[int] = []
        """Marks whose steady position was found to have changed with the newest bin."""
        self.active: Mask = np.zeros(m, bool)
        """Marks in asynchronous whirl now."""
        self.began: list[float | None] = [None] * m
        """Start of the present whirl of each mark, since the first sample [s]."""
        self.detected = np.full(m, math.inf)
        """Detection of the present whirl of each mark [rev]; inf without whirl."""

    def update(self, history: History, separation: RunoutSeparation, rate: Array, coherence: Array) -> list[Crossing]:
        """Check the newest bin; return the crossings of marks whose whirl is now detected.

        Args:
            history: The last revolutions.
            separation: Offset and synchronous part.
            rate: Rate of the asynchronous part [rad/s], shape (m,).
            coherence: Its coherence, shape (m,).
        """
        self.moved, self._rate = [], rate
        if history.length < 4:
            self._candidates = [None] * len(self._candidates)
            self._displaced = [None] * len(self._displaced)
            return []
        averaged = self._averaged
        averaged.update(history, rate, self.active)
        if self._falling and history.revolutions[history.newest(1).start] > self._criteria.falling_time:
            self._land(history)
        whirls: dict[int, _Displacement] = {}
        marks = zip(averaged.radius.tolist(), averaged.threshold.tolist(), averaged.release.tolist(), strict=True)
        for mark, (radius, threshold, release) in enumerate(marks):
            if self.began[mark] is not None or mark in self._falling:
                continue
            whirl = self._confirm(mark, radius, threshold, release, history, separation)
            if self._displaced[mark] is not None:
                whirl = self._recheck(mark, threshold, history, whirling=whirl is not None) or whirl
            if whirl is not None:
                whirls[mark] = whirl
        if whirls or self.active.any():  # the string whirls as one: so do the other marks that are displaced
            displaced = enumerate(self._displaced)
            whirls |= {mark: whirl for mark, whirl in displaced if whirl is not None and mark not in whirls}
        return [
            self._start_whirl(mark, whirl, history, float(rate[mark]), float(coherence[mark]), separation)
            for mark, whirl in whirls.items()
        ]

    def release(self, orbit: Orbit, history: History) -> list[int]:
        """End the whirl of marks whose orbit has become small or constant; return them."""
        if not self.active.any():
            return []
        criteria, threshold = self._criteria, self._averaged.threshold
        fall = criteria.release_radius / criteria.onset_radius
        small = (orbit.window_radius < fall * threshold) | (orbit.radius[0] < 0.5 * fall * threshold)
        constant = self._constant(history)
        for mark in np.flatnonzero(self.active & constant & ~small).tolist():
            constant[mark] = not _swept(history, mark, history.bins_in(criteria.sweep_window)).steady
        marks: list[int] = np.flatnonzero(self.active & (small | constant)).tolist()
        for mark in marks:
            self.active[mark] = False
            self.detected[mark] = math.inf
            self.began[mark] = self._candidates[mark] = self._displaced[mark] = None
            self._valid_from[mark] = history.count
        return marks

    @property
    def candidates(self) -> Mask:
        """Marks that may have begun to whirl, shape (m,)."""
        return np.array([candidate is not None for candidate in self._candidates])

    def earliest_candidate(self, exclude: Mask) -> float:
        """Time of the earliest candidate [s], some marks excluded; inf if there is none."""
        times = [
            candidate.time
            for candidate, excluded in zip(self._candidates, exclude.tolist(), strict=True)
            if candidate is not None and not excluded
        ]
        return min(times, default=math.inf)

    def _land(self, history: History) -> None:
        """End the fall of the marks in an inclined hole: where they lie now is their steady position."""
        for mark in self._falling:
            self._valid_from[mark] = history.count
        self.moved += self._falling
        self._falling = set()

    def _confirm(
        self, mark: int, radius: float, threshold: float, release: float, history: History, separation: RunoutSeparation
    ) -> _Displacement | None:
        """Start, drop or confirm the candidate of a mark; return it once it is confirmed as whirl."""
        criteria, candidate = self._criteria, self._candidates[mark]
        newest = history.newest(1).start
        now = float(history.revolutions[newest])
        if candidate is None or radius < release:
            noise = float(self.noise.level[mark])
            started = _Candidate(history.count, float(history.time[newest]), now, noise)
            self._candidates[mark] = started if radius > threshold else None
            return None
        elapsed = now - candidate.revolutions
        if elapsed < criteria.sustain:
            return None
        since = history.count - candidate.bin + 1
        early = self._early(candidate)
        swept = _swept(history, mark, since, complex(separation.arm[mark]) if early else None)
        position = complex(separation.offset[mark]), complex(separation.synchronous[mark])
        valid_from = self._valid_from[mark]
        if self._whirls(swept, mark, history):
            return _Displacement(candidate, *position, valid_from)
        turns = swept.smallest >= criteria.least_swept_angle  # as yet too slowly
        if elapsed > (criteria.longest_sweep_window if turns else criteria.sweep_window):
            if not early and self._displaced[mark] is None:
                position = steady_position(history, mark, since, history.count - valid_from) or position
                self._displaced[mark] = _Displacement(candidate, *position, valid_from)
            self._valid_from[mark] = history.count
            self._candidates[mark] = None
            self.moved.append(mark)
        return None

    def _recheck(self, mark: int, threshold: float, history: History, *, whirling: bool) -> _Displacement | None:
        """Drop the displacement of a mark if it came back; return it if the mark whirls about its former position."""
        displaced = self._displaced[mark]
        if displaced is None or (history.count % INTERVAL and not whirling):
            return None
        bins = history.count - displaced.candidate.bin + 1
        newest = history.newest(1).start
        window = history.newest(min(bins, history.length))
        position, phasor = history.sample[window, 0, mark], history.sample[window, 1, mark]
        vector = position - displaced.offset - displaced.synchronous * phasor
        half = history.bins_in(0.5)
        back = abs(complex(vector[-half:].sum())) < half * threshold * float(self._clearance[mark])
        late = history.revolutions[newest] - displaced.candidate.revolutions > self._criteria.longest_sweep_window
        if back or late or bins > history.length:
            self._displaced[mark] = None
            return None
        if whirling:
            return displaced
        swept = SweptAngle(vector, history.angle[window], half)
        return displaced if self._whirls(swept, mark, history) else None

    def _start_whirl(
        self,
        mark: int,
        whirl: _Displacement,
        history: History,
        rate: float,
        coherence: float,
        separation: RunoutSeparation,
    ) -> Crossing:
        """Mark the begin of a whirl and find the time of its crossing."""
        averaged, candidate = self._averaged, whirl.candidate
        noise = float(self.noise.level[mark])
        if self.noise.converged:
            noise = min(noise, candidate.noise)  # irregular motion since the crossing is not noise
        detection = Detection(
            mark=mark,
            clearance=float(self._clearance[mark]),
            threshold=self._criteria.onset_radius,
            radius=float(averaged.radius[mark]),
            noise=noise,
            width=averaged.width_for(noise, averaged.width),
            coherence=coherence,
            offset=whirl.offset,
            synchronous=whirl.synchronous,
            arm=complex(separation.arm[mark]) if self._early(candidate) else None,
        )
        since = history.count - candidate.bin + 1
        crossing = asynchronous_crossing(history, detection, rate, since, history.count - whirl.valid_from)
        self._candidates[mark] = self._displaced[mark] = None
        self.began[mark] = crossing.time
        self.active[mark] = True
        self.detected[mark] = history.revolutions[history.newest(1).start]
        return crossing

    def _constant(self, history: History) -> Mask:
        """Marks whose asynchronous part has swept no angle in `sweep_window`, in the frame of hole or string."""
        criteria = self._criteria
        window = history.newest(history.bins_in(criteria.sweep_window))
        revolutions = history.revolutions[window]
        if revolutions[-1] - revolutions[0] < criteria.sweep_window - 0.5:
            return np.zeros(self.active.shape, bool)
        in_hole = history.unwrapped[window, ASYNCHRONOUS]
        in_string = in_hole - history.angle[window][:, None]
        range_ = np.minimum(np.ptp(in_hole, axis=0), np.ptp(in_string, axis=0))
        constant: Mask = (range_ < criteria.least_swept_angle) & (revolutions[0] > self.detected)
        return constant

    def _whirls(self, swept: SweptAngle, mark: int, history: History) -> bool:
        """Check that the vector of a mark orbits, and does not settle at another place."""
        criteria = self._criteria
        if swept.smallest < criteria.least_swept_angle:
            return False
        window = history.newest(history.bins_in(criteria.orbit_window))
        angle, time = history.angle[window], history.time[window]
        precession = abs(float(self._rate[mark])) * float(time[-1] - time[0])
        slow = precession < criteria.settling_ratio * abs(float(angle[-1] - angle[0]))
        return not (slow or self._inclined[mark]) or swept.in_hole >= criteria.settling_angle

    def _early(self, candidate: _Candidate) -> bool:
        """True if a candidate crossed before the string's steady position was known."""
        return candidate.revolutions < self._criteria.separation_memory


def _swept(history: History, mark: int, bins: int, arm: complex | None = None) -> SweptAngle:
    """Angle swept over the newest `bins` by the asynchronous part or, with an `arm` [m], about the hole's axis."""
    window = history.newest(min(bins, history.length))
    rotation, half = history.angle[window], history.bins_in(0.5)
    if arm is not None:
        return SweptAngle(history.sample[window, 0, mark] - arm * history.sample[window, 1, mark], rotation, half)
    vector, angle = history.vector[window, ASYNCHRONOUS, mark], history.unwrapped[window, ASYNCHRONOUS, mark]
    return SweptAngle(vector, rotation, half, angle)
