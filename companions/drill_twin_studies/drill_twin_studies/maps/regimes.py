# SPDX-License-Identifier: Apache-2.0
"""Regimes of an operating map, from the findings of a run."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from drill_twin.whirl import MotionState, Summary, criteria
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.motion.states import NO_WHIRL
from drill_twin.whirl.motion.stick_slip_index import FULL, MODERATE, STUCK

BUCKLED_RADIUS = 0.25
"""Least radius of a mark, over its clearance, of a string that is buckled and does not whirl; not measured."""

BEHIND = 0.05
"""Difference of the mean speeds of bit and top drive, over the top drive's speed, from which the string still winds up;
not measured."""


class TorsionalSpeeds(NamedTuple):
    """Speeds of bit and top drive over the last time base of the stick-slip index."""

    severity: float
    """Larger stick-slip index of the two."""
    bit: float
    top: float
    """Mean speeds [rad/s]."""

    @property
    def sticks(self) -> bool:
        """The bit comes to rest between its peaks, or stands while the top drive turns."""
        return self.top != 0.0 and (self.severity >= FULL or abs(self.bit) < STUCK * abs(self.top))

    @property
    def winds(self) -> bool:
        """Bit and top drive turn at different mean speeds."""
        return abs(self.bit - self.top) > BEHIND * abs(self.top)


class Regime(Enum):
    """Motion of the string at the end of a run; the codes in a map follow this order."""

    SMOOTH = "smooth"
    """No whirl, nothing that grows, and bit and top drive turn steadily."""
    VIBRATION = "torsional vibration"
    """No whirl; the speed of bit or top drive swings by a stick-slip index of `MODERATE` or more."""
    STICK_SLIP = "stick-slip"
    """No whirl; the bit comes to rest between its peaks, or stands."""
    BUCKLED = "buckled without whirl"
    """No whirl, vertical hole: the string is bent by more than `BUCKLED_RADIUS`, and spins about its bent shape."""
    SWING = "swinging in a plane"
    """No whirl, inclined hole: the string swings across its low side, and bit and top drive turn steadily."""
    UNSETTLED = "not settled"
    """No whirl at the end, but a motion that grows, or a whirl that began and ended: a longer run decides."""
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
        return REGIMES.index(self)

    @property
    def whirls(self) -> bool:
        """The string whirls."""
        return self in {Regime.FORWARD, Regime.BACKWARD, Regime.IRREGULAR}


REGIMES = tuple(Regime)
_BY_STATE = {
    MotionState.SYNCHRONOUS_WHIRL: Regime.FORWARD,
    MotionState.FORWARD_WHIRL: Regime.FORWARD,
    MotionState.BACKWARD_WHIRL: Regime.BACKWARD,
    MotionState.ROLLING: Regime.BACKWARD,
    MotionState.CREEPING: Regime.BACKWARD,
    MotionState.IRREGULAR: Regime.IRREGULAR,
}


def regime_of(
    summary: Summary, radius_shares: Iterable[float], torsion: TorsionalSpeeds, *, vertical: bool, grows: bool
) -> Regime:
    """Regime at the end of a run.

    Args:
        summary: Findings of the run.
        radius_shares: Largest radius of each mark over its clearance, late in the run.
        torsion: Speeds of bit and top drive late in the run.
        vertical: True for a vertical hole, in which a string off the axis is buckled.
        grows: True if a motion grows that would not be calm in the time asked.
    """
    state = summary.motion[-1].state if summary.motion else MotionState.AT_REST
    ratio = summary.mode_ratio or 0.0
    stands = abs(ratio) < criteria.STANDING_RATIO and state is not MotionState.IRREGULAR
    if not (state in NO_WHIRL or state is MotionState.NOT_OBSERVABLE or stands):
        return _BY_STATE.get(state, Regime.FORWARD if ratio > 0.0 else Regime.BACKWARD)
    if summary.bit in {BitMotion.STICK_SLIP, BitMotion.STANDS} or torsion.sticks:
        return Regime.STICK_SLIP
    if vertical and max(radius_shares, default=0.0) > BUCKLED_RADIUS:
        return Regime.BUCKLED
    if torsion.severity >= MODERATE:
        return Regime.VIBRATION
    if state is MotionState.PLANE_SWING:
        return Regime.SWING
    return Regime.UNSETTLED if grows else Regime.SMOOTH
