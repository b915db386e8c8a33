# SPDX-License-Identifier: Apache-2.0
"""Motion states of the whirl analysis, and the thresholds that separate them.

Thresholds that only one estimator needs stand in the file of the estimator.

The motion of the centre line at a mark, z = x + i y, has three parts, which differ by the frame in which they are
constant:

* the offset c is constant in the frame of the hole (a string that lies on one side);
* the synchronous part S exp(i spin) is constant in the frame that rotates with the string (bow, imbalance);
* the asynchronous part is the rest. It is whirl if it is constant in neither frame.

Radii are fractions of the clearance, times are revolutions of the rotation, so that one set of numbers serves a bench
rod and a full-size bottom-hole assembly. Messages that carry numbers (`/whirl/state`, `/twin/summary`) have the codes,
which are kept.
"""

import math
from enum import IntEnum, StrEnum
from typing import Self


class MotionState(StrEnum):
    """Motion of a mark or of the string: the seven states of the paper's Fig. 7, the swing, rest, and not observable.

    The first that applies holds, after the hysteresis of the thresholds below; each docstring is the criterion.
    """

    NOT_OBSERVABLE = "not observable"
    """The string rotates, but there are fewer than `FEWEST_SAMPLES` samples in a revolution, so that a whirl may appear
    as another (aliasing), or in an orbit fewer than `FEWEST_IN_ORBIT`, or the mark was not seen in most of the last
    revolution."""
    AT_REST = "at rest"
    """The rotation is slower than `REST_ROTATION`."""
    FIXED_AXIS = "rotation about a fixed axis"
    """No whirl: the asynchronous part is below `ONSET_RADIUS` or stands (`STANDING_RATIO`), and there is no synchronous
    onset. A bowed string that spins about its bent shape has this state, whether centred or lying on one side."""
    PLANE_SWING = "swinging in a plane"
    """No whirl: the mark moves to and fro in a plane or on the low side of an inclined hole, with an rms radius above
    `ONSET_RADIUS`; its lines at +f and -f are nearly equal, so that the rotary coefficient is below `ROTARY`
    (`onset.plane_swing`). A wider ellipse is a whirl in the sense of its stronger line."""
    SYNCHRONOUS_WHIRL = "synchronous whirl"
    """Forced, not self-excited: the part that turns with the string (1x, of unbalance or bow) has grown, by a
    synchronous onset, and there is no asynchronous whirl. Its phase to the string is steady, or turns by half a turn in
    a critical speed (API 684); the phase of a self-excited whirl drifts."""
    FORWARD_WHIRL = "forward whirl"
    """Regular, asynchronous whirl in the sense of rotation. In contact it can only slide, never
    roll: the criterion's text then says that it slides along the wall, and for what share of the time."""
    ROLLING = "rolling along the wall"
    """Regular whirl against the sense of rotation, in contact for more than `CONTACT_FRACTION` of the time, and the
    contact point slips by less than `ROLLING_SLIP` of the rim speed: the ratio is within that share of pure rolling,
    -r_o / clearance. Where r_o is unknown, any backward whirl in contact: it may creep."""
    SECOND_BENDING = "second bending"
    """Of the string only: whirl, with the marks in one rotating plane (planarity above `PLANAR`), on both sides of the
    axis with more than `LOBE` of the largest radius each."""
    IRREGULAR = "irregular"
    """Whirl without a steady rate or radius: most of the last revolutions had a coherence of the angle below
    `COHERENCE` or an unevenness of the radius above `UNEVENNESS`, and two lines leave `LEFT` of the power or more. Two
    whirls at once, which leave less, are named by the stronger."""
    BACKWARD_WHIRL = "backward whirl"
    """Regular whirl against the sense of rotation that neither rolls nor creeps: free of the wall for half of the time
    or more, or sliding along it faster than it would roll."""
    SPIRAL = "spiral"
    """Of the string only: whirl, with marks that do not lie in one plane (planarity below `PLANAR`): a helix."""
    CREEPING = "creeping along the wall"
    """Regular whirl against the sense of rotation, in contact, slower than rolling by more than `ROLLING_SLIP` of the
    rim speed: the contact point slips."""
    IMPACTS = "striking the wall"
    """Regular whirl of either sense that comes to the wall `STRIKES` times in a revolution or more, was nearer to the
    axis than `AWAY` before each, and is free of the wall for half of the time or more. Strikes that follow each other
    within an eighth of a revolution are not told apart, and irregular motion keeps its name."""


class BitMotion(StrEnum):
    """Motion of the bit."""

    UNKNOWN = "not observable"
    """No speed of the bit was given."""
    AT_REST = "at rest"
    """The top drive does not turn."""
    STARTING = "start-up"
    """Rotation begins: the index says nothing yet."""
    EARLY = "too early to tell"
    """At speed from the first sample on, and no index yet."""
    STANDS = "bit stands still"
    """The top drive turns and the bit does not."""
    STEADY = "steady rotation"
    """Index below 0.5."""
    VIBRATION = "torsional vibration"
    """Index from 0.5 to 1."""
    STICK_SLIP = "stick-slip"
    """Index of 1 or more: the swing reaches standstill."""
    DECAYING = "free swing that dies away"
    """The swing loses height from cycle to cycle: it was set off by a start or a jolt, and nothing feeds it."""


class MotionCode(IntEnum):
    """Code of each `MotionState`: from 4 on the string whirls."""

    (
        NOT_OBSERVABLE, AT_REST, FIXED_AXIS, PLANE_SWING, SYNCHRONOUS_WHIRL, FORWARD_WHIRL, BACKWARD_WHIRL, ROLLING,
        SECOND_BENDING, SPIRAL, IRREGULAR, CREEPING, IMPACTS,
    ) = range(13)  # fmt: skip

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

    UNKNOWN, AT_REST, STARTING, STEADY, VIBRATION, STICK_SLIP, STANDS, DECAYING, EARLY = range(9)

    @classmethod
    def of(cls, motion: BitMotion) -> Self:
        """Code of a motion of the bit."""
        return cls[motion.name]


ONSET_RADIUS = 0.05
"""Onset: smallest radius of the asynchronous part, as a fraction of the clearance. It defines the onset; the ground
truth of the evidence has the same number.

A threshold below that states no reason was chosen on the draws with seeds below 300 of `evidence/docs/detection.md`,
which judges the thresholds together, on other draws. No such threshold was measured by itself."""
RELEASE_RADIUS = 0.04
"""End of whirl: radius below this fraction of the clearance (hysteresis)."""
SUSTAIN = 1.0
"""Onset: duration for which the radius stays above its threshold [rev]; part of the definition, and of the rate of
false alarms (`onset.asynchronous_onset`)."""
LEAST_SWEPT_ANGLE = math.radians(30.0)
"""Onset: smallest angle swept by the asynchronous part since it crossed, in the frames of hole and string [rad]."""
SETTLING_ANGLE = math.radians(90.0)
"""Onset: smallest angle swept in the hole where it is inclined, or where the precession is slower than
`SETTLING_RATIO`. A string that settles, on the low side or where friction pushes it up the wall, sweeps less [rad].
"""
SETTLING_RATIO = 1.0 / 24.0
"""Onset: whirl ratio below which `SETTLING_ANGLE` is needed: the orbit sweeps less in `SWEEP_WINDOW`."""
SYNCHRONOUS_BAND = 0.3
"""Onset: distance of whirl ratio from 1 within which a motion may be synchronous while the
rotation changes: it must sweep `SYNCHRONOUS_ANGLE` in the frame of the string, and not die away."""
SYNCHRONOUS_ANGLE = math.radians(400.0)
"""The same: smallest angle swept in the string [rad]. The synchronous part, drawn in that frame, runs once round a
circle as the string passes a critical speed; so does the direction in which it changes."""
SPEED_CHANGE = 0.05
"""Onset: change of the rotation in 28 revolutions, over the rotation, from which it may pass a critical speed: what
dies away is then its free vibration, not whirl."""
DYING_SHARE = 0.85
"""Onset: mean radius over its largest in 28 revolutions below which it dies away. At 0.7 two of 13 whirls on seeds from
7,300,000 on are dated to the free vibration after the critical speed, which beats with what is left of the passage."""
STANDING_RATIO = 1.0 / 144.0
"""Rotation about a fixed axis: whirl ratio of a displaced string below this, 15 degrees in
`SWEEP_WINDOW`; the string stands, whatever the sign of the rest, if it moves as little as `STANDING_SHARE` says."""
STANDING_SHARE = 1.0 / 3.0
"""Rotation about a fixed axis: unevenness and lack of coherence of a string that stands, over the values from which
a motion is irregular. The mean precession of a string that jumps to and fro is about 0 too."""
FALLING_TIME = 2.0
"""Onset: duration from the first rotation during which a string in an inclined hole may fall to its low side
[rev]."""
ROTARY = 0.5
"""Smallest rotary coefficient of a whirl that moves along a line or stays on the low side, over `SIDE_WINDOW`; a swing
is below. The ellipse with this coefficient is 0.27 times as wide as long (`onset.plane_swing`)."""
SIDE_WINDOW = 12.0
"""Swing: duration over which it is judged [rev]."""
SWEEP_WINDOW = 6.0
"""Onset: duration within which that angle is swept; otherwise offset or bow have changed, and are estimated anew. A
whirl that has not swept it in this duration has ended [rev]."""
LONGEST_SWEEP_WINDOW = 28.0
"""Onset: a displaced string that sweeps the angle within this duration without coming back has whirled since it was
displaced [rev]. The history holds 32 revolutions, and the steady position needs four of them before the crossing."""
FALSE_ALARM_FACTOR = 4.5
"""Onset: smallest ratio of the threshold to the noise left after averaging: less than 1e-8 false alarms in a revolution
of a mark, by the derivation in `onset.asynchronous_onset`."""
SYNCHRONOUS_RADIUS = 0.25
"""Synchronous onset: smallest radius of the synchronous part, as a fraction of the clearance."""
SYNCHRONOUS_GROWTH = 2.0
"""Synchronous onset: smallest ratio of that radius to its smallest value so far."""
SYNCHRONOUS_SHARE = 0.8
"""Synchronous onset: smallest share of the synchronous part in the rms radius of the motion about the offset."""
SEPARATION_MEMORY = 6.0
"""Memory of offset and synchronous part [rev]: an orbit keeps 0.97 of its radius at a ratio of -0.1, and 0.994 at 0.5
(`orbit.runout_separation`)."""
SEPARATION_MEMORY_IN_WHIRL = 24.0
"""The same during whirl, so that a slow orbit does not leak into them [rev]."""
ORBIT_WINDOW = 2.0
"""Window of precession, coherence, contact and shape [rev]."""
REST_ROTATION = 0.05
"""At rest: the string is not rotated, slower than this [rev/s]; no rig drills below 0.3. Chosen, not measured."""
STANDSTILL = 0.05
"""Stands still: a bit or a section slower than this share of the mean speed, or of the top drive, while the string is
rotated. Chosen, not measured."""
FEWEST_SAMPLES = 4.0
"""Not observable: fewer samples in a revolution than this, which an orbit of up to twice the rotation, in either
sense, needs."""
FEWEST_IN_ORBIT = 2.4
"""Not observable: fewer samples in an orbit than this; at 2 neither its sense nor its pace can be known (Nyquist), and
noise asks for a margin, which was chosen."""
NEEDED_IN_ORBIT = 2.5
"""Not definite: fewer samples than this in an orbit at pure rolling, or at `DEFINITE_RATIO`."""
DEFINITE_RATIO = 6.0
"""Not definite: samples that cannot show an orbit of so many times the rotation; a faster one, of the other sense
too, would look like what is found."""
CONTACT_RADIUS = 0.95
"""Contact, where no wall force is given: radius about the hole's axis, as a fraction of the clearance."""
AWAY, STRUCK = 0.85, 0.1
"""Impacts: radius about the hole's axis, as a fraction of the clearance, within which the string has left the wall, and
least share of the samples of a bin in contact; chosen so that noise of 3 % of the clearance is no strike of an orbit
beside the wall (`test_noise_is_no_strike`). Within 0.8, 32 of 40 draws of `test/whirl/kinds.py` are named, here 38."""
STRIKES = 1.0
"""Impacts: least number of strikes in a revolution; chosen: fewer are single blows. No longer below half of it."""
CONTACT_FRACTION = 0.5
"""Along the wall: share of the time in contact."""
CONTACT_HYSTERESIS = 0.1
"""Along the wall no longer: share of the time below `CONTACT_FRACTION` by this."""
ROLLING_SLIP = 0.5
"""Rolling: slip of the contact point over the rim speed, |1 + ratio clearance / r_o|, below this; no longer when
0.1 above."""
COHERENCE = 0.85
"""Irregular: coherence of the angle with a steady rate below this."""
UNEVENNESS = 0.3
"""Irregular: rms deviation of the radius from its trend over its mean above this."""
LINES_WINDOW = 12.0
"""Irregular: window of the two lines [rev], at most since the whirl was detected: lines 1/12 of the rotation apart are
told from each other."""
LEFT = 0.1
"""Irregular: least share of the power that neither of the two strongest lines has; below, the motion is two whirls at
once or an ellipse. Chosen on `test/whirl/kinds.py` and one run of an elastic bounce, which at 0.2 loses its name."""
SETTLING_TIME = 1.0
"""Irregular: only this long after the whirl was detected, since growth is uneven too [rev]."""
IRREGULARITY_MEMORY = 4.0
"""Irregular: memory of the share of irregular time [rev]."""
IRREGULARITY_ON = 0.55
"""Irregular: share of irregular time above this. A change from one regular motion to another looks irregular for
two revolutions, which does not suffice."""
IRREGULARITY_OFF = 0.3
"""Regular again: share of irregular time below this."""
PLANAR = 0.7
"""Planarity |sum Z^2| / sum |Z|^2 of the marks: 1 is a plane, 0 a circle seen along the axis; a spiral below
this, a plane again 0.1 above."""
LOBE = 0.3
"""Second bending: smallest radius on each side of the axis over the largest; no longer when 0.1 below."""
STATE_MEMORY = 0.5
"""Memory of the shares of the states [rev]."""
STATE_LEAD = 0.2
"""A new state needs a share larger than the present state's share by this (hysteresis)."""
