# SPDX-License-Identifier: Apache-2.0
"""Decisions on asynchronous whirl that need fits: its begin, its time and its end (`onset.asynchronous_onset`)."""

import math
from dataclasses import dataclass, replace

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import as_python
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import ASYNCHRONOUS, SYNCHRONOUS, newest, newest_in
from drill_twin.whirl.onset.asynchronous_onset import INTERVAL, is_converged, update_candidate, width_for
from drill_twin.whirl.onset.plane_swing import swing_radius, to_and_fro
from drill_twin.whirl.onset.swept_angle import SweptAngle
from drill_twin.whirl.onset.threshold_crossing import (
    Crossing,
    Detection,
    asynchronous_crossing,
    steady_position,
)
from drill_twin.whirl.orbit.orbit import mean_rate

RUN_UP = 28.0
"""Duration over which the rotation, and a vibration that dies, are compared with their present values [rev]: with a
damping ratio of 0.01 it has e-folded once or twice meanwhile. Chosen; at 16, a free vibration still passes for whirl in
one of 14 run-ups of the seeds from 7,300,000 on."""


@dataclass
class _Displacement:
    """Crossing of the threshold with the steady position that the mark left, which is valid from a bin on."""

    bin: int
    revolutions: float
    noise: float
    offset: complex
    synchronous: complex
    valid_from: int


class OnsetDetector:
    """Decisions on the begin and the end of asynchronous whirl of each mark."""

    def __init__(self, state: Columns) -> None:
        self._clearance = state.marks.clearance
        self._inclined: list[bool] = state.marks.inclined.tolist()
        self._history, self._separation, self._orbit = state.history, state.separation, state.orbit
        self._averaged, self._onsets, self._rate = state.averaged, state.onsets, state.carrier.carried
        self._displaced: dict[int, _Displacement] = {}
        self._valid_from = [0] * len(self._inclined)  # bin from which the present steady position is valid
        self.moved: list[int] = []
        """Marks whose steady position was found to have changed with the newest bin."""

    @property
    def _appended(self) -> int:
        """Number of bins so far."""
        return int(self._history.appended[0])

    @property
    def _revolutions(self) -> float:
        """Revolutions since the first sample at the newest bin [rev]."""
        return float(self._history.revolutions[newest(self._history, 1)][0])

    def check(self) -> list[Crossing]:
        """Check the newest bin; return the crossings of marks whose whirl is now detected."""
        onsets = self._onsets
        self.moved = []
        self._displaced = {mark: found for mark, found in self._displaced.items() if onsets.displaced[mark]}
        if onsets.falling.any() and self._revolutions > criteria.FALLING_TIME:
            self._land()
        whirls: dict[int, _Displacement] = {}
        for mark, threshold in enumerate(self._averaged.threshold.tolist()):
            if not math.isnan(onsets.began[mark]) or onsets.falling[mark]:
                continue
            whirl = self._confirm(mark)
            if mark in self._displaced:
                whirl = self._recheck(mark, threshold, whirling=whirl is not None) or whirl
            if whirl is not None:
                whirls[mark] = whirl
        if whirls or onsets.active.any():  # the string whirls as one: so do the other marks that are displaced
            for mark in np.flatnonzero(np.isnan(onsets.began) & ~onsets.plane).tolist():
                lasts = self._revolutions - float(onsets.revolutions[mark]) >= criteria.SUSTAIN
                whirl = self._candidate(mark) if lasts and not math.isnan(onsets.time[mark]) else None
                if whirl := self._displaced.get(mark, whirl):
                    whirls.setdefault(mark, whirl)
        crossings = [self._start_whirl(mark, whirl) for mark, whirl in whirls.items()]
        onsets.displaced[:] = False
        onsets.displaced[list(self._displaced)] = True
        return crossings

    def release(self) -> list[int]:
        """End the whirl of marks whose orbit has become small or constant; return them."""
        onsets, history = self._onsets, self._history
        constant = onsets.constant.copy()
        bins = newest_in(history, criteria.SWEEP_WINDOW)
        for mark in np.flatnonzero(onsets.active & constant & ~onsets.small).tolist():
            swept = self._swept(mark, bins)
            stands = swept.smallest < criteria.LEAST_SWEPT_ANGLE and not swept.steady
            constant[mark] = stands or onsets.plane[mark]
        marks: list[int] = np.flatnonzero(onsets.active & (onsets.small | constant)).tolist()
        onsets.active[marks] = onsets.displaced[marks] = False
        onsets.began[marks] = onsets.time[marks] = math.nan
        onsets.detected[marks] = math.inf
        for mark in marks:
            self._displaced.pop(mark, None)
            self._valid_from[mark] = self._appended
        return marks

    def earliest_candidate(self, exclude: Mask) -> float:
        """Time of the earliest candidate [s], some marks excluded; inf if there is none."""
        return float(np.fmin.reduce(self._onsets.time[~exclude], initial=math.inf))

    def _land(self) -> None:
        """End the fall of the marks in an inclined hole: where they lie now is their steady position."""
        for mark in np.flatnonzero(self._onsets.falling).tolist():
            self._valid_from[mark] = self._appended
            self.moved.append(mark)
        self._onsets.falling[:] = False

    def _candidate(self, mark: int) -> _Displacement:
        """Displacement of a mark by its candidate, from its present steady position."""
        onsets, separation = self._onsets, self._separation
        return _Displacement(
            int(onsets.bin[mark]), float(onsets.revolutions[mark]), float(onsets.noise[mark]),
            complex(separation.offset[mark]), complex(separation.synchronous[mark]), self._valid_from[mark],
        )  # fmt: skip

    def _confirm(self, mark: int) -> _Displacement | None:
        """Start, drop or confirm the candidate of a mark; return it once it is confirmed as whirl."""
        history, onsets = self._history, self._onsets
        if not as_python(update_candidate)(onsets, self._averaged, history, mark):
            return None
        found = self._candidate(mark)
        elapsed = self._revolutions - found.revolutions
        if elapsed < criteria.SUSTAIN:
            return None
        since = self._appended - found.bin + 1
        early = bool(onsets.early[mark])
        swept = self._swept(mark, since, complex(self._separation.arm[mark]) if early else None)
        if early and elapsed < criteria.SIDE_WINDOW and swept.in_hole < math.pi:
            return None  # a swing along the wall sweeps as much
        if self._whirls(swept, mark, since):
            return found
        if elapsed > criteria.SWEEP_WINDOW and onsets.plane[mark]:
            if not (self._inclined[mark] or early or mark in self._displaced):
                self._displaced[mark] = found
            onsets.time[mark] = math.nan
            return None
        turns = swept.smallest >= criteria.LEAST_SWEPT_ANGLE  # as yet too slowly
        if elapsed > (criteria.LONGEST_SWEEP_WINDOW if turns else criteria.SWEEP_WINDOW):
            if not early and mark not in self._displaced:
                steady = steady_position(history, mark, since, self._appended - found.valid_from)
                offset, synchronous = steady or (found.offset, found.synchronous)
                self._displaced[mark] = replace(found, offset=offset, synchronous=synchronous)
            self._valid_from[mark] = self._appended
            onsets.time[mark] = math.nan
            self.moved.append(mark)
        return None

    def _recheck(self, mark: int, threshold: float, *, whirling: bool) -> _Displacement | None:
        """Drop the displacement of a mark if it came back; return it if the mark whirls about its former position."""
        displaced, history = self._displaced[mark], self._history
        if self._appended % INTERVAL and not whirling:
            return None
        bins = self._appended - displaced.bin + 1
        window = newest(history, min(bins, history.length.item()))
        position, phasor = history.position[window, mark], history.phasor[window, mark]
        vector = position - displaced.offset - displaced.synchronous * phasor
        half = newest_in(history, 0.5)
        back = abs(complex(vector[-half:].sum())) < half * threshold * float(self._clearance[mark])
        late = self._revolutions - displaced.revolutions > criteria.LONGEST_SWEEP_WINDOW
        if back or late or bins > history.length.item():
            del self._displaced[mark]
            return None
        if whirling:
            return displaced
        swept = SweptAngle(vector, history.angle[window], half, carrier=self._carrier(mark, window))
        return displaced if self._whirls(swept, mark, bins) else None

    def _start_whirl(self, mark: int, whirl: _Displacement) -> Crossing:
        """Mark the begin of a whirl and find the time of its crossing."""
        averaged, history, onsets = self._averaged, self._history, self._onsets
        noise = float(averaged.level[mark])
        if as_python(is_converged)(averaged):
            noise = min(noise, whirl.noise)  # irregular motion since the crossing is not noise
        detection = Detection(
            mark=mark,
            clearance=float(self._clearance[mark]),
            threshold=criteria.ONSET_RADIUS,
            radius=float(averaged.radius[mark]),
            noise=noise,
            width=as_python(width_for)(noise, int(averaged.width[0])),
            coherence=float(self._orbit.coherence[0, mark]),
            offset=whirl.offset,
            synchronous=whirl.synchronous,
            arm=complex(self._separation.arm[mark]) if onsets.early[mark] else None,
        )
        since, rate = self._appended - whirl.bin + 1, float(self._rate[mark]) or float(self._orbit.rate[0, mark])
        valid = self._appended - whirl.valid_from
        if self._inclined[mark] and self._swung(mark, since):  # the search would find where the swing crossed
            valid = min(valid, since)
        crossing = asynchronous_crossing(history, detection, rate, since, valid)
        self._displaced.pop(mark, None)
        onsets.time[mark] = math.nan
        onsets.began[mark] = crossing.time
        onsets.active[mark] = True
        onsets.detected[mark] = self._revolutions
        return crossing

    def _whirls(self, swept: SweptAngle, mark: int, since: int) -> bool:
        """Check that the vector of a mark orbits since so many bins: it does not settle, nor is it synchronous."""
        history = self._history
        if swept.smallest < criteria.LEAST_SWEPT_ANGLE or self._onsets.plane[mark]:
            return False
        swing = float((self._onsets.swing * self._clearance).max())
        if self._inclined[mark] and swing > float(self._averaged.radius[mark] * self._clearance[mark]):
            return False  # another mark swings farther, on the low side: this mark follows
        window = newest(history, newest_in(history, criteria.ORBIT_WINDOW))
        angle, time = history.angle[window], history.time[window]
        precession = abs(float(self._orbit.rate[0, mark])) * float(time[-1] - time[0])
        slow = precession < criteria.SETTLING_RATIO * abs(float(angle[-1] - angle[0]))
        moved = history.vector[newest(history, min(since, history.length.item())), :, mark]
        fast = abs(self._rate[mark]) > criteria.DEFINITE_RATIO * math.tau * abs(float(self._orbit.rotation[0]))
        if self._synchronous(swept, mark) or (not fast and any(map(to_and_fro, moved[:, :SYNCHRONOUS].T))):
            return False
        return not (slow or self._inclined[mark]) or swept.in_hole >= criteria.SETTLING_ANGLE

    def _swung(self, mark: int, since: int) -> bool:
        """Check that a mark moved to and fro over the sweep window before the newest bins."""
        history = self._history
        bins = min(newest_in(history, criteria.SWEEP_WINDOW), history.length.item() - since)
        if bins <= 0:
            return False
        arm = complex(self._separation.arm[mark])
        radius: float = as_python(swing_radius)(history, arm, mark, bins, since)
        return radius > criteria.ONSET_RADIUS * float(self._clearance[mark])

    def _synchronous(self, swept: SweptAngle, mark: int) -> bool:
        """Check, while the rotation changes, for a synchronous part that does too, or a vibration that dies away."""
        history = self._history
        spans = criteria.ORBIT_WINDOW, RUN_UP
        rotation, before = (as_python(mean_rate)(history, newest_in(history, span)) for span in spans)
        if abs(rotation - before) < 0.5 * criteria.SPEED_CHANGE * abs(rotation) or rotation == 0.0:
            return False
        near = abs(float(self._orbit.rate[0, mark]) / (math.tau * rotation) - 1.0) < criteria.SYNCHRONOUS_BAND
        if near and swept.in_string < criteria.SYNCHRONOUS_ANGLE:
            return True
        n, last = newest_in(history, RUN_UP), newest_in(history, 1.0)
        if last >= n:
            return False
        radius = np.abs(history.vector[newest(history, n), ASYNCHRONOUS, mark])
        means = np.convolve(radius, np.full(last, 1.0 / last), "valid")
        return bool(means[-1] < criteria.DYING_SHARE * means.max())

    def _swept(self, mark: int, bins: int, arm: complex | None = None) -> SweptAngle:
        """Angle swept over the newest `bins` by the asynchronous part or, with an `arm` [m], about the hole's axis."""
        history = self._history
        window = newest(history, min(bins, history.length.item()))
        rotation, half, carrier = history.angle[window], newest_in(history, 0.5), self._carrier(mark, window)
        if arm is not None:
            centre = history.position[window, mark] - arm * history.phasor[window, mark]
            return SweptAngle(centre, rotation, half, carrier=carrier)
        vector, angle = history.vector[window, ASYNCHRONOUS, mark], history.unwrapped[window, ASYNCHRONOUS, mark]
        return SweptAngle(vector, rotation, half, angle, carrier)

    def _carrier(self, mark: int, window: slice) -> Array | None:
        """Angle of the carrier of a mark's orbit [rad]; None without one."""
        rate, time = float(self._rate[mark]), self._history.time[window]
        return rate * (time - time[-1]) if rate else None
