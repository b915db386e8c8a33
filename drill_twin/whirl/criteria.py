# SPDX-License-Identifier: Apache-2.0
"""Every criterion of the whirl analysis in one place: the motion states and the numbers that tell them apart.

With z = x + i y of the centre line at a mark, three parts are told apart by what they stand still in:

* the offset c stands still in the hole (a string that lies on one side);
* the synchronous part S exp(i spin) stands still in the string (bow, imbalance);
* the asynchronous part is the rest. It is whirl when it neither stands still in the hole nor in the string.

Radii are given as fractions of the clearance, times as revolutions of the rotation, so that one set of numbers serves
a bench rod and a full-size bottom-hole assembly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class MotionState(Enum):
    """Motion of a mark or of the string: the seven states of the paper's Fig. 7, rest, and what cannot be seen.

    The first that applies holds, after the hysteresis of `Criteria`; the criterion is its docstring.
    """

    UNSEEN = "not observable"
    """The string turns, but with fewer than `fewest_samples` samples in a revolution a whirl may show itself as another
    (aliasing), or the mark was not seen in most of the last revolution."""
    AT_REST = "at rest"
    """The rotation is slower than `rest_rotation`."""
    FIXED_AXIS = "rotation about a fixed axis"
    """No whirl: the asynchronous part is below `onset_radius` or stands still, and the synchronous part has not
    surged. A bowed string that spins about its bent shape is here, whether centred or lying on one side."""
    FORWARD_WHIRL = "forward whirl"
    """Whirl in the sense of rotation, regular; a synchronous surge (ratio 1) is a forward whirl too. In contact it can
    only slide, never roll: the criterion's text then says that it slides along the wall, and for how much of the
    time."""
    ROLLING = "rolling along the wall"
    """Whirl against the sense of rotation, regular, in contact for more than `contact_fraction` of the time, and the
    contact point slips by less than `rolling_slip` of the rim speed: the ratio is within that share of pure rolling,
    -r_o / clearance. Where r_o is unknown, any backward whirl in contact."""
    SECOND_BENDING = "second bending"
    """Of the string only: whirl, and the marks lie in one turning plane (planarity above `planar`), on both sides of
    the axis with more than `lobe` of the largest radius each."""
    IRREGULAR = "irregular"
    """Whirl without a steady pace or radius: most of the last revolutions were rough, with a coherence of the angle
    below `coherence` or an unevenness of the radius above `unevenness`."""
    REVERSE_WHIRL = "reverse whirl"
    """Whirl against the sense of rotation, regular, that does not roll: free of the wall, or sliding along it."""
    SPIRAL = "spiral"
    """Of the string only: whirl, and the marks do not lie in one plane (planarity below `planar`): a helix."""


@dataclass(frozen=True)
class Criteria:
    """Thresholds of the analysis. The defaults are the documented ones; tests and figures use no others."""

    onset_radius: float = 0.05
    """Onset: least radius of the asynchronous part, as a fraction of the clearance."""
    release_radius: float = 0.04
    """Whirl ends: radius below this fraction of the clearance (hysteresis)."""
    sustain: float = 1.0
    """Onset: for how long the radius stays above its threshold [rev]."""
    least_turn: float = math.radians(30.0)
    """Onset: least turn of the asynchronous part since it crossed, seen from the hole and from the string [rad]."""
    patience: float = 6.0
    """Onset: revolutions it has for that turn; else it leans over or has a new bow, which is learned anew. A whirl
    that has not turned as much in as many revolutions is over [rev]."""
    longest_patience: float = 28.0
    """Onset: a string thrown out that begins to turn within this, while it stays out, has whirled since then [rev]."""
    false_alarm_factor: float = 4.5
    """Onset: the threshold is at least this times the noise left after averaging (see `onset`)."""
    surge_radius: float = 0.25
    """Synchronous onset: least radius of the synchronous part, as a fraction of the clearance."""
    surge_growth: float = 2.0
    """Synchronous onset: least radius over the steady level before it."""
    surge_purity: float = 0.8
    """Synchronous onset: least share of the moving centre line's rms radius that is synchronous."""
    baseline_window: float = 6.0
    """Memory of the offset and the synchronous part [rev]."""
    whirl_memory: float = 24.0
    """The same during whirl, when a slow orbit must not leak into them [rev]."""
    orbit_window: float = 2.0
    """Window of precession, coherence, contact and shape [rev]."""
    rest_rotation: float = 0.05
    """Rotation below which the string is at rest [rev/s]."""
    fewest_samples: float = 4.0
    """Not observable: fewer samples in a revolution than this; an orbit of up to twice the rotation, either way, needs
    as many."""
    contact_radius: float = 0.95
    """In contact, where no wall force is given: radius about the hole's axis, as a fraction of the clearance."""
    contact_fraction: float = 0.5
    """Along the wall: in contact for this share of the time."""
    contact_hysteresis: float = 0.1
    """Leaves the wall below `contact_fraction` by this much."""
    rolling_slip: float = 0.5
    """Rolling: slip of the contact point over the rim speed, |1 + ratio clearance / r_o|, below this; over when 0.1
    above."""
    coherence: float = 0.85
    """Rough: coherence of the angle with a steady pace below this."""
    unevenness: float = 0.3
    """Rough: rms deviation of the radius from its trend over its mean above this."""
    settled: float = 1.0
    """Rough: only this long after the whirl was certain, for growth is uneven too [rev]."""
    rough_memory: float = 4.0
    """Irregular: memory of rough time [rev]."""
    rough_share: float = 0.55
    """Irregular: rough for more than this share of the time remembered; a change from one regular motion to another is
    rough for two revolutions, which does not suffice."""
    rough_end: float = 0.3
    """Regular again: rough for less than this share."""
    planar: float = 0.7
    """Planarity |sum Z^2| / sum |Z|^2 of the marks: 1 is a plane, 0 a circle seen along the axis; a spiral below
    this, a plane again 0.1 above."""
    lobe: float = 0.3
    """Second bending: least radius on each side of the axis over the largest; over when 0.1 below."""
    vote_memory: float = 0.5
    """Memory of the votes for a state [rev]."""
    vote_lead: float = 0.2
    """A new state needs this lead in votes over the present one (hysteresis)."""
