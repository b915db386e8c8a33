# SPDX-License-Identifier: Apache-2.0
"""Motion states that do not flicker: every estimate votes, and a state holds until another leads clearly."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.motion.timeline import NO_WHIRL, Timeline

STATES = tuple(MotionState)
INDEX = {state: i for i, state in enumerate(STATES)}

RISE = 0.1
"""A new state is dated to when its share of the votes last rose above this."""
SETTLED = 2.0
"""A state that has held for this long is described anew [rev]."""


class Votes:
    """The states of several subjects (the marks, then the string), with their timelines."""

    def __init__(self, subjects: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._share = np.zeros((subjects, len(STATES)))
        self._since = np.zeros((subjects, len(STATES)))
        self._held = [INDEX[MotionState.AT_REST]] * subjects
        self._travel = self._time = 0.0
        self._every = np.arange(subjects)
        self.states = tuple(STATES[i] for i in self._held)
        """State that holds, of each subject."""
        self.criterion = ["no rotation seen yet"] * subjects
        """What decided the state of each subject, in words."""
        self.timelines = [Timeline() for _ in range(subjects)]
        """What each subject did."""

    @property
    def confidence(self) -> Array:
        """Share of the recent votes for the state that holds, 0 to 1, shape (subjects,)."""
        share: Array = self._share[self._every, self._held]
        return share

    def cast(
        self, votes: Sequence[MotionState], dates: Sequence[float | None], lag: float, time: float, travel: float
    ) -> tuple[list[int], list[int]]:
        """Casts a vote for each subject at `time` [s] and `travel` [rev].

        Returns the subjects whose state changes, to `enter`, and those whose state has settled, to `describe`.

        A state that changes is dated to `dates` [s], or, where that is None, to when it was first voted for less the
        `lag` of the features [s].
        """
        rules = self._criteria
        first = not self.timelines[0]
        passed = max(travel - self._travel, 4.0 * rules.rest_rotation * (time - self._time))
        self._travel, self._time = travel, time
        gain = 1.0 if first else 1.0 - math.exp(-passed / rules.vote_memory)
        cast = [INDEX[vote] for vote in votes]
        before = self._share[self._every, cast].tolist()
        self._share *= 1.0 - gain
        self._share[self._every, cast] += gain
        after = self._share[self._every, cast].tolist()
        holding = self._share[self._every, self._held].tolist()
        changed, settled = [], []
        for subject, vote in enumerate(cast):
            held = self._held[subject]
            if before[subject] < RISE <= after[subject]:
                back = 0.0 if STATES[held] in NO_WHIRL else lag
                self._since[subject, vote] = 0.0 if first else time - back
            if vote != held and after[subject] >= holding[subject] + rules.vote_lead:
                date = dates[subject]
                if date is not None:
                    self._since[subject, vote] = date
                self._held[subject] = vote
                changed.append(subject)
            elif first:
                changed.append(subject)
            else:
                timeline = self.timelines[subject]
                timeline.hold(holding[subject], passed)
                if timeline.untold(travel, SETTLED):
                    settled.append(subject)
        if changed:
            self.states = tuple(STATES[i] for i in self._held)
        return changed, settled

    def enter(self, subject: int, criterion: str, origin: float) -> None:
        """Notes the state just entered and what decided it; `origin` is the time of the first sample [s]."""
        self.criterion[subject] = criterion
        held = self._held[subject]
        self.timelines[subject].begin(STATES[held], origin + float(self._since[subject, held]), criterion, self._travel)

    def describe(self, subject: int, criterion: str) -> None:
        """Describes a state that has settled."""
        self.criterion[subject] = criterion
        self.timelines[subject].tell(criterion)
