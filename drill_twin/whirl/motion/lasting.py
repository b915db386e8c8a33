# SPDX-License-Identifier: Apache-2.0
"""Motion that lasts, apart from transients: the basis of the headlines of a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import MotionPeriod
from drill_twin.whirl.motion.timeline import NO_WHIRL


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
