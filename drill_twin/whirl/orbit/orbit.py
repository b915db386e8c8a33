# SPDX-License-Identifier: Apache-2.0
"""Orbit of each mark over the last revolutions: radius, precession, regularity, contact.

Precession is the slope of the unwrapped angle against time (least squares over `criteria.ORBIT_WINDOW` revolutions),
which depends neither on the sample rate nor on gaps of single bins. The angle is the asynchronous part's during whirl,
otherwise the angle of the motion about the offset, so that a bow has a ratio of 1.

The shape of the rotating string, as far as a few marks show it, is in the covariance of the marks' moving parts over
the last two revolutions, C_ij = sum conj(M_i) M_j, which contains their radii and relative phases, whatever the
precession. The row of the mark with the largest motion is the shape s (one step of a power iteration, exact when the
string rotates as one body). Its planarity |sum s^2| / sum |s|^2 is 1 for a curve in one plane through the axis and 0
for a circle.
Marks half a helix pitch apart lie in a plane: a helix is detected only where marks are closer than half a pitch.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import MOVING, NEGLIGIBLE, SYNCHRONOUS, bins_in, end_of
from drill_twin.whirl.sample_bins import BINS

FEWEST = 4
"""Fewest bins for a slope and the scatter about it; chosen, not measured."""
RECENT = 4
"""Bins of the recent rotation: a quarter of a revolution, 2 s for a string that hardly rotates."""
SHORTEST_WINDOW = 0.9
"""Shortest window for which the estimates are meaningful [rev], a little less than a revolution; chosen."""
SMALLEST = 1e-3
"""Smallest radius with a precession, as a fraction of the clearance; chosen, not measured."""
OVER_NOISE = 2.0
"""Smallest radius with a precession, over the noise of a bin; chosen, not measured."""
WINDOW = 8 * BINS
"""Most bins in the window: `criteria.ORBIT_WINDOW` with four for each 1/16 of a revolution, as `bins_in` gives."""


def new_orbit(clearance: Array) -> Columns:
    """Orbits of the last revolutions of m marks, before the first bin.

    Rows 0 and 1 are the asynchronous part and the motion about the offset.
    """
    m = clearance.size
    rate, radius, coherence, unevenness = np.zeros((4, 2, m))
    return columns(
        "Orbit",
        m,
        rate=rate,  # (2, m) of the angle [rad/s], right-handed about +z
        radius=radius,  # (2, m) rms over the last revolution, noise removed, over the clearance
        window_radius=0.0,  # rms of the asynchronous part over the window, noise removed, over the clearance
        coherence=coherence,  # (2, m) 1 for an angle of constant rate, 0 for a random one
        unevenness=unevenness,  # (2, m) rms deviation of the radius from its linear trend over its mean, noise removed
        synchronous=0.0,  # radius of the synchronous part over the window, over the clearance; 0 for a mark that stands
        synchronous_share=0.0,  # its share of the rms radius of the motion about the offset
        contact=0.0,  # share of the window in contact with the wall
        strikes=0.0,  # contacts in a revolution after the centre line was nearer to the axis than `criteria.AWAY`
        seen=True,  # marks seen in at least half of the bins of the last revolution
        last_seen=0.0,  # time of the last bin in which the mark was seen, since the first sample [s]
        left=0.0,  # share of the asynchronous power in neither of its two strongest lines; 0 without such a whirl
        precession=math.nan,  # [rev/s], positive = forward
        ratio=math.nan,  # whirl ratio
        confidence=0.0,  # in both
        lag=np.zeros(1),  # mean delay of the estimates: half the length of the window [s]
        samples_per_revolution=np.full(1, math.inf),  # over the window, at most about `BINS`
        rotation=np.zeros(1),  # over the window [rev/s], signed
        recent_rotation=np.zeros(1),  # over the last quarter of a revolution [rev/s], signed
        known=np.zeros(1, bool),  # True once the window has the length of a revolution
        clearance=clearance,  # [m]
        size=np.zeros((WINDOW, 2, m)),  # work: radius in each bin, over the clearance
        time=np.zeros(WINDOW),  # work: time less its mean [s]
    )


@strict_kernel
def fit_orbit(orbit: Columns, history: Columns, noise: Array, arm: ComplexArray) -> None:
    """Estimate with the newest bin.

    Args:
        orbit: The orbits.
        history: The bins.
        noise: Of a bin per axis over the clearance, shape (m,).
        arm: From the centre line to the marked points [m], shape (m,).
    """
    m, end = noise.size, end_of(history)
    n, last = bins_in(history, criteria.ORBIT_WINDOW), bins_in(history, 1.0)
    first = end - n
    # Across gaps too: samples may be so rare that each follows a gap.
    bins = max(n, 2)
    span = history.revolutions[end - 1] - history.revolutions[end - min(bins, history.appended[0])]
    orbit.known[0] = n > 1 and span > SHORTEST_WINDOW
    orbit.samples_per_revolution[0] = (bins - 1) / span if span > 0.0 else math.inf
    orbit.lag[0] = 0.5 * (history.time[end - 1] - history.time[first])
    orbit.rotation[0] = mean_rate(history, n)
    recent = min(history.appended[0], max(2, min(history.length[0], RECENT)))
    orbit.recent_rotation[0] = mean_rate(history, recent)
    for k in range(m):
        clearance, variance = orbit.clearance[k], 2.0 * noise[k] * noise[k]
        contact, seen, strikes, away, synchronous, mean, turn = 0.0, 0, 0, False, 0j, 0j, 0j
        for i in range(first, end):
            contact += history.contact[i, k]
            strikes += away and history.contact[i, k] >= criteria.STRUCK
            away = history.contact[i, k] == 0.0 and (
                away or abs(history.position[i, k] - arm[k] * history.phasor[i, k]) < criteria.AWAY * clearance
            )
            synchronous += history.vector[i, SYNCHRONOUS, k] / n
            mean, turn = mean + history.vector[i, MOVING, k] / n, turn + history.phasor[i, k] / n
            seen += i >= end - last and history.seen[i, k]
            if history.seen[i, k]:
                orbit.last_seen[k] = history.time[i]
        orbit.contact[k] = contact / n
        orbit.strikes[k] = strikes / max(span, SHORTEST_WINDOW)
        orbit.seen[k] = 2 * seen >= last
        orbit.synchronous[k] = abs(synchronous - mean * turn.conjugate()) / clearance
        for row in range(2):
            power, newest = 0.0, 0.0
            for i in range(n):
                size = abs(history.vector[first + i, row, k]) / clearance
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
def _regress(orbit: Columns, history: Columns, n: int, noise: Array) -> None:
    """Fit straight lines to angle and radius over time, of the newest n bins."""
    first = end_of(history) - n
    time, centred = history.time[first : first + n], orbit.time[:n]
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
                mean_angle += history.unwrapped[first + i, row, k] / n
                radius += orbit.size[i, row, k]
            for i in range(n):
                rate += centred[i] / spread * (history.unwrapped[first + i, row, k] - mean_angle)
                growth += centred[i] / spread * (orbit.size[i, row, k] - radius / n)
            mean_vector, rough = 0j, 0.0
            for i in range(n):
                angle = history.unwrapped[first + i, row, k] - mean_angle - centred[i] * rate
                mean_vector += orbit.size[i, row, k] * complex(math.cos(angle), math.sin(angle))
                deviation = orbit.size[i, row, k] - radius / n - centred[i] * growth
                rough += deviation * deviation
            orbit.rate[row, k] = rate
            orbit.coherence[row, k] = abs(mean_vector) / radius
            orbit.unevenness[row, k] = math.sqrt(max(rough / n - noise[k] * noise[k], 0.0)) / (radius / n)


@strict_kernel
def is_aliased(orbit: Columns) -> bool:
    """Check for too few samples in a revolution to distinguish whirls."""
    return bool(orbit.samples_per_revolution[0] < criteria.FEWEST_SAMPLES)


@strict_kernel
def find_precession(orbit: Columns, whirling: Mask, noise: Array) -> None:
    """Find precession, its ratio to rotation and the confidence in both."""
    rotation, aliased = orbit.rotation[0], is_aliased(orbit)
    rotating = abs(rotation) >= criteria.REST_ROTATION
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
def mean_rate(history: Columns, bins: int) -> float:
    """Mean rotation over the newest bins [rev/s]."""
    if bins < 2:
        return 0.0
    newest, first = end_of(history) - 1, end_of(history) - bins
    turned, seconds = history.angle[newest] - history.angle[first], history.time[newest] - history.time[first]
    return float(turned / (seconds * math.tau))


def new_shape(m: int, levels: Integers) -> Columns:
    """Radii and phases of m marks relative to the mark with the largest motion, before the first bin.

    `levels` is one mark at each distance from the bit, from the bit up.
    """
    return columns(
        "StringShape",
        m,
        reference=np.zeros(1, np.int64),  # mark with the largest motion
        power=0.0,  # of each mark's motion over the window [m^2], a sum over its bins
        planarity=np.full(1, math.nan),  # 1 = in one plane, 0 = a circle
        second_lobe=np.zeros(1),  # smaller over larger of the largest radii on the two sides of the axis, in the plane
        levels=levels,
        relative=0j,  # work: motion of the marks over the motion of the reference
    )


@strict_kernel
def find_shape(shape: Columns, history: Columns) -> None:
    """Estimate the shape with the newest bin."""
    n, end = bins_in(history, criteria.ORBIT_WINDOW), end_of(history)
    moving, position = history.vector[end - n : end, MOVING], history.position[end - n : end]
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
        shape.planarity[0], shape.second_lobe[0] = math.nan, 0.0
        return
    for k in range(shape.power.size):
        relative = 0j
        for i in range(n):
            relative += moving[i, reference].conjugate() * moving[i, k]
        shape.relative[k] = relative / largest
    this, other, squares, powers = 0.0, 0.0, 0j, 0.0
    for level in shape.levels:
        relative = shape.relative[level]
        this, other = max(this, relative.real), max(other, -relative.real)
        squares += relative * relative
        powers += abs(relative) ** 2
    shape.planarity[0] = abs(squares) / powers
    shape.second_lobe[0] = min(this, other) / max(this, other, 1e-300)
