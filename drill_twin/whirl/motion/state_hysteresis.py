# SPDX-License-Identifier: Apache-2.0
"""Hysteresis of the motion states: a state holds until the low-passed share of another leads clearly."""

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
"""A new state starts when its share last rose above this."""
SETTLED = 2.0
"""Duration after which the criterion of a state is described with its present numbers [rev]."""


class StateHysteresis:
    """States of several subjects (the marks, then the string), with their timelines."""

    def __init__(self, subjects: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._share = np.zeros((subjects, len(STATES)))
        self._since = np.zeros((subjects, len(STATES)))
        self._held = [INDEX[MotionState.AT_REST]] * subjects
        self._revolutions = self._time = 0.0
        self._every = np.arange(subjects)
        self.states = tuple(STATES[i] for i in self._held)
        """Present state of each subject."""
        self.criterion = ["no rotation seen yet"] * subjects
        """The criterion that decided the state of each subject, as text."""
        self.timelines = [Timeline() for _ in range(subjects)]
        """States of each subject over time."""

    @property
    def confidence(self) -> Array:
        """Share of the recent estimates for the present state, 0 to 1, shape (subjects,)."""
        share: Array = self._share[self._every, self._held]
        return share

    def update(
        self,
        estimates: Sequence[MotionState],
        starts: Sequence[float | None],
        lag: float,
        time: float,
        revolutions: float,
    ) -> tuple[list[int], list[int]]:
        """Add an estimate of the state of each subject.

        Args:
            estimates: Estimated state of each subject.
            starts: Start of a state that changes now [s]; None: when its share rose, less `lag`.
            lag: Delay of the estimates [s].
            time: Time since the first sample [s].
            revolutions: Revolutions since the first sample [rev].

        Returns:
            Subjects whose state changes, to `enter`, and those whose state has settled, to `describe`.
        """
        criteria = self._criteria
        first = not self.timelines[0]
        elapsed = max(revolutions - self._revolutions, 4.0 * criteria.rest_rotation * (time - self._time))
        self._revolutions, self._time = revolutions, time
        gain = 1.0 if first else 1.0 - math.exp(-elapsed / criteria.state_memory)
        estimated = [INDEX[state] for state in estimates]
        before = self._share[self._every, estimated].tolist()
        self._share *= 1.0 - gain
        self._share[self._every, estimated] += gain
        after = self._share[self._every, estimated].tolist()
        holding = self._share[self._every, self._held].tolist()
        changed, settled = [], []
        for subject, state in enumerate(estimated):
            held = self._held[subject]
            if before[subject] < RISE <= after[subject]:
                delay = 0.0 if STATES[held] in NO_WHIRL else lag
                self._since[subject, state] = 0.0 if first else time - delay
            if state != held and after[subject] >= holding[subject] + criteria.state_lead:
                start = starts[subject]
                if start is not None:
                    self._since[subject, state] = start
                self._held[subject] = state
                changed.append(subject)
            elif first:
                changed.append(subject)
            else:
                timeline = self.timelines[subject]
                timeline.extend(holding[subject], elapsed)
                if timeline.needs_description(revolutions, SETTLED):
                    settled.append(subject)
        if changed:
            self.states = tuple(STATES[i] for i in self._held)
        return changed, settled

    def enter(self, subject: int, criterion: str, origin: float) -> None:
        """Start the period of a changed state with its criterion; `origin` is the time of the first sample [s]."""
        self.criterion[subject] = criterion
        held = self._held[subject]
        start = origin + float(self._since[subject, held])
        self.timelines[subject].start(STATES[held], start, criterion, self._revolutions)

    def describe(self, subject: int, criterion: str) -> None:
        """Replace the criterion of a settled state."""
        self.criterion[subject] = criterion
        self.timelines[subject].describe(criterion)
