# SPDX-License-Identifier: Apache-2.0
"""The moment at which a mark began to whirl, dated with all that is remembered of the revolutions before."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.whirl.bins import Array
from drill_twin.whirl.dating import crossing_time, smoothed_radius
from drill_twin.whirl.history import ASYNCHRONOUS, SYNCHRONOUS, History
from drill_twin.whirl.refit import LONGEST, Refit, refit
from drill_twin.whirl.rotation import TURN


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


def asynchronous_crossing(history: History, known: Evidence, pace: float, since: int, trusted: int) -> Crossing:
    """Dates a whirl that has been above its threshold for `since` bins at about `pace` [rad/s].

    Only the `trusted` newest bins count: before them, the motion stood still elsewhere.
    """
    mark, half = known.mark, known.width // 2
    n = min(history.span(LONGEST), max(1, trusted))
    window = history.newest(n)
    time, orbit = history.time[window], history.vector[window, ASYNCHRONOUS, mark]
    again = refit(time, history.sample[window, :, mark], orbit, min(n, since), pace, half)
    if again is not None and _near(again, known):
        orbit, pace = again.orbit, again.pace
    else:
        again = None
    back = orbit / known.clearance * np.exp(-1j * pace * (time - time[-1]))
    ratio = pace / (TURN * rotation) if (rotation := _rotation(history, since)) else math.nan
    return Crossing(
        _dated(time, back, known, half),
        mark,
        known.coherence * _certainty(known),
        f"asynchronous radius over {100 * known.threshold:.0f} % of the clearance for a revolution, "
        f"now {100 * known.size:.1f} %, turning at {ratio:+.2f} of the rotation",
        again,
    )


def _near(again: Refit, known: Evidence) -> bool:
    """Whether a refit corrects no more than can have leaked while the orbit was below its threshold."""
    most = known.threshold * known.clearance
    return abs(again.offset - known.offset) < most and abs(again.synchronous - known.synchronous) < most


def synchronous_crossing(history: History, known: Evidence) -> Crossing:
    """Dates a surge of the synchronous part."""
    window = history.newest(history.length)
    vector = history.vector[window, SYNCHRONOUS, known.mark] / known.clearance
    return Crossing(
        _dated(history.time[window], vector, known, known.width // 2),
        known.mark,
        min(1.0, known.coherence) * _certainty(known),
        f"synchronous radius over {100 * known.threshold:.0f} % of the clearance and twice its steady level or more, "
        f"now {100 * known.size:.1f} %",
    )


def _dated(time: Array, vector: np.ndarray, known: Evidence, half: int) -> float:
    radius = smoothed_radius(vector, half, known.noise)
    return crossing_time(time, radius, known.threshold, known.noise / math.sqrt(2 * half + 1))


def _certainty(known: Evidence) -> float:
    """1 less the chance that the averaged noise alone is as large."""
    remaining = known.noise / math.sqrt(known.width)
    return 1.0 - math.exp(-0.5 * (known.size / remaining) ** 2) if remaining > 0.0 else 1.0


def _rotation(history: History, bins: int) -> float:
    """Mean rotation over the newest bins [rev/s]."""
    window = history.newest(max(2, min(bins, history.length)))
    angle, time = history.angle[window], history.time[window]
    return float((angle[-1] - angle[0]) / (TURN * (time[-1] - time[0])))
