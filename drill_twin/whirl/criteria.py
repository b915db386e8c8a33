# SPDX-License-Identifier: Apache-2.0
"""All criteria of the whirl analysis: the motion states and the thresholds that separate them.

The motion of the centre line at a mark, z = x + i y, has three parts, which differ by the frame in which they are
constant:

* the offset c is constant in the frame of the hole (a string that lies on one side);
* the synchronous part S exp(i spin) is constant in the frame that rotates with the string (bow, imbalance);
* the asynchronous part is the rest. It is whirl if it is constant in neither frame.

Radii are fractions of the clearance, times are revolutions of the rotation, so that one set of numbers serves a bench
rod and a full-size bottom-hole assembly. Messages that carry numbers (`/whirl/state`, `/twin/summary`) have the codes,
which are kept.
"""

from __future__ import annotations

import math
from enum import Enum, IntEnum
from typing import NamedTuple, Self


class MotionState(Enum):
    """Motion of a mark or of the string: the seven states of the paper's Fig. 7, the swing, rest, and not observable.

    The first that applies holds, after the hysteresis of `Criteria`; each docstring is the criterion.
    """

    NOT_OBSERVABLE = "not observable"
    """The string rotates, but there are fewer than `fewest_samples` samples in a revolution, so that a whirl may appear
    as another (aliasing), or in an orbit fewer than `fewest_in_orbit`, or the mark was not seen in most of the last
    revolution."""
    AT_REST = "at rest"
    """The rotation is slower than `rest_rotation`."""
    FIXED_AXIS = "rotation about a fixed axis"
    """No whirl: the asynchronous part is below `onset_radius` or stands (`standing_ratio`), and there is no synchronous
    onset. A bowed string that spins about its bent shape has this state, whether centred or lying on one side."""
    LOW_SIDE_SWING = "swinging on the low side"
    """In an inclined hole, no whirl: the mark moves to and fro on the low side, with an rms radius above
    `onset_radius` (`onset.low_side_swing`)."""
    SYNCHRONOUS_WHIRL = "synchronous whirl"
    """Forced, not self-excited: the part that turns with the string (1x, of unbalance or bow) has grown, by a
    synchronous onset, and there is no asynchronous whirl. Its phase to the string is steady, or turns by half a turn in
    a critical speed (API 684); that of a self-excited whirl drifts."""
    FORWARD_WHIRL = "forward whirl"
    """Regular, asynchronous whirl in the sense of rotation. In contact it can only slide, never
    roll: the criterion's text then says that it slides along the wall, and for what share of the time."""
    ROLLING = "rolling along the wall"
    """Regular whirl against the sense of rotation, in contact for more than `contact_fraction` of the time, and the
    contact point slips by less than `rolling_slip` of the rim speed: the ratio is within that share of pure rolling,
    -r_o / clearance. Where r_o is unknown, any backward whirl in contact."""
    SECOND_BENDING = "second bending"
    """Of the string only: whirl, with the marks in one rotating plane (planarity above `planar`), on both sides of the
    axis with more than `lobe` of the largest radius each."""
    IRREGULAR = "irregular"
    """Whirl without a steady rate or radius: most of the last revolutions had a coherence of the angle below
    `coherence` or an unevenness of the radius above `unevenness`."""
    BACKWARD_WHIRL = "backward whirl"
    """Regular whirl against the sense of rotation that does not roll: free of the wall, or sliding along it."""
    SPIRAL = "spiral"
    """Of the string only: whirl, with marks that do not lie in one plane (planarity below `planar`): a helix."""


class BitMotion(Enum):
    """Motion of the bit."""

    UNKNOWN = "not observable"
    """No speed of the bit was given."""
    AT_REST = "at rest"
    """The top drive does not turn."""
    STARTING = "start-up"
    """Rotation begins: the index says nothing yet."""
    STANDS = "bit stands still"
    """The top drive turns and the bit does not."""
    STEADY = "steady rotation"
    """Index below 0.5."""
    VIBRATION = "torsional vibration"
    """Index from 0.5 to 1."""
    STICK_SLIP = "stick-slip"
    """Index of 1 or more: the swing reaches standstill."""


class Criteria(NamedTuple):
    """Thresholds of the analysis. The defaults are the documented ones; tests and figures use no others."""

    onset_radius: float = 0.05
    """Onset: smallest radius of the asynchronous part, as a fraction of the clearance."""
    release_radius: float = 0.04
    """End of whirl: radius below this fraction of the clearance (hysteresis)."""
    sustain: float = 1.0
    """Onset: duration for which the radius stays above its threshold [rev]."""
    least_swept_angle: float = math.radians(30.0)
    """Onset: smallest angle swept by the asynchronous part since it crossed, in the frames of hole and string [rad]."""
    settling_angle: float = math.radians(90.0)
    """Onset: smallest angle swept in the hole where it is inclined, or where the precession is slower than
    `settling_ratio`. A string that settles, on the low side or where friction pushes it up the wall, sweeps less [rad].
    """
    settling_ratio: float = 1.0 / 24.0
    """Onset: whirl ratio below which `settling_angle` is needed."""
    synchronous_band: float = 0.3
    """Onset: distance of whirl ratio from 1 within which a motion may be synchronous while the
    rotation changes: it must sweep `synchronous_angle` in the frame of the string, and not die away."""
    synchronous_angle: float = math.radians(400.0)
    """The same: smallest angle swept in the string [rad]. The synchronous part, drawn in that frame, runs once round a
    circle as the string passes a critical speed; so does the direction in which it changes."""
    speed_change: float = 0.05
    """Onset: change of the rotation in 16 revolutions, over the rotation, from which it may pass a critical speed: what
    dies away is then its free vibration, not whirl."""
    dying_share: float = 0.7
    """Onset: radius over its largest since the crossing below which it dies away."""
    standing_ratio: float = 1.0 / 144.0
    """Rotation about a fixed axis: whirl ratio of a displaced string below this, 15 degrees in
    `sweep_window`; the string stands, whatever the sign of the rest, if it moves as little as `standing_share` says."""
    standing_share: float = 1.0 / 3.0
    """Rotation about a fixed axis: unevenness and lack of coherence of a string that stands, over those from which a
    motion is irregular. The mean precession of a string that jumps to and fro is about 0 too."""
    falling_time: float = 2.0
    """Onset: duration from the first rotation during which a string in an inclined hole may fall to its low side
    [rev]."""
    rotary: float = 0.5
    """Low side: smallest rotary coefficient of a whirl that stays there, over `side_window`; a swing is below."""
    side_window: float = 12.0
    """Low side: duration for which a swing stays there [rev]."""
    sweep_window: float = 6.0
    """Onset: duration within which that angle is swept; otherwise offset or bow have changed, and are estimated anew. A
    whirl that has not swept it in this duration has ended [rev]."""
    longest_sweep_window: float = 28.0
    """Onset: a displaced string that sweeps the angle within this duration without coming back has whirled since it was
    displaced [rev]."""
    false_alarm_factor: float = 4.5
    """Onset: smallest ratio of the threshold to the noise left after averaging (see `onset.detector`)."""
    synchronous_radius: float = 0.25
    """Synchronous onset: smallest radius of the synchronous part, as a fraction of the clearance."""
    synchronous_growth: float = 2.0
    """Synchronous onset: smallest ratio of that radius to its smallest value so far."""
    synchronous_share: float = 0.8
    """Synchronous onset: smallest share of the synchronous part in the rms radius of the motion about the offset."""
    synchronous_over_swing: float = 2.0
    """Synchronous onset on the low side: smallest ratio of that radius to the rms radius of a swing,
    which looks synchronous where the rotation is as slow, as in stick-slip."""
    separation_memory: float = 6.0
    """Memory of offset and synchronous part [rev]."""
    separation_memory_in_whirl: float = 24.0
    """The same during whirl, so that a slow orbit does not leak into them [rev]."""
    orbit_window: float = 2.0
    """Window of precession, coherence, contact and shape [rev]."""
    rest_rotation: float = 0.05
    """Rotation below which the string is at rest [rev/s]."""
    fewest_samples: float = 4.0
    """Not observable: fewer samples in a revolution than this, which an orbit of up to twice the rotation, in either
    sense, needs."""
    fewest_in_orbit: float = 2.4
    """Not observable: fewer samples in an orbit than this; at 2 neither its sense nor its pace can be known."""
    needed_in_orbit: float = 2.5
    """Not definite: fewer samples than this in an orbit at pure rolling, or at `definite_ratio`."""
    definite_ratio: float = 6.0
    """Not definite: samples that cannot show an orbit of so many times the rotation; a faster one, of the other sense
    too, would look like what is found."""
    contact_radius: float = 0.95
    """Contact, where no wall force is given: radius about the hole's axis, as a fraction of the clearance."""
    contact_fraction: float = 0.5
    """Along the wall: share of the time in contact."""
    contact_hysteresis: float = 0.1
    """Along the wall no longer: share of the time below `contact_fraction` by this."""
    rolling_slip: float = 0.5
    """Rolling: slip of the contact point over the rim speed, |1 + ratio clearance / r_o|, below this; no longer when
    0.1 above."""
    coherence: float = 0.85
    """Irregular: coherence of the angle with a steady rate below this."""
    unevenness: float = 0.3
    """Irregular: rms deviation of the radius from its trend over its mean above this."""
    settling_time: float = 1.0
    """Irregular: only this long after the whirl was detected, since growth is uneven too [rev]."""
    irregularity_memory: float = 4.0
    """Irregular: memory of the share of irregular time [rev]."""
    irregularity_on: float = 0.55
    """Irregular: share of irregular time above this. A change from one regular motion to another looks irregular for
    two revolutions, which does not suffice."""
    irregularity_off: float = 0.3
    """Regular again: share of irregular time below this."""
    planar: float = 0.7
    """Planarity |sum Z^2| / sum |Z|^2 of the marks: 1 is a plane, 0 a circle seen along the axis; a spiral below
    this, a plane again 0.1 above."""
    lobe: float = 0.3
    """Second bending: smallest radius on each side of the axis over the largest; no longer when 0.1 below."""
    state_memory: float = 0.5
    """Memory of the shares of the states [rev]."""
    state_lead: float = 0.2
    """A new state needs a share larger than that of the present state by this (hysteresis)."""


class MotionCode(IntEnum):
    """Code of each `MotionState`: from 4 on the string whirls."""

    NOT_OBSERVABLE = 0
    AT_REST = 1
    FIXED_AXIS = 2
    LOW_SIDE_SWING = 3
    SYNCHRONOUS_WHIRL = 4
    FORWARD_WHIRL = 5
    BACKWARD_WHIRL = 6
    ROLLING = 7
    SECOND_BENDING = 8
    SPIRAL = 9
    IRREGULAR = 10

    @classmethod
    def of(cls, state: MotionState) -> Self:
        """Code of a motion state."""
        return cls[state.name]

    @property
    def state(self) -> MotionState:
        """Motion state of the code; its value is the name in words."""
        return MotionState[self.name]

    @property
    def whirls(self) -> bool:
        """True for a whirl."""
        return self >= MotionCode.SYNCHRONOUS_WHIRL


class StickSlipCode(IntEnum):
    """Code of each `BitMotion`, by its severity."""

    UNKNOWN = 0
    AT_REST = 1
    STARTING = 2
    STEADY = 3
    VIBRATION = 4
    STICK_SLIP = 5
    STANDS = 6

    @classmethod
    def of(cls, motion: BitMotion) -> Self:
        """Code of a motion of the bit."""
        return cls[motion.name]
