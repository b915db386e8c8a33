# SPDX-License-Identifier: Apache-2.0
"""Motion states of one subject over time: consecutive periods, in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod

LARGEST_COUNT = 2000
"""Largest number of periods stored; later ones are counted only."""
NO_WHIRL = frozenset({MotionState.NOT_OBSERVABLE, MotionState.AT_REST, MotionState.FIXED_AXIS})


@dataclass
class _Period:
    start: float
    state: MotionState
    criterion: str
    revolutions: float  # at which it was entered [rev]
    described: bool = False  # with the criterion of the settled state
    duration: float = 0.0
    weighted_share: float = 0.0


class Timeline:
    """Periods of one state each; a period of zero length is removed."""

    def __init__(self) -> None:
        self._periods: list[_Period] = []
        self._full = False
        self.dropped = 0
        """Periods that were not stored."""

    def __len__(self) -> int:
        return len(self._periods)

    def start(self, state: MotionState, start: float, criterion: str, revolutions: float) -> None:
        """Start a period at `start` [s]; its state was entered at `revolutions` [rev]."""
        periods = self._periods
        if len(periods) >= LARGEST_COUNT:
            self.dropped += 1
            self._full = True
            return
        while len(periods) > 1 and start <= periods[-1].start:
            periods.pop()
        if periods and periods[-1].state is state:
            return
        if periods:
            start = max(start, periods[-1].start)
        periods.append(_Period(start, state, criterion, revolutions))

    def extend(self, share: float, elapsed: float) -> None:
        """Extend the present period by `elapsed` [rev], with this share of the estimates."""
        if self._periods and not self._full:
            last = self._periods[-1]
            last.duration += elapsed
            last.weighted_share += elapsed * share

    def needs_description(self, revolutions: float, after: float) -> bool:
        """Check whether the present period started `after` revolutions ago and has not been described since."""
        if not self._periods or self._full:
            return False
        last = self._periods[-1]
        return not last.described and revolutions - last.revolutions > after

    def describe(self, criterion: str) -> None:
        """Replace the criterion of the present period."""
        last = self._periods[-1]
        last.criterion, last.described = criterion, True

    def move_first_whirl(self, start: float) -> None:
        """Move the start of the first whirl to `start` [s], if that is earlier and after the period before."""
        for i, period in enumerate(self._periods):
            if period.state not in NO_WHIRL:
                if i and self._periods[i - 1].start < start < period.start:
                    period.start = start
                return

    @property
    def periods(self) -> tuple[MotionPeriod, ...]:
        """The periods so far, each with its mean confidence."""
        return tuple(
            MotionPeriod(
                period.start,
                period.state,
                period.criterion,
                period.weighted_share / period.duration if period.duration > 0.0 else 1.0,
            )
            for period in self._periods
        )
