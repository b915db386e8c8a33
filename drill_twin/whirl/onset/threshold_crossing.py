# SPDX-License-Identifier: Apache-2.0
"""The moment at which a mark began to whirl, dated with all that is remembered of the revolutions before."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.history import ASYNCHRONOUS, SYNCHRONOUS, History
from drill_twin.whirl.onset.crossing_time import crossing_time, smoothed_radius
from drill_twin.whirl.orbit.orbit_refit import LONGEST, SHORTEST, Refit, refit

ROUND = math.radians(70.0)
"""An orbit is fitted once it has gone so far round, as seen from the hole and from the string [rad]."""
PART = 0.4
"""A good part of the threshold."""
CALM = 4.0
"""So long before it crossed, a mark was at its old place [rev]."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """A mark's radius that crossed its threshold for good."""

    time: float
    """When it crossed, since the first sample [s]."""
    mark: int
    """Index of the mark."""
    confidence: float
    """0 to 1."""
    criterion: str
    """What decided it, in words."""
    refit: Refit | None = None
    """The last revolutions with the orbit in mind, where they could be fitted."""


@dataclass(frozen=True)
class Evidence:
    """What is known of a mark when its whirl has become certain; radii over the clearance."""

    mark: int
    clearance: float
    """[m]"""
    threshold: float
    size: float
    """Radius now."""
    noise: float
    """Noise of a bin per axis."""
    width: int
    """Bins averaged."""
    coherence: float
    """How steadily it turns, 0 to 1."""
    offset: complex = 0j
    """Offset that was taken off [m]."""
    synchronous: complex = 0j
    """Synchronous part that was taken off [m]."""
    arm: complex | None = None
    """Arm of the mark [m] where it crossed before its steady place was known: the hole's axis then stands for it."""


def asynchronous_crossing(history: History, known: Evidence, pace: float, since: int, trusted: int) -> Crossing:
    """Dates a whirl that has been above its threshold for `since` bins at about `pace` [rad/s].

    Only the `trusted` newest bins count: before them, the motion stood still elsewhere.
    """
    mark, half = known.mark, known.width // 2
    n = min(history.span(LONGEST), max(1, trusted))
    window = history.newest(n)
    time, orbit = history.time[window], history.vector[window, ASYNCHRONOUS, mark]
    again = refit(time, history.sample[window, :, mark], orbit, min(n, since), pace, half)
    if again is not None and _near(again, known) and _goes_round(again, history, window, known):
        orbit, pace = again.orbit, again.pace
    else:
        offset, synchronous = old_place(history, mark, since, trusted) or (known.offset, known.synchronous)
        orbit = history.sample[window, 0, mark] - offset - synchronous * history.sample[window, 1, mark]
        again = Refit(offset, synchronous, orbit, pace)
    back = orbit / known.clearance * np.exp(-1j * pace * (time - time[-1]))
    ratio = pace / (math.tau * rotation) if (rotation := _rotation(history, since)) else math.nan
    radius = smoothed_radius(back, half, known.noise)
    if known.arm is not None:
        # So early, offset and synchronous part can stand for each other: about the axis it must be as large.
        place, turn = history.sample[window, 0, mark], history.sample[window, 1, mark]
        whole: ComplexArray = (place - known.arm * turn) / known.clearance * np.exp(-1j * pace * (time - time[-1]))
        radius = np.minimum(radius, smoothed_radius(whole, half, known.noise))
    return Crossing(
        _dated(time, radius, known, half),
        mark,
        known.coherence * _certainty(known),
        f"asynchronous radius over {100 * known.threshold:.0f} % of the clearance for a revolution, "
        f"now {100 * known.size:.1f} %, turning at {ratio:+.2f} of the rotation",
        again,
    )


def old_place(history: History, mark: int, since: int, trusted: int) -> tuple[complex, complex] | None:
    """Offset and synchronous part [m] of a mark until `CALM` revolutions before it crossed, `since` bins ago.

    None where that is not remembered. An orbit too slow to be fitted has leaked into the running offset while it grew,
    but not into the old place.
    """
    window = history.newest(min(history.span(LONGEST), max(1, trusted)))
    travel = history.travel[window]
    old = travel < travel[-min(since, travel.size)] - CALM
    n = int(old.sum())
    if n < SHORTEST:
        return None
    e, z = history.sample[window, 1, mark][old], history.sample[window, 0, mark][old]
    mean_e, mean_z = complex(e.sum()) / n, complex(z.sum()) / n
    spread = float((np.abs(e - mean_e) ** 2).sum())
    if spread < 0.5 * n:  # not a full turn of the string
        return None
    synchronous = complex(((e - mean_e).conj() * z).sum()) / spread
    return mean_z - synchronous * mean_e, synchronous


def _near(again: Refit, known: Evidence) -> bool:
    """Whether a refit corrects no more than can have leaked while the orbit was below its threshold."""
    most = known.threshold * known.clearance
    return abs(again.offset - known.offset) < most and abs(again.synchronous - known.synchronous) < most


def _goes_round(again: Refit, history: History, window: slice, known: Evidence) -> bool:
    """Whether an orbit has gone far enough round, since it was a good part of its threshold, to tell its middle."""
    small = np.flatnonzero(np.abs(again.orbit) < PART * known.threshold * known.clearance)
    start = int(small[-1]) + 1 if small.size else 0
    time, angle = history.time[window][start:], history.angle[window][start:]
    if time.size < 2:
        return False
    turned = again.pace * float(time[-1] - time[0])
    return min(abs(turned), abs(turned - float(angle[-1] - angle[0]))) > ROUND


def synchronous_crossing(history: History, known: Evidence) -> Crossing:
    """Dates a surge of the synchronous part."""
    window = history.newest(history.length)
    half, clearance = known.width // 2, known.clearance
    vector = history.vector[window, SYNCHRONOUS, known.mark]
    radius = smoothed_radius(vector, half, known.noise * clearance) / clearance
    return Crossing(
        _dated(history.time[window], radius, known, half),
        known.mark,
        min(1.0, known.coherence) * _certainty(known),
        f"synchronous radius over {100 * known.threshold:.0f} % of the clearance and twice its steady level or more, "
        f"now {100 * known.size:.1f} %",
    )


def _dated(time: Array, radius: Array, known: Evidence, half: int) -> float:
    return crossing_time(time, radius, known.threshold, known.noise / math.sqrt(2 * half + 1))


def _certainty(known: Evidence) -> float:
    """1 less the chance that the averaged noise alone is as large."""
    remaining = known.noise / math.sqrt(known.width)
    return 1.0 - math.exp(-0.5 * (known.size / remaining) ** 2) if remaining > 0.0 else 1.0


def _rotation(history: History, bins: int) -> float:
    """Mean rotation over the newest bins [rev/s]."""
    window = history.newest(max(2, min(bins, history.length)))
    angle, time = history.angle[window], history.time[window]
    return float((angle[-1] - angle[0]) / (math.tau * (time[-1] - time[0])))
