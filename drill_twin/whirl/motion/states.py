# SPDX-License-Identifier: Apache-2.0
"""Motion states of subjects over time: hysteresis of their estimates, consecutive periods, and what lasts.

A state holds until the low-passed share of another leads clearly.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod

LARGEST_COUNT = 2000
"""Largest number of periods stored; later ones are counted only."""
NO_WHIRL = frozenset({MotionState.NOT_OBSERVABLE, MotionState.AT_REST, MotionState.FIXED_AXIS, MotionState.PLANE_SWING})


class Timeline:
    """Periods of one state each; a period of zero length is removed."""

    def __init__(self) -> None:
        self._periods: list[MotionPeriod] = []
        self.dropped = 0
        """Periods that were not stored."""

    def start(self, state: MotionState, start: float, criterion: str) -> None:
        """Start a period at `start` [s]."""
        periods = self._periods
        if len(periods) >= LARGEST_COUNT:
            self.dropped += 1
            return
        while len(periods) > 1 and start <= periods[-1].start_s:
            periods.pop()
        if not periods or periods[-1].state is not state:
            periods.append(MotionPeriod(max(start, periods[-1].start_s) if periods else start, state, criterion))

    def describe(self, criterion: str) -> None:
        """Replace the criterion of the present period."""
        if not self.dropped:
            self._periods[-1] = replace(self._periods[-1], criterion=criterion)

    def move_first_whirl(self, start: float) -> None:
        """Move the start of the first whirl to `start` [s], if that is earlier and after the period before."""
        periods = self._periods
        first = next((i for i, period in enumerate(periods) if period.state not in NO_WHIRL), 0)
        if first and periods[first - 1].start_s < start < periods[first].start_s:
            periods[first] = replace(periods[first], start_s=start)

    @property
    def periods(self) -> tuple[MotionPeriod, ...]:
        """The periods so far."""
        return tuple(self._periods)


def lasting_motion(periods: Sequence[MotionPeriod], begin: float, end: float) -> MotionState | None:
    """State that holds for the largest share of the second half of a time [s]; None without periods."""
    begin = 0.5 * (begin + end)
    share: dict[MotionState, float] = {}
    for period, stop in zip(periods, [*(after.start_s for after in periods[1:]), end], strict=False):
        share[period.state] = share.get(period.state, 0.0) + max(0.0, stop - max(period.start_s, begin))
    return max(share, key=lambda state: share[state], default=None)


def whirl_end(periods: Sequence[MotionPeriod]) -> float | None:
    """Time since which the string has not whirled any more [s]; None where it whirls at the end, or never did."""
    end = None
    for period, after in pairwise(periods):
        if period.state not in NO_WHIRL and after.state in NO_WHIRL:
            end = after.start_s
    return end if periods and periods[-1].state in NO_WHIRL else None


STATES = tuple(MotionState)
(
    HIDDEN, AT_REST, FIXED_AXIS, SWING, SYNCHRONOUS, FORWARD, ROLLING, SECOND_BENDING, IRREGULAR, REVERSE, SPIRAL,
    CREEPING, IMPACTS,
) = range(len(STATES))  # fmt: skip

RISE = 0.1
"""A new state starts when its share last rose above this."""
SETTLED = 2.0
"""Duration after which the criterion of a state is described with its present numbers [rev]."""


KEPT, CHANGED, SETTLED_NOW = range(3)
"""Events of a subject: nothing, the state of a subject changes, its state has settled."""


def new_hysteresis(subjects: int) -> Columns:
    """States of several subjects, the marks, then the string: at rest, before the first estimate."""
    share, since = np.zeros((2, subjects, len(STATES)))
    return columns(
        "StateHysteresis",
        subjects,
        held=AT_REST,  # present state
        estimate=AT_REST,  # newest estimate
        start=0.0,  # of the estimated state [s]; nan: when its share rose, less the delay
        share=share,  # (subjects, states) of the recent estimates
        since=since,  # (subjects, states) start of the state [s]
        event=KEPT,
        entered=math.inf,  # revolutions at which the state was entered [rev]; inf once its criterion is described
        last_time=np.zeros(1),  # of the last estimate [s]
        last_revolutions=np.zeros(1),  # of the last estimate [rev]
        begun=np.zeros(1, bool),  # True after the first estimate
    )


@strict_kernel
def update_states(hysteresis: Columns, lag: float, time: float, revolutions: float) -> bool:
    """Add an estimate of the state of each subject.

    Args:
        hysteresis: The states, with `estimate` and `start`.
        lag: Delay of the estimates [s].
        time: Time since the first sample [s].
        revolutions: Revolutions since the first sample [rev].

    Returns:
        Whether there is an `event`.
    """
    shares, held, first = hysteresis.share, hysteresis.held, not hysteresis.begun[0]
    seconds = time - hysteresis.last_time[0]
    elapsed = max(revolutions - hysteresis.last_revolutions[0], 4.0 * criteria.REST_ROTATION * seconds)
    hysteresis.begun[0], hysteresis.last_time[0], hysteresis.last_revolutions[0] = True, time, revolutions
    gain = 1.0 if first else 1.0 - math.exp(-elapsed / criteria.STATE_MEMORY)
    any_event = False
    for subject in range(held.size):
        share, state, now = shares[subject], hysteresis.estimate[subject], held[subject]
        before = share[state]
        for k in range(share.size):
            share[k] *= 1.0 - gain
        share[state] += gain
        if before < RISE <= share[state]:
            delay = lag if is_whirl(now) else 0.0
            hysteresis.since[subject, state] = 0.0 if first else time - delay
        hysteresis.event[subject] = KEPT
        if state != now and share[state] >= share[now] + criteria.STATE_LEAD:
            if not math.isnan(hysteresis.start[subject]):
                hysteresis.since[subject, state] = hysteresis.start[subject]
            held[subject] = state
            hysteresis.event[subject] = CHANGED
        elif first:
            hysteresis.event[subject] = CHANGED
        elif revolutions - hysteresis.entered[subject] > SETTLED:
            hysteresis.event[subject], hysteresis.entered[subject] = SETTLED_NOW, math.inf
        if hysteresis.event[subject] == CHANGED:
            hysteresis.entered[subject] = revolutions
        any_event = any_event or hysteresis.event[subject] != KEPT
    return bool(any_event)


@strict_kernel
def is_whirl(state: int) -> bool:
    """Check that a state, by its index, is the state of a string that whirls."""
    return state not in (HIDDEN, AT_REST, FIXED_AXIS, SWING)
