# SPDX-License-Identifier: Apache-2.0
"""Regimes of an operating map, from the findings of a run."""

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from drill_twin.whirl import MotionState, Summary, criteria
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.motion.states import NO_WHIRL
from drill_twin.whirl.motion.stick_slip_index import FULL, MODERATE

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
        return self.top != 0.0 and (self.severity >= FULL or abs(self.bit) < criteria.STANDSTILL * abs(self.top))

    @property
    def winds(self) -> bool:
        """Bit and top drive turn at different mean speeds."""
        return abs(self.bit - self.top) > BEHIND * abs(self.top)


class Regime(StrEnum):
    """Motion of the string at the end of a run; the codes in a map follow this order."""

    SMOOTH = "smooth"
    """No whirl, nothing that grows, and bit and top drive turn steadily."""
    VIBRATION = "torsional vibration"
    """No whirl; the speed of bit or top drive swings by a stick-slip index of `MODERATE` or more, and goes on to."""
    STICK_SLIP = "stick-slip"
    """No whirl; the bit comes to rest between its peaks, or stands."""
    BUCKLED = "buckled without whirl"
    """No whirl, vertical hole: the string is bent by more than `BUCKLED_RADIUS`, and spins about its bent shape."""
    SWING = "swinging in a plane"
    """No whirl: the string swings to and fro in a plane, and bit and top drive turn steadily."""
    UNSETTLED = "not settled"
    """No whirl at the end, but a motion that grows, or a whirl that began and ended: a longer run decides."""
    FORWARD = "forward whirl"
    """Regular whirl with the rotation, in any shape."""
    BACKWARD = "backward whirl"
    """Regular whirl against the rotation that neither creeps nor rolls, in any shape."""
    IRREGULAR = "irregular whirl"
    """Whirl without a steady rate or radius."""
    FAILED = "could not be followed"
    """The run did not come to its end."""
    CREEPING = "creeping along the wall"
    """Whirl on the wall whose contact slides: it goes around at less than half of the rotation, and of pure rolling."""
    ROLLING = "rolling along the wall"
    """Whirl against the rotation whose contact rolls."""
    IMPACTS = "striking the wall"
    """Whirl that leaves the wall and strikes it again and again."""

    @property
    def code(self) -> int:
        """Place in the order of the regimes."""
        return REGIMES.index(self)

    @property
    def whirls(self) -> bool:
        """The string whirls, otherwise than by creeping."""
        return self in set(_BY_STATE.values()) - {Regime.CREEPING}


REGIMES = tuple(Regime)
OFF_AXIS = {Regime.BUCKLED, Regime.CREEPING}
"""Regimes in which the string has left the axis, about which its linear growth is."""
_BY_STATE = {
    MotionState.SYNCHRONOUS_WHIRL: Regime.FORWARD,
    MotionState.FORWARD_WHIRL: Regime.FORWARD,
    MotionState.BACKWARD_WHIRL: Regime.BACKWARD,
    MotionState.CREEPING: Regime.CREEPING,
    MotionState.ROLLING: Regime.ROLLING,
    MotionState.IMPACTS: Regime.IMPACTS,
    MotionState.IRREGULAR: Regime.IRREGULAR,
}


def regime_of(
    summary: Summary, radius_shares: Iterable[float], torsion: TorsionalSpeeds, *, vertical: bool, grows: bool
) -> Regime:
    """Regime at the end of a run; of a shape of the string (spiral, second bending), the motion of its widest mark.

    Args:
        summary: Findings of the run.
        radius_shares: Largest radius of each mark over its clearance, late in the run.
        torsion: Speeds of bit and top drive late in the run.
        vertical: True for a vertical hole, in which a string off the axis is buckled.
        grows: True if a motion grows that would not be calm in the time asked.
    """
    state = summary.motion[-1].state if summary.motion else MotionState.AT_REST
    ratio = math.inf if summary.mean_ratio is None else summary.mean_ratio  # not known of a whirl of few revolutions
    stands = abs(ratio) < criteria.STANDING_RATIO and state not in {MotionState.IRREGULAR, MotionState.IMPACTS}
    if not (state in NO_WHIRL or state is MotionState.NOT_OBSERVABLE or stands):
        last = {mark: periods[-1].state for mark, periods in summary.mark_motion.items() if periods}
        named = (one for one in (state, last.get(summary.frequency_mark or ""), *last.values()) if one in _BY_STATE)
        return _BY_STATE[found] if (found := next(named, None)) else Regime.FORWARD if ratio > 0.0 else Regime.BACKWARD
    decays = summary.bit is BitMotion.DECAYING
    if summary.bit in {BitMotion.STICK_SLIP, BitMotion.STANDS} or (torsion.sticks and not decays):
        return Regime.STICK_SLIP
    if vertical and max(radius_shares, default=0.0) > BUCKLED_RADIUS:
        return Regime.BUCKLED
    if torsion.severity >= MODERATE and not decays:
        return Regime.VIBRATION
    if state is MotionState.PLANE_SWING:
        return Regime.SWING
    return Regime.UNSETTLED if grows else Regime.SMOOTH
