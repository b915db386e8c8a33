# SPDX-License-Identifier: Apache-2.0
"""Which motion each mark and the string are in: `MotionState` and `Criteria` put to work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.whirl.bins import Array, Mask
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.orbit import Orbit
from drill_twin.whirl.shape import Shape
from drill_twin.whirl.votes import Votes
from drill_twin.whirl.words import in_words


def _held(flag: Mask, on: Mask, off: Mask) -> Mask:
    """A flag with hysteresis: set by `on`, cleared by `off`, kept otherwise."""
    result: Mask = on | (flag & ~off)
    return result


class MotionClassifier:
    """Motion state of each mark and, last, of the string."""

    def __init__(self, marks: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self.votes = Votes(marks + 1, criteria)
        self._every = np.arange(marks)
        self._irregular: Mask = np.zeros(marks, bool)
        self._regular_at = np.zeros(marks)  # travel at which the motion was last regular [rev]
        self._rough_at = np.zeros(marks)  # and last irregular
        self._touching: Mask = np.zeros(marks, bool)
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
        self._flag(orbit, shape, whirling[0], certain, at[1])
        sense = ratio > 0.0
        whirls = whirling[0] | whirling[1]
        flags = zip(
            whirls.tolist(),
            self._irregular.tolist(),
            self._touching.tolist(),
            sense.tolist(),
            strict=True,
        )
        resting = abs(orbit.recent_rotation) < self._criteria.rest_rotation
        states = [self._of_mark(resting, *flag) for flag in flags]
        # The string moves as the whirling mark that moves most, if any whirls.
        leader = int(np.argmax(np.where(whirls, shape.power, -1.0))) if whirls.any() else shape.leader
        states.append(self._of_string(states[leader]))
        time, travel, origin = at
        earliest = min((start for start in began if start is not None), default=None)
        changed = self.votes.cast(states, [*began, earliest], time, travel)
        for subject in changed:
            mark = leader if subject == self._every.size else subject
            row = 0 if whirling[0][mark] else 1
            words = in_words(self.votes.states[subject], orbit, shape, self._criteria, mark, row, float(ratio[mark]))
            self.votes.explain(subject, words, origin)
        return bool(changed)

    def _flag(self, orbit: Orbit, shape: Shape, asynchronous: Mask, certain: Array, travel: float) -> None:
        rules = self._criteria
        row = np.where(asynchronous, 0, 1)
        coherence = orbit.coherence[row, self._every]
        unevenness = orbit.unevenness[row, self._every]
        settled = travel - certain > rules.settled
        rough = settled & ((coherence < rules.coherence) | (unevenness > rules.unevenness))
        self._regular_at[~rough] = travel
        self._rough_at[rough] = travel
        self._irregular = _held(
            self._irregular,
            travel - self._regular_at > rules.settled,
            ~settled | (travel - self._rough_at > 2.0 * rules.settled),
        )
        self._touching = _held(
            self._touching,
            orbit.contact > rules.contact_fraction,
            orbit.contact < rules.contact_fraction - rules.contact_hysteresis,
        )

        several = shape.heights > 1
        self._helical = several and shape.planarity < rules.planar + (0.1 if self._helical else 0.0)
        self._two_sided = several and shape.sides > rules.lobe - (0.1 if self._two_sided else 0.0)

    @staticmethod
    def _of_mark(resting: bool, whirl: bool, irregular: bool, touching: bool, forward: bool) -> MotionState:
        if resting:
            return MotionState.AT_REST
        if not whirl:
            return MotionState.FIXED_AXIS
        if irregular:
            return MotionState.IRREGULAR
        if touching:
            return MotionState.ROLLING
        return MotionState.FORWARD_WHIRL if forward else MotionState.REVERSE_WHIRL

    def _of_string(self, leader: MotionState) -> MotionState:
        if leader in {MotionState.AT_REST, MotionState.FIXED_AXIS, MotionState.IRREGULAR}:
            return leader
        if self._helical:
            return MotionState.SPIRAL
        return MotionState.SECOND_BENDING if self._two_sided else leader
