# SPDX-License-Identifier: Apache-2.0
"""Orbit of each mark over the last revolutions: radius, precession, regularity, contact.

Precession is the slope of the unwrapped angle against time (least squares over `Criteria.orbit_window` revolutions),
which depends neither on the sample rate nor on gaps of single bins. It is that of the asynchronous part during whirl,
otherwise that of the motion about the offset, so that a bow has a ratio of 1.

The shape of the rotating string, as far as a few marks show it, is in the covariance of the marks' moving parts over
the last two revolutions, C_ij = sum conj(M_i) M_j, which contains their radii and relative phases, whatever the
precession. The row of the mark with the largest motion is the shape s (one step of a power iteration, exact when the
string rotates as one body). Its planarity |sum s^2| / sum |s|^2 is 1 for a curve in one plane through the axis and 0
for a circle.
Marks half a helix pitch apart lie in a plane: a helix is detected only where marks are closer than that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import (
    APPENDED,
    CONTACT,
    LENGTH,
    MOVING,
    NEGLIGIBLE,
    POSITION,
    SEEN,
    SYNCHRONOUS,
    History,
    bins_in,
    end_of,
)
from drill_twin.whirl.sample_bins import ANGLE, BINS, REVOLUTIONS, TIME

FEWEST = 4
"""Fewest bins for a slope."""
RECENT = 4
"""Bins of the recent rotation: a quarter of a revolution, 2 s for a string that hardly rotates."""
SHORTEST_WINDOW = 0.9
"""Shortest window for which the estimates are meaningful [rev]."""
SMALLEST = 1e-3
"""Smallest radius with a precession, as a fraction of the clearance."""
OVER_NOISE = 2.0
"""Smallest radius with a precession, over the noise of a bin."""
LAG, SAMPLE_RATE, ROTATION, RECENT_ROTATION, COMPLETE = range(5)
"""Indices into `Orbit.numbers`."""
WINDOW = 8 * BINS
"""Most bins in the window."""


class Orbit(NamedTuple):
    """Orbits of the last revolutions; rows 0 and 1 are the asynchronous part and the motion about the offset."""

    rate: Array  # (2, m) of the angle [rad/s], right-handed about +z
    radius: Array  # (2, m) rms over the last revolution, noise removed, over the clearance
    window_radius: Array  # (m,) rms of the asynchronous part over the window, noise removed, over the clearance
    coherence: Array  # (2, m) 1 for an angle of constant rate, 0 for a random one
    unevenness: Array  # (2, m) rms deviation of the radius from its linear trend over its mean, noise removed
    synchronous: Array  # (m,) radius of the synchronous part over the window, over the clearance
    synchronous_share: Array  # (m,) its share of the rms radius of the motion about the offset
    contact: Array  # (m,) share of the window in contact with the wall
    seen: Mask  # (m,) marks seen in at least half of the bins of the last revolution
    precession: Array  # (m,) [rev/s], positive = forward
    ratio: Array  # (m,) whirl ratio
    confidence: Array  # (m,) in both
    numbers: Array
    clearance: Array  # (m,) [m]
    size: Array  # (WINDOW, 2, m) work: radius in each bin, over the clearance
    time: Array  # (WINDOW,) work: time less its mean [s]

    @classmethod
    def of(cls, clearance: Array) -> Orbit:
        """Orbits before the first bin."""
        m = clearance.size
        rate, radius, coherence, unevenness = np.zeros((4, 2, m))
        window_radius, synchronous, share, contact, confidence = np.zeros((5, m))
        return cls(
            rate, radius, window_radius, coherence, unevenness, synchronous, share, contact, np.ones(m, bool),
            np.full(m, math.nan), np.full(m, math.nan), confidence, np.array([0.0, math.inf, 0.0, 0.0, 0.0]), clearance,
            np.zeros((WINDOW, 2, m)), np.zeros(WINDOW),
        )  # fmt: skip

    @property
    def lag(self) -> float:
        """Mean delay of the estimates: half the length of the window [s]."""
        return float(self.numbers[LAG])

    @property
    def samples_per_revolution(self) -> float:
        """Samples in a revolution over the window, at most about `BINS`."""
        return float(self.numbers[SAMPLE_RATE])

    @property
    def rotation(self) -> float:
        """Rotation over the window [rev/s], signed."""
        return float(self.numbers[ROTATION])

    @property
    def recent_rotation(self) -> float:
        """Rotation over the last quarter of a revolution [rev/s], signed."""
        return float(self.numbers[RECENT_ROTATION])

    @property
    def known(self) -> bool:
        """True once the window has the length of a revolution."""
        return bool(self.numbers[COMPLETE])


@strict_kernel
def fit_orbit(orbit: Orbit, history: History, criteria: Criteria, noise: Array) -> None:
    """Estimate with the newest bin; `noise` of a bin per axis over the clearance, shape (m,)."""
    numbers, clock, m, end = orbit.numbers, history.clock, noise.size, end_of(history)
    n, last = bins_in(history, criteria.orbit_window), bins_in(history, 1.0)
    first = end - n
    # Across gaps too: samples may be so rare that each follows a gap.
    bins = max(n, 2)
    span = clock[end - 1, REVOLUTIONS] - clock[end - min(bins, history.counts[APPENDED]), REVOLUTIONS]
    numbers[COMPLETE] = 1.0 if n > 1 and span > SHORTEST_WINDOW else 0.0
    numbers[SAMPLE_RATE] = (bins - 1) / span if span > 0.0 else math.inf
    numbers[LAG] = 0.5 * (clock[end - 1, TIME] - clock[first, TIME])
    numbers[ROTATION] = mean_rate(history, n)
    recent = min(history.counts[APPENDED], max(2, min(history.counts[LENGTH], RECENT)))
    numbers[RECENT_ROTATION] = mean_rate(history, recent)
    for k in range(m):
        clearance, variance = orbit.clearance[k], 2.0 * noise[k] * noise[k]
        contact, seen, synchronous = 0.0, 0, 0j
        for i in range(first, end):
            contact += history.real_part[i, CONTACT, k]
            synchronous += history.complex_part[i, SYNCHRONOUS, k]
            seen += i >= end - last and history.real_part[i, SEEN, k] > 0.0
        orbit.contact[k] = contact / n
        orbit.seen[k] = 2 * seen >= last
        orbit.synchronous[k] = abs(synchronous) / (n * clearance)
        for row in range(2):
            power, newest = 0.0, 0.0
            for i in range(n):
                size = abs(history.complex_part[first + i, row, k]) / clearance
                orbit.size[i, row, k] = size
                power += size * size
                newest += size * size if i >= n - last else 0.0
            orbit.radius[row, k] = math.sqrt(max(newest / last - variance, 0.0))
            if row == 0:
                orbit.window_radius[k] = math.sqrt(max(power / n - variance, 0.0))
            else:
                orbit.synchronous_share[k] = orbit.synchronous[k] / math.sqrt(power / n + 1e-300)
    if n >= FEWEST:
        _regress(orbit, history, n, noise)


@strict_kernel
def _regress(orbit: Orbit, history: History, n: int, noise: Array) -> None:
    """Fit straight lines to angle and radius over time, of the newest n bins."""
    first = end_of(history) - n
    time, centred = history.clock[first : first + n, TIME], orbit.time[:n]
    mean, spread = 0.0, 0.0
    for i in range(n):
        mean += time[i] / n
    for i in range(n):
        centred[i] = time[i] - mean
        spread += centred[i] * centred[i]
    for row in range(2):
        for k in range(noise.size):
            mean_angle, rate, radius, growth = 0.0, 0.0, 1e-300, 0.0
            for i in range(n):
                mean_angle += history.real_part[first + i, row, k] / n
                radius += orbit.size[i, row, k]
            for i in range(n):
                rate += centred[i] / spread * (history.real_part[first + i, row, k] - mean_angle)
                growth += centred[i] / spread * (orbit.size[i, row, k] - radius / n)
            mean_vector, rough = 0j, 0.0
            for i in range(n):
                angle = history.real_part[first + i, row, k] - mean_angle - centred[i] * rate
                mean_vector += orbit.size[i, row, k] * complex(math.cos(angle), math.sin(angle))
                deviation = orbit.size[i, row, k] - radius / n - centred[i] * growth
                rough += deviation * deviation
            orbit.rate[row, k] = rate
            orbit.coherence[row, k] = abs(mean_vector) / radius
            orbit.unevenness[row, k] = math.sqrt(max(rough / n - noise[k] * noise[k], 0.0)) / (radius / n)


@strict_kernel
def is_aliased(orbit: Orbit, criteria: Criteria) -> bool:
    """Check for too few samples in a revolution to distinguish whirls."""
    return bool(orbit.numbers[SAMPLE_RATE] < criteria.fewest_samples)


@strict_kernel
def find_precession(orbit: Orbit, criteria: Criteria, whirling: Mask, noise: Array) -> None:
    """Find precession, its ratio to rotation and the confidence in both."""
    rotation, aliased = orbit.numbers[ROTATION], is_aliased(orbit, criteria)
    rotating = abs(rotation) >= criteria.rest_rotation
    for k in range(noise.size):
        row = 0 if whirling[k] else 1
        rate, radius = orbit.rate[row, k] / math.tau, orbit.radius[row, k]
        orbit.precession[k] = orbit.ratio[k] = math.nan
        orbit.confidence[k] = 0.0
        if orbit.seen[k] and not aliased and radius > SMALLEST and radius > OVER_NOISE * noise[k] and rate != 0.0:
            power = radius * radius
            noisy = np.maximum(power + 2.0 * (noise[k] * noise[k]), 1e-300)
            orbit.confidence[k] = orbit.coherence[row, k] * power / noisy
            orbit.precession[k] = (-1.0 if rotation < 0.0 else 1.0) * rate
            if rotating:
                orbit.ratio[k] = orbit.precession[k] / abs(rotation)


@strict_kernel
def mean_rate(history: History, bins: int) -> float:
    """Mean rotation over the newest bins [rev/s]."""
    if bins < 2:
        return 0.0
    newest, first = history.clock[end_of(history) - 1], history.clock[end_of(history) - bins]
    return float((newest[ANGLE] - first[ANGLE]) / ((newest[TIME] - first[TIME]) * math.tau))


PLANARITY, SECOND_LOBE = 0, 1
"""Indices into `StringShape.numbers`."""


class StringShape(NamedTuple):
    """Radii and phases of the marks relative to the mark with the largest motion."""

    reference: Integers  # (1,) mark with the largest motion
    power: Array  # (m,) of each mark's motion over the window [m^2], a sum over its bins
    phase: Array  # (m,) relative to the reference mark [rad]
    numbers: Array
    levels: Integers  # one mark at each distance from the bit, from the bit up
    relative: ComplexArray  # (m,) work: motion of the marks over that of the reference

    @classmethod
    def of(cls, m: int, levels: Integers) -> StringShape:
        """Shape before the first bin."""
        return cls(
            np.zeros(1, np.int64), np.zeros(m), np.full(m, math.nan), np.array([math.nan, 0.0]), levels,
            np.zeros(m, complex),
        )  # fmt: skip

    @property
    def planarity(self) -> float:
        """1 = in one plane, 0 = a circle."""
        return float(self.numbers[PLANARITY])

    @property
    def second_lobe(self) -> float:
        """Smaller over larger of the largest radii on the two sides of the axis, in the plane of the reference mark."""
        return float(self.numbers[SECOND_LOBE])


@strict_kernel
def find_shape(shape: StringShape, history: History, criteria: Criteria) -> None:
    """Estimate the shape with the newest bin."""
    n, end = bins_in(history, criteria.orbit_window), end_of(history)
    moving, position = history.complex_part[end - n : end, MOVING], history.complex_part[end - n : end, POSITION]
    reference, negligible = 0, 0.0
    for k in range(shape.power.size):
        shape.power[k] = 0.0
        for i in range(n):
            shape.power[k] += abs(moving[i, k]) ** 2
            negligible = max(negligible, n * (NEGLIGIBLE * abs(position[i, k])) ** 2)
        # Of marks that move alike the first is the reference, whatever the round-off.
        if not shape.power[k] <= (1.0 + NEGLIGIBLE) * shape.power[reference] and not math.isnan(shape.power[reference]):
            reference = k
    shape.reference[0] = reference
    largest = shape.power[reference]
    if largest <= negligible:
        shape.phase[:] = math.nan
        shape.numbers[PLANARITY], shape.numbers[SECOND_LOBE] = math.nan, 0.0
        return
    for k in range(shape.power.size):
        relative = 0j
        for i in range(n):
            relative += moving[i, reference].conjugate() * moving[i, k]
        shape.relative[k] = relative / largest
        shape.phase[k] = math.atan2(relative.imag, relative.real)
    this, other, squares, powers = 0.0, 0.0, 0j, 0.0
    for level in shape.levels:
        relative = shape.relative[level]
        this, other = max(this, relative.real), max(other, -relative.real)
        squares += relative * relative
        powers += abs(relative) ** 2
    shape.numbers[PLANARITY] = abs(squares) / powers
    shape.numbers[SECOND_LOBE] = min(this, other) / max(this, other, 1e-300)
