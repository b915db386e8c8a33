# SPDX-License-Identifier: Apache-2.0
"""Orbit of each mark over the last revolutions: radius, precession, regularity, contact.

Precession is the slope of the unwrapped angle against time (least squares over `Criteria.orbit_window` revolutions),
which depends neither on the sample rate nor on gaps of single bins. It is that of the asynchronous part during whirl,
otherwise that of the motion about the offset, so that a bow has a ratio of 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray, Mask
from drill_twin.base.exact_jit import exact_kernel
from drill_twin.base.numpy_loops import absolute, cos, hypot, sin, total
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import APPENDED, CONTACT, LENGTH, SEEN, SYNCHRONOUS, History, bins_in, end_of
from drill_twin.whirl.row_sums import complex_sum_rows, sum_rows
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
    ratio: Array  # (m,) precession over rotation
    confidence: Array  # (m,) in both
    numbers: Array
    clearance: Array  # (m,) [m]
    size: Array  # (WINDOW, 2, m) work
    power: Array  # (WINDOW, 2, m) work
    angle: Array  # (WINDOW, 2, m) work
    wave: Array  # (WINDOW, 2, m) work
    time: Array  # (2, WINDOW) work
    sums: Array  # (4, 2 m) work
    complex_sum: ComplexArray  # (m,) work
    single: Array  # (1,) work

    @classmethod
    def of(cls, clearance: Array) -> Orbit:
        """Orbits before the first bin."""
        m = clearance.size
        rate, radius, coherence, unevenness = np.zeros((4, 2, m))
        window_radius, synchronous, share, contact, confidence = np.zeros((5, m))
        size, power, angle, wave = np.zeros((4, WINDOW, 2, m))
        return cls(
            rate, radius, window_radius, coherence, unevenness, synchronous, share, contact, np.ones(m, bool),
            np.full(m, math.nan), np.full(m, math.nan), confidence, np.array([0.0, math.inf, 0.0, 0.0, 0.0]), clearance,
            size, power, angle, wave, np.zeros((2, WINDOW)), np.zeros((4, 2 * m)), np.zeros(m, complex),
            np.zeros(1),
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


@exact_kernel
def fit_orbit(orbit: Orbit, history: History, criteria: Criteria, noise: Array) -> None:
    """Estimate with the newest bin; `noise` of a bin per axis over the clearance, shape (m,)."""
    numbers, clock, m, end = orbit.numbers, history.clock, noise.size, end_of(history)
    n = bins_in(history, criteria.orbit_window)
    first = end - n
    # Across gaps too: samples may be so rare that each follows a gap.
    bins = max(n, 2)
    span = clock[end - 1, REVOLUTIONS] - clock[end - min(bins, history.counts[APPENDED]), REVOLUTIONS]
    numbers[COMPLETE] = 1.0 if n > 1 and span > SHORTEST_WINDOW else 0.0
    numbers[SAMPLE_RATE] = (bins - 1) / span if span > 0.0 else math.inf
    numbers[LAG] = 0.5 * (clock[end - 1, TIME] - clock[first, TIME])
    sum_rows(history.real_part[first:end, CONTACT], orbit.contact)
    numbers[ROTATION] = mean_rate(history, n)
    recent = min(history.counts[APPENDED], max(2, min(history.counts[LENGTH], RECENT)))
    numbers[RECENT_ROTATION] = mean_rate(history, recent)
    size, power = orbit.size, orbit.power
    for i in range(n):
        for row in range(2):
            absolute(history.complex_part[first + i, row], size[i, row])
            for k in range(m):
                size[i, row, k] /= orbit.clearance[k]
                power[i, row, k] = size[i, row, k] * size[i, row, k]
    complex_sum_rows(history.complex_part[first:end, SYNCHRONOUS], orbit.complex_sum)
    absolute(orbit.complex_sum, orbit.synchronous)
    powers = orbit.sums[0]
    _sum_pairs(power[:n], powers)
    last = bins_in(history, 1.0)
    for k in range(m):
        orbit.contact[k] /= n
        orbit.synchronous[k] /= n * orbit.clearance[k]
        orbit.synchronous_share[k] = orbit.synchronous[k] / math.sqrt(powers[m + k] / n + 1e-300)
        squared = noise[k] * noise[k]
        orbit.window_radius[k] = math.sqrt(np.maximum(powers[k] / n - 2.0 * squared, 0.0))
        bins = 0
        for i in range(end - last, end):
            bins += history.real_part[i, SEEN, k] > 0.0
        orbit.seen[k] = 2 * bins >= last
    _sum_pairs(power[n - last : n], powers)
    for row in range(2):
        for k in range(m):
            mean = powers[row * m + k] / last
            orbit.radius[row, k] = math.sqrt(np.maximum(mean - 2.0 * (noise[k] * noise[k]), 0.0))
    if n >= FEWEST:
        _regress(orbit, history, n, noise)


@exact_kernel
def _regress(orbit: Orbit, history: History, n: int, noise: Array) -> None:
    """Fit straight lines to angle and radius over time, of the newest n bins."""
    m, first = noise.size, end_of(history) - n
    size, angle, wave, work = orbit.size[:n], orbit.angle[:n], orbit.wave[:n], orbit.power[:n]
    centred, weight = orbit.time[0, :n], orbit.time[1, :n]
    time = history.clock[first : first + n, TIME]
    mean_time = total(time, orbit.single) / n
    for i in range(n):
        centred[i] = time[i] - mean_time
        weight[i] = centred[i] * centred[i]
    spread = total(weight, orbit.single)
    sums, other, sizes, rate = orbit.sums[0], orbit.sums[1], orbit.sums[2], orbit.rate
    _sum_pairs(history.real_part[first : first + n, :CONTACT], sums)
    for i in range(n):
        weight[i] = centred[i] / spread
        for row in range(2):
            for k in range(m):
                angle[i, row, k] = history.real_part[first + i, row, k] - sums[row * m + k] / n
                wave[i, row, k] = weight[i] * angle[i, row, k]
    _sum_pairs(wave, sums)
    for row in range(2):
        for k in range(m):
            rate[row, k] = sums[row * m + k]
    for i in range(n):
        for row in range(2):
            for k in range(m):
                angle[i, row, k] -= centred[i] * rate[row, k]
    _sum_pairs(size, sizes)
    cos(angle, wave)
    for i in range(n):
        for row in range(2):
            for k in range(m):
                wave[i, row, k] *= size[i, row, k]
    _sum_pairs(wave, sums)
    sin(angle, wave)
    for i in range(n):
        for row in range(2):
            for k in range(m):
                wave[i, row, k] *= size[i, row, k]
    _sum_pairs(wave, other)
    hypot(sums, other, sums)
    for row in range(2):
        for k in range(m):
            sizes[row * m + k] += 1e-300
            orbit.coherence[row, k] = sums[row * m + k] / sizes[row * m + k]
    for i in range(n):
        for row in range(2):
            for k in range(m):
                work[i, row, k] = size[i, row, k] - sizes[row * m + k] / n
                wave[i, row, k] = weight[i] * work[i, row, k]
    _sum_pairs(wave, sums)
    for i in range(n):
        for row in range(2):
            for k in range(m):
                work[i, row, k] -= centred[i] * sums[row * m + k]
                work[i, row, k] *= work[i, row, k]
    _sum_pairs(work, sums)
    for row in range(2):
        for k in range(m):
            rough = sums[row * m + k] / n - noise[k] * noise[k]
            orbit.unevenness[row, k] = math.sqrt(np.maximum(rough, 0.0)) / (sizes[row * m + k] / n)


@exact_kernel
def _sum_pairs(rows: Array, out: Array) -> None:
    """Sum over the first axis of an array, shape (n, 2, m), to `out`, shape (2 m,)."""
    m = rows.shape[2]
    out[:] = 0.0
    for i in range(rows.shape[0]):
        for row in range(2):
            for k in range(m):
                out[row * m + k] += rows[i, row, k]


@exact_kernel
def is_aliased(orbit: Orbit, criteria: Criteria) -> bool:
    """Check for too few samples in a revolution to distinguish whirls."""
    return bool(orbit.numbers[SAMPLE_RATE] < criteria.fewest_samples)


@exact_kernel
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


@exact_kernel
def mean_rate(history: History, bins: int) -> float:
    """Mean rotation over the newest bins [rev/s]."""
    if bins < 2:
        return 0.0
    newest, first = history.clock[end_of(history) - 1], history.clock[end_of(history) - bins]
    return float((newest[ANGLE] - first[ANGLE]) / ((newest[TIME] - first[TIME]) * math.tau))
