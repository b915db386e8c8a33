# SPDX-License-Identifier: Apache-2.0
"""Motion states that do not flicker: every estimate votes, and a state holds until another leads clearly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.findings import MotionPeriod

STATES = tuple(MotionState)
INDEX = {state: i for i, state in enumerate(STATES)}
NO_WHIRL = frozenset({MotionState.AT_REST, MotionState.FIXED_AXIS})

LONGEST = 2000
"""Periods remembered for each subject; later ones are counted but not kept."""
RISE = 0.1
"""A new state is dated to when its share of the votes last rose above this."""


class Votes:
    """The states of several subjects (the marks, then the string), with their timelines."""

    def __init__(self, subjects: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._share = np.zeros((subjects, len(STATES)))
        self._since = np.zeros((subjects, len(STATES)))
        self._held = [INDEX[MotionState.AT_REST]] * subjects
        self._travel = self._time = 0.0
        self._every = np.arange(subjects)
        self.criterion = ["no rotation seen yet"] * subjects
        """What decided the state of each subject, in words."""
        self.timeline: list[list[MotionPeriod]] = [[] for _ in range(subjects)]
        """Periods of one state each."""
        self.dropped = [0] * subjects
        """Periods that came after the longest timeline kept."""

    @property
    def states(self) -> tuple[MotionState, ...]:
        """State that holds, of each subject."""
        return tuple(STATES[i] for i in self._held)

    @property
    def confidence(self) -> np.ndarray:
        """Share of the recent votes for the state that holds, 0 to 1, shape (subjects,)."""
        return self._share[self._every, self._held]

    def cast(
        self, votes: Sequence[MotionState], began: Sequence[float | None], time: float, travel: float
    ) -> list[int]:
        """Casts a vote for each subject at `time` [s] and `travel` [rev]; returns the subjects whose state changes.

        `began` is when the whirl of the subject began [s], None without whirl: its first state is dated to that. The
        caller then sets the words with `explain`.
        """
        rules = self._criteria
        first = not self.timeline[0]
        passed = max(travel - self._travel, 4.0 * rules.rest_rotation * (time - self._time))
        self._travel, self._time = travel, time
        gain = 1.0 if first else 1.0 - math.exp(-passed / rules.vote_memory)
        cast = [INDEX[vote] for vote in votes]
        before = self._share[self._every, cast]
        self._share *= 1.0 - gain
        self._share[self._every, cast] += gain
        changed = []
        for subject, (vote, old) in enumerate(zip(cast, before.tolist(), strict=True)):
            held = self._held[subject]
            if old < RISE <= self._share[subject, vote]:
                self._since[subject, vote] = 0.0 if first else time
            if vote != held and self._share[subject, vote] >= self._share[subject, held] + rules.vote_lead:
                onset = began[subject]
                if onset is not None and STATES[held] in NO_WHIRL:
                    self._since[subject, vote] = onset
                self._held[subject] = vote
                changed.append(subject)
            elif first:
                changed.append(subject)
        return changed

    def redate(self, subject: int, start: float) -> None:
        """Moves the first whirl of a subject back to `start` [s], where that is earlier and after the state before."""
        timeline = self.timeline[subject]
        for i, period in enumerate(timeline):
            if period.state not in NO_WHIRL:
                if i and timeline[i - 1].start_s < start < period.start_s:
                    timeline[i] = replace(period, start_s=start)
                return

    def explain(self, subject: int, criterion: str, origin: float) -> None:
        """Notes what decided the state just entered; `origin` is the time of the first sample [s]."""
        self.criterion[subject] = criterion
        timeline, held = self.timeline[subject], self._held[subject]
        if len(timeline) >= LONGEST:
            self.dropped[subject] += 1
            return
        start = origin + float(self._since[subject, held])
        if timeline:
            start = max(start, timeline[-1].start_s)
        timeline.append(MotionPeriod(start, STATES[held], criterion, float(self._share[subject, held])))
