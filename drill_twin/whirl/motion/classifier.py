# SPDX-License-Identifier: Apache-2.0
"""Which motion each mark and the string are in: `MotionState` and `Criteria` put to work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.motion.irregularity import Roughness
from drill_twin.whirl.motion.state_hysteresis import Votes
from drill_twin.whirl.motion.timeline import NO_WHIRL
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.string_shape import Shape
from drill_twin.whirl.text import in_words

LONG_AGO = 8.0
"""Irregular motion is dated back by at most this many half windows."""


def _held(flag: Mask, on: Mask, off: Mask) -> Mask:
    """A flag with hysteresis: set by `on`, cleared by `off`, kept otherwise."""
    result: Mask = on | (flag & ~off)
    return result


class MotionClassifier:
    """Motion state of each mark and, last, of the string."""

    def __init__(self, infos: Sequence[MarkInfo], criteria: Criteria) -> None:
        marks = len(infos)
        self._criteria = criteria
        self._rolling = np.array([info.rolling_ratio for info in infos])
        self.votes = Votes(marks + 1, criteria)
        self._every = np.arange(marks)
        self._roughness = Roughness(marks, criteria)
        self._touching: Mask = np.zeros(marks, bool)
        self._gripping: Mask = np.zeros(marks, bool)  # the contact point slips little, if there is contact
        self._helical = self._two_sided = False

    def update(
        self,
        orbit: Orbit,
        shape: Shape,
        whirling: tuple[Mask, Mask],
        began: Sequence[float | None],
        certain: Array,
        ratio: Array,
        at: tuple[float, float, float],
    ) -> bool:
        """Casts the votes; `whirling` the marks in asynchronous and in synchronous whirl, `began` when [s], `certain`
        since when [rev].

        `at` holds the time [s], the travel [rev] and the time of the first sample [s]. Returns whether any state
        changed.
        """
        self._flag(orbit, shape, whirling[0], certain, ratio, at)
        sense = ratio > 0.0
        whirls = whirling[0] | whirling[1]
        flags = zip(
            whirls.tolist(),
            self._roughness.irregular.tolist(),
            (self._touching & self._gripping).tolist(),
            sense.tolist(),
            strict=True,
        )
        resting = abs(orbit.recent_rotation) < self._criteria.rest_rotation
        states = [self._of_mark(resting, *flag) for flag in flags]
        if not resting:
            unseen = np.ones_like(orbit.seen) if orbit.aliased else ~orbit.seen
            states = [MotionState.UNSEEN if hidden else state for hidden, state in zip(unseen, states, strict=True)]
        # The string moves as the whirling mark that moves most, if any whirls.
        whirls = whirls & orbit.seen
        leader = int(np.argmax(np.where(whirls, shape.power, -1.0))) if whirls.any() else shape.leader
        if not orbit.seen[leader]:
            leader = int(np.argmax(np.where(orbit.seen, shape.power, -1.0)))
        states.append(self._of_string(states[leader]))
        time, travel, origin = at
        earliest = min((start for start in began if start is not None), default=None)
        leaders = [*range(self._every.size), leader]
        starts = [*began, earliest]
        dates = [
            self._date(mark, held, vote, start, orbit.lag, time)
            for mark, held, vote, start in zip(leaders, self.votes.states, states, starts, strict=True)
        ]
        changed, settled = self.votes.cast(states, dates, orbit.lag, time, travel)
        for subject in (*changed, *settled):
            mark = leaders[subject]
            row = 0 if whirling[0][mark] else 1
            words = in_words(self.votes.states[subject], orbit, shape, self._criteria, mark, row, float(ratio[mark]))
            if subject in settled:
                self.votes.describe(subject, words)
            else:
                self.votes.enter(subject, words, origin)
        return bool(changed)

    def _date(
        self, mark: int, held: MotionState, vote: MotionState, began: float | None, lag: float, time: float
    ) -> float | None:
        """When the state voted for began [s], where more is known of it than the votes."""
        if held in NO_WHIRL:
            return None if vote in NO_WHIRL else began
        if vote is MotionState.IRREGULAR:
            return max(float(self._roughness.rose[mark]), time - LONG_AGO * lag) - lag
        if held is MotionState.IRREGULAR and vote not in NO_WHIRL:
            # The last rough window ends up to a window, two lags, after the change.
            return max(float(self._roughness.last[mark]), time - LONG_AGO * lag) - 1.5 * lag
        return None

    def _flag(
        self,
        orbit: Orbit,
        shape: Shape,
        asynchronous: Mask,
        certain: Array,
        ratio: Array,
        at: tuple[float, float, float],
    ) -> None:
        rules = self._criteria
        row = np.where(asynchronous, 0, 1)
        coherence = orbit.coherence[row, self._every]
        unevenness = orbit.unevenness[row, self._every]
        self._roughness.update(coherence, unevenness, at[1] - certain > rules.settled, at[0], at[1])
        self._touching = _held(
            self._touching,
            orbit.contact > rules.contact_fraction,
            orbit.contact < rules.contact_fraction - rules.contact_hysteresis,
        )
        slip = self._slip(ratio)
        self._gripping = _held(self._gripping, slip < rules.rolling_slip, slip > rules.rolling_slip + 0.1)
        several = shape.heights > 1
        self._helical = several and shape.planarity < rules.planar + (0.1 if self._helical else 0.0)
        self._two_sided = several and shape.sides > rules.lobe - (0.1 if self._two_sided else 0.0)

    def _slip(self, ratio: Array) -> Array:
        """Slip of the contact point over the rim speed; 0 for any backward whirl where the rim is not known."""
        known = np.where(self._rolling < 0.0, self._rolling, -1.0)
        slip = np.where(self._rolling < 0.0, np.abs(1.0 - ratio / known), 0.0)
        result: Array = np.where(ratio < 0.0, slip, np.inf)
        return result

    @staticmethod
    def _of_mark(resting: bool, whirl: bool, irregular: bool, rolling: bool, forward: bool) -> MotionState:
        if resting:
            return MotionState.AT_REST
        if not whirl:
            return MotionState.FIXED_AXIS
        if irregular:
            return MotionState.IRREGULAR
        if rolling:
            return MotionState.ROLLING
        return MotionState.FORWARD_WHIRL if forward else MotionState.REVERSE_WHIRL

    def _of_string(self, leader: MotionState) -> MotionState:
        if leader in NO_WHIRL or leader is MotionState.IRREGULAR:
            return leader
        if self._helical:
            return MotionState.SPIRAL
        return MotionState.SECOND_BENDING if self._two_sided else leader
