# SPDX-License-Identifier: Apache-2.0
"""Time at which the radius of a whirl crossed its threshold, found backwards once the whirl is detected.

The crossing is the last time at which the mean square of the radius over a revolution rose to the threshold squared, by
interpolation of its logarithm, since orbits grow exponentially. Noise is taken out of the square, and averages out;
two whirls at once, an ellipse, strikes and irregular motion, whose radius dips within a revolution, have one crossing.
A sudden start is in the mean half a revolution before: where the radius first crosses within that time, it tells.
"""

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.compile.jit import as_python
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import ASYNCHRONOUS, CAPACITY, SYNCHRONOUS, newest, newest_in
from drill_twin.whirl.orbit.orbit import mean_rate
from drill_twin.whirl.orbit.runout_separation import (
    REFIT_BINS,
    REFIT_REVOLUTIONS,
    OrbitRefit,
    refit_orbit,
    smoothed_radius,
)

MEAN = 1.0
"""Duration over which the square of the radius is averaged to date a crossing [rev]: the onset's `criteria.SUSTAIN`. Of
220 onsets on seeds from 7,300,000 on, 184 are dated within half a revolution; 177 by half, 153 by twice as much, and
none more by a fit of the growth over up to twelve revolutions, or by the strongest mark in place of the first."""
TINY = 1e-18
"""Mean square of a radius that is taken as 0, so that it has a logarithm: below what a binary64 keeps of 1."""
SMALLEST_SWEEP = math.radians(70.0)
"""Smallest angle swept by an orbit that is refitted, in the frames of hole and string [rad]."""
SWEEP_RADIUS = 0.4
"""Smallest radius, over the threshold, at which the swept angle is counted; chosen, not measured."""
FAST = 2.0
"""Ratio of precession to rotation beyond which an orbit leaks neither into the offset nor into the synchronous part."""
STEADY_BEFORE = 4.0
"""Duration before the crossing that is left out of the steady position [rev]; chosen, not measured."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """Crossing of the threshold by a mark's radius."""

    time: float
    """Time since the first sample [s]."""
    mark: int
    """Index of the mark."""
    confidence: float
    """0 to 1."""
    criterion: str
    """Criterion that decided the crossing, as text."""
    refit: OrbitRefit | None = None
    """Parts of the motion fitted with the orbit in the model, for an asynchronous crossing."""


@dataclass(frozen=True)
class Detection:
    """A mark whose whirl has been detected; radii over the clearance."""

    mark: int
    clearance: float
    """[m]"""
    threshold: float
    radius: float
    """Present radius."""
    noise: float
    """Noise of a bin per axis."""
    width: int
    """Bins averaged."""
    coherence: float
    """Coherence of the angle, 0 to 1."""
    offset: complex = 0j
    """Offset that was subtracted [m]."""
    synchronous: complex = 0j
    """Synchronous part that was subtracted [m]."""
    arm: complex | None = None
    """Arm of the mark [m] if the mark crossed before its steady position was known; the hole's axis then
    replaces the position."""


def asynchronous_crossing(history: Columns, detection: Detection, rate: float, since: int, valid: int) -> Crossing:
    """Find the crossing of the asynchronous part.

    Args:
        history: The last revolutions.
        detection: The mark and its radius.
        rate: Approximate rate of the asynchronous part [rad/s].
        since: Number of newest bins above the threshold.
        valid: Number of newest bins that may be used; before them, the steady position was another.
    """
    mark, half = detection.mark, detection.width // 2
    n = min(newest_in(history, REFIT_REVOLUTIONS), max(1, valid))
    window = newest(history, n)
    time, orbit = history.time[window], history.vector[window, ASYNCHRONOUS, mark]
    position, phasor = history.position[window, mark], history.phasor[window, mark]
    rotation = as_python(mean_rate)(history, max(2, min(since, history.length.item())))
    ratio = rate / (math.tau * rotation) if rotation else math.nan
    # A fast orbit leaks into nothing, and seen once a bin it may pass for an offset or a synchronous part.
    fast = abs(ratio) > FAST
    refit = None if fast else refit_orbit(time, position, phasor, orbit, min(n, since), rate, half)
    if refit is not None and _plausible(refit, detection) and _sweeps_enough(refit, history, window, detection):
        rate = refit.rate
    elif not fast:
        steady = steady_position(history, mark, since, valid)
        offset, synchronous = steady or (detection.offset, detection.synchronous)
        refit = OrbitRefit(offset, synchronous, position - offset - synchronous * phasor, rate)
    # The whirl may have grown before a gap, over which only its size is followed.
    window = newest(history, min(int(history.appended[0]), CAPACITY, max(1, valid)))
    revolutions = history.revolutions[window]
    window = newest(history, int((revolutions > revolutions[-1] - REFIT_REVOLUTIONS).sum()))
    time, position, phasor = history.time[window], history.position[window, mark], history.phasor[window, mark]
    orbit = history.vector[window, ASYNCHRONOUS, mark]
    if refit is not None:
        orbit = position - refit.offset - refit.synchronous * phasor
    carrier = np.exp(-1j * rate * (time - time[-1]))
    radius = smoothed_radius(orbit / detection.clearance * carrier, half, detection.noise)
    if detection.arm is not None:
        # Offset and synchronous part are not known this early: the radius about the axis must be as large.
        centre: ComplexArray = (position - detection.arm * phasor) / detection.clearance * carrier
        radius = np.minimum(radius, smoothed_radius(centre, half, detection.noise))
    return Crossing(
        _crossing_time(time, history.revolutions[window], radius, detection.threshold),
        mark,
        detection.coherence * _significance(detection),
        f"asynchronous radius over {100 * detection.threshold:.0f} % of the clearance for a revolution, "
        f"now {100 * detection.radius:.1f} %, turning at {ratio:+.2f} of the rotation",
        refit,
    )


def synchronous_crossing(history: Columns, detection: Detection) -> Crossing:
    """Find the crossing of the motion about the offset in a synchronous whirl."""
    window = newest(history, history.length[0])
    half, clearance = detection.width // 2, detection.clearance
    vector = history.vector[window, SYNCHRONOUS, detection.mark]
    radius = smoothed_radius(vector, half, detection.noise * clearance) / clearance
    return Crossing(
        _crossing_time(history.time[window], history.revolutions[window], radius, detection.threshold),
        detection.mark,
        min(1.0, detection.coherence) * _significance(detection),
        f"synchronous radius over {100 * detection.threshold:.0f} % of the clearance and twice its steady level or "
        f"more, now {100 * detection.radius:.1f} %",
    )


def steady_position(history: Columns, mark: int, since: int, valid: int) -> tuple[complex, complex] | None:
    """Offset and synchronous part [m] of a mark until `STEADY_BEFORE` revolutions before it crossed, `since` bins ago.

    None where the history is too short. A slow orbit leaks into the running offset while it grows, but not into this
    position.
    """
    window = newest(history, min(newest_in(history, REFIT_REVOLUTIONS), max(1, valid)))
    revolutions = history.revolutions[window]
    before = revolutions < revolutions[-min(since, revolutions.size)] - STEADY_BEFORE
    n = int(before.sum())
    if n < REFIT_BINS:
        return None
    phasor, position = history.phasor[window, mark][before], history.position[window, mark][before]
    mean_phasor, mean_position = complex(phasor.sum()) / n, complex(position.sum()) / n
    spread = float((np.abs(phasor - mean_phasor) ** 2).sum())
    if spread < 0.5 * n:  # less than a revolution of the string
        return None
    synchronous = complex(((phasor - mean_phasor).conj() * position).sum()) / spread
    return mean_position - synchronous * mean_phasor, synchronous


def _plausible(refit: OrbitRefit, detection: Detection) -> bool:
    """Check that a refit corrects no more than can have leaked while the orbit was below its threshold."""
    largest = detection.threshold * detection.clearance
    return abs(refit.offset - detection.offset) < largest and abs(refit.synchronous - detection.synchronous) < largest


def _sweeps_enough(refit: OrbitRefit, history: Columns, window: slice, detection: Detection) -> bool:
    """Check that an orbit has swept a sufficient angle to determine its centre."""
    small = np.flatnonzero(np.abs(refit.orbit) < SWEEP_RADIUS * detection.threshold * detection.clearance)
    start = int(small[-1]) + 1 if small.size else 0
    time, angle = history.time[window][start:], history.angle[window][start:]
    if time.size < 2:
        return False
    swept = refit.rate * float(time[-1] - time[0])
    return min(abs(swept), abs(swept - float(angle[-1] - angle[0]))) > SMALLEST_SWEEP


def _crossing_time(time: Array, revolutions: Array, radius: Array, threshold: float) -> float:
    """Last time [s] at which the mean square of `radius` over `MEAN` rose to the square of `threshold`.

    Args:
        time: Times of the bins [s], shape (n,).
        revolutions: Revolutions at the bins [rev], shape (n,).
        radius: Radius over the clearance, noise removed, shape (n,).
        threshold: The level over the clearance.
    """
    index, n = np.arange(time.size), time.size
    # As many bins before as after, so that growth moves the mean no further than its curvature does.
    reach = np.minimum(
        index - np.searchsorted(revolutions, revolutions - 0.5 * MEAN),  # half on either side, by definition
        np.searchsorted(revolutions, revolutions + 0.5 * MEAN, side="right") - 1 - index,  # by the same definition
    )
    total = np.concatenate(([0.0], np.cumsum(radius**2)))
    power = (total[index + reach + 1] - total[index - reach]) / (2 * reach + 1)
    below = np.flatnonzero(power < threshold**2)
    first = int(below[-1]) + 1 if below.size else 0
    if first in {0, n}:
        return float(time[min(first, n - 1)])
    # The mean knows of a sudden start half a revolution before: the radius itself then first crosses within that time.
    later, half = first - 1 + int(np.argmax(radius[first - 1 :] >= threshold)), int(reach[first])
    if first <= later <= first + half and radius[max(0, first - 1 - half) : later].max() < threshold:
        power, first = radius**2, later
    low, high = math.log(max(float(power[first - 1]), TINY)), math.log(float(power[first]))
    share = (2.0 * math.log(threshold) - low) / (high - low)
    return math.fsum((float(time[first - 1]) * (1.0 - share), float(time[first]) * share))


def _significance(detection: Detection) -> float:
    """1 less the probability that the averaged noise alone is as large."""
    remaining = detection.noise / math.sqrt(detection.width)
    return 1.0 - math.exp(-0.5 * (detection.radius / remaining) ** 2) if remaining > 0.0 else 1.0  # formula of Rayleigh
