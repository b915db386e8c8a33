# SPDX-License-Identifier: Apache-2.0
"""Hysteresis of the motion states: a state holds until the low-passed share of another leads clearly."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.motion.timeline import extend, needs_description, no_periods

STATES = tuple(MotionState)
INDEX = {state: i for i, state in enumerate(STATES)}
HIDDEN, AT_REST, FIXED_AXIS, SYNCHRONOUS, FORWARD, ROLLING, SECOND_BENDING, IRREGULAR, REVERSE, SPIRAL = range(
    len(STATES)
)

RISE = 0.1
"""A new state starts when its share last rose above this."""
SETTLED = 2.0
"""Duration after which the criterion of a state is described with its present numbers [rev]."""


KEPT, CHANGED, SETTLED_NOW = range(3)
"""Values of `StateHysteresis.event`: nothing, the state of a subject changes, its state has settled."""


class StateHysteresis(NamedTuple):
    """States of several subjects: the marks, then the string."""

    held: Integers  # (subjects,) present state
    estimate: Integers  # (subjects,) newest estimate
    start: Array  # (subjects,) start of the estimated state [s]; nan: when its share rose, less the delay
    share: Array  # (subjects, states) of the recent estimates
    since: Array  # (subjects, states) start of the state [s]
    event: Integers  # (subjects,)
    present: Array  # (subjects, 5) present periods, see `timeline`
    last: Array  # (3,) time [s] and revolutions of the last estimate, and the number of estimates

    @classmethod
    def of(cls, subjects: int) -> StateHysteresis:
        """Subjects at rest, before the first estimate."""
        share, since = np.zeros((2, subjects, len(STATES)))
        held = np.full(subjects, INDEX[MotionState.AT_REST], np.int64)
        return cls(
            held, held.copy(), np.zeros(subjects), share, since, np.zeros(subjects, np.int64), no_periods(subjects),
            np.zeros(3),
        )  # fmt: skip

    @property
    def states(self) -> tuple[MotionState, ...]:
        """Present state of each subject."""
        return tuple(STATES[state] for state in self.held.tolist())

    @property
    def confidence(self) -> Array:
        """Share of the recent estimates for the present state, 0 to 1, shape (subjects,)."""
        share: Array = self.share[np.arange(self.held.size), self.held]
        return share


@strict_kernel
def update_states(hysteresis: StateHysteresis, criteria: Criteria, lag: float, time: float, revolutions: float) -> bool:
    """Add an estimate of the state of each subject.

    Args:
        hysteresis: The states, with `estimate` and `start`.
        criteria: Thresholds.
        lag: Delay of the estimates [s].
        time: Time since the first sample [s].
        revolutions: Revolutions since the first sample [rev].

    Returns:
        Whether there is an `event`.
    """
    last, shares, held = hysteresis.last, hysteresis.share, hysteresis.held
    first = last[2] == 0.0
    last[2] += 1.0
    elapsed = max(revolutions - last[1], 4.0 * criteria.rest_rotation * (time - last[0]))
    last[0], last[1] = time, revolutions
    gain = 1.0 if first else 1.0 - math.exp(-elapsed / criteria.state_memory)
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
        if state != now and share[state] >= share[now] + criteria.state_lead:
            if not math.isnan(hysteresis.start[subject]):
                hysteresis.since[subject, state] = hysteresis.start[subject]
            held[subject] = state
            hysteresis.event[subject] = CHANGED
        elif first:
            hysteresis.event[subject] = CHANGED
        else:
            present = hysteresis.present[subject]
            extend(present, share[now], elapsed)
            if needs_description(present, revolutions, SETTLED):
                hysteresis.event[subject] = SETTLED_NOW
        any_event = any_event or hysteresis.event[subject] != KEPT
    return any_event


@strict_kernel
def is_whirl(state: int) -> bool:
    """Check that a state, by its index, is one of a string that whirls."""
    return state not in (HIDDEN, AT_REST, FIXED_AXIS)
