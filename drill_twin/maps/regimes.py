# SPDX-License-Identifier: Apache-2.0
"""Regimes of an operating map, from the findings of a run."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from drill_twin.whirl import MotionState, Summary
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.motion.stick_slip import BitMotion
from drill_twin.whirl.motion.timeline import NO_WHIRL

BUCKLED_RADIUS = 0.25
"""Least radius of a mark, over its clearance, of a string that is buckled and does not whirl."""


class Regime(Enum):
    """Motion of the string at the end of a run; the order is that of the codes in a map."""

    SMOOTH = "smooth"
    """No whirl, and the bit turns steadily or in small torsional vibration."""
    STICK_SLIP = "stick-slip"
    """No whirl, and the bit sticks and slips."""
    BUCKLED = "buckled without whirl"
    """No whirl, vertical hole: the string is bent by more than `BUCKLED_RADIUS`, and spins about its bent shape."""
    FORWARD = "forward whirl"
    """Regular whirl with the rotation, in any shape."""
    BACKWARD = "backward whirl or rolling"
    """Regular whirl against the rotation, in any shape."""
    IRREGULAR = "irregular whirl"
    """Whirl without a steady rate or radius."""
    FAILED = "could not be followed"
    """The run did not come to its end."""

    @property
    def code(self) -> int:
        """Place in the order of the regimes."""
        return _CODES[self]

    @property
    def whirls(self) -> bool:
        """The string whirls; a run that could not be followed counts as one, for it is nothing to choose."""
        return self in {Regime.FORWARD, Regime.BACKWARD, Regime.IRREGULAR, Regime.FAILED}


REGIMES = tuple(Regime)
_CODES = {regime: code for code, regime in enumerate(REGIMES)}
_BY_STATE = {
    MotionState.FORWARD_WHIRL: Regime.FORWARD,
    MotionState.REVERSE_WHIRL: Regime.BACKWARD,
    MotionState.ROLLING: Regime.BACKWARD,
    MotionState.IRREGULAR: Regime.IRREGULAR,
}


def regime_of(summary: Summary, radius_shares: Iterable[float], *, vertical: bool) -> Regime:
    """Regime at the end of a run.

    Args:
        summary: Its findings.
        radius_shares: Largest radius of each mark over its clearance, late in the run.
        vertical: Whether the hole is vertical, so that a string off the axis is a buckled one.
    """
    state = summary.motion[-1].state if summary.motion else MotionState.AT_REST
    ratio = summary.mode_ratio or 0.0
    stands = abs(ratio) < Criteria().standing_ratio and state is not MotionState.IRREGULAR
    if state in NO_WHIRL or state is MotionState.NOT_OBSERVABLE or stands:
        if summary.bit is BitMotion.STICK_SLIP:
            return Regime.STICK_SLIP
        return Regime.BUCKLED if vertical and max(radius_shares, default=0.0) > BUCKLED_RADIUS else Regime.SMOOTH
    return _BY_STATE.get(state, Regime.FORWARD if ratio > 0.0 else Regime.BACKWARD)
