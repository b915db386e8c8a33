# SPDX-License-Identifier: Apache-2.0
"""Motion states of one subject over time: consecutive periods, in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod

LARGEST_COUNT = 2000
"""Largest number of periods stored; later ones are counted only."""
NO_WHIRL = frozenset({MotionState.NOT_OBSERVABLE, MotionState.AT_REST, MotionState.FIXED_AXIS})

OPEN, DURATION, WEIGHTED_SHARE, ENTERED, DESCRIBED = range(5)
"""Columns of the present periods: 1 where there is one; its duration and the integral of its share [rev]; revolutions
at which it was entered [rev]; 1 after its criterion was that of the settled state."""


def no_periods(subjects: int) -> Array:
    """Present periods of several subjects, before the first, shape (subjects, 5)."""
    return np.zeros((subjects, 5))


@strict_kernel
def extend(present: Array, share: float, elapsed: float) -> None:
    """Extend a present period, shape (5,), by `elapsed` [rev], with this share of the estimates."""
    if present[OPEN]:
        present[DURATION] += elapsed
        present[WEIGHTED_SHARE] += elapsed * share


@strict_kernel
def needs_description(present: Array, revolutions: float, after: float) -> bool:
    """Check whether a present period started `after` revolutions ago and has not been described since."""
    return bool(present[OPEN] and not present[DESCRIBED] and revolutions - present[ENTERED] > after)


@dataclass
class _Period:
    start: float
    state: MotionState
    criterion: str
    numbers: Array  # as its row of the present periods


class Timeline:
    """Periods of one state each; a period of zero length is removed."""

    def __init__(self, present: Array) -> None:
        """Begin without a period; `present`, shape (5,), has the numbers of the last one."""
        self._present = present
        self._periods: list[_Period] = []
        self.dropped = 0
        """Periods that were not stored."""

    def start(self, state: MotionState, start: float, criterion: str, revolutions: float) -> None:
        """Start a period at `start` [s]; its state was entered at `revolutions` [rev]."""
        periods = self._periods
        self._store()
        if len(periods) >= LARGEST_COUNT:
            self.dropped += 1
            self._present[OPEN] = 0.0
            return
        while len(periods) > 1 and start <= periods[-1].start:
            periods.pop()
        if not periods or periods[-1].state is not state:
            if periods:
                start = max(start, periods[-1].start)
            periods.append(_Period(start, state, criterion, np.array([1.0, 0.0, 0.0, revolutions, 0.0])))
        self._present[:] = periods[-1].numbers

    def describe(self, criterion: str) -> None:
        """Replace the criterion of the present period."""
        self._periods[-1].criterion, self._present[DESCRIBED] = criterion, 1.0

    def _store(self) -> None:
        """Keep the numbers of the present period."""
        if self._present[OPEN]:
            self._periods[-1].numbers[:] = self._present

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
        self._store()
        return tuple(
            MotionPeriod(
                period.start,
                period.state,
                period.criterion,
                float(period.numbers[WEIGHTED_SHARE] / period.numbers[DURATION])
                if period.numbers[DURATION] > 0.0
                else 1.0,
            )
            for period in self._periods
        )
