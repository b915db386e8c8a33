# SPDX-License-Identifier: Apache-2.0
"""The motion states of one subject over time: periods that follow each other, in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod

LONGEST = 2000
"""Periods remembered; later ones are counted but not kept."""
NO_WHIRL = frozenset({MotionState.UNSEEN, MotionState.AT_REST, MotionState.FIXED_AXIS})


@dataclass
class _Period:
    start: float
    state: MotionState
    criterion: str
    told: bool  # whether the words are those of the settled motion
    travel: float  # when it was entered [rev]
    weight: float = 0.0
    weighed: float = 0.0


class Timeline:
    """Periods of one state each; a period that turns out to have no length is left out."""

    def __init__(self) -> None:
        self._periods: list[_Period] = []
        self._full = False
        self.dropped = 0
        """Periods that came after the longest timeline kept."""

    def __len__(self) -> int:
        return len(self._periods)

    def begin(self, state: MotionState, start: float, criterion: str, travel: float) -> None:
        """A state holds since `start` [s]; it was entered at `travel` [rev]."""
        periods = self._periods
        if len(periods) >= LONGEST:
            self.dropped += 1
            self._full = True
            return
        while len(periods) > 1 and start <= periods[-1].start:
            periods.pop()
        if periods and periods[-1].state is state:
            return
        if periods:
            start = max(start, periods[-1].start)
        periods.append(_Period(start, state, criterion, told=False, travel=travel))

    def hold(self, share: float, passed: float) -> None:
        """The state has held for a while, with this share of the votes."""
        if self._periods and not self._full:
            last = self._periods[-1]
            last.weight += passed
            last.weighed += passed * share

    def untold(self, travel: float, after: float) -> bool:
        """Whether the present state was entered `after` revolutions ago and has not been described since."""
        if not self._periods or self._full:
            return False
        last = self._periods[-1]
        return not last.told and travel - last.travel > after

    def tell(self, criterion: str) -> None:
        """Describes the present state anew, now that it has settled."""
        last = self._periods[-1]
        last.criterion, last.told = criterion, True

    def redate(self, start: float) -> None:
        """Moves the first whirl back to `start` [s], where that is earlier and after the state before."""
        for i, period in enumerate(self._periods):
            if period.state not in NO_WHIRL:
                if i and self._periods[i - 1].start < start < period.start:
                    period.start = start
                return

    @property
    def periods(self) -> tuple[MotionPeriod, ...]:
        """The periods so far, each with the mean of its confidence."""
        return tuple(
            MotionPeriod(
                period.start,
                period.state,
                period.criterion,
                period.weighed / period.weight if period.weight > 0.0 else 1.0,
            )
            for period in self._periods
        )
