# SPDX-License-Identifier: Apache-2.0
"""Detection of the onset of asynchronous whirl on the stream.

A mark whirls if the radius of its asynchronous part stays above its threshold for one revolution and sweeps at least
30 degrees meanwhile, in the frames of hole and string. In a hole known to be inclined, or where the mark precesses at
less than 1/24 of the rotation, the sweep must be 90 degrees: a string that settles at another place, as a string that
friction pushes up the low side, sweeps less. The threshold is 5 % of the clearance, or 4.5 times the noise that is left
after averaging over at most half a revolution, if the noise gives more. The reported time is the time at which the
radius first crossed 5 %, found backwards (`threshold_crossing`).

A radius that has not swept 30 degrees in six revolutions is a changed offset or bow: the separation is restarted, and
so is the detection. A displaced string that begins to precess within these six revolutions has whirled since it was
displaced; so has a string that stays displaced and sweeps 30 degrees about its former position within 28 revolutions,
or until another mark is detected. Until a mark itself has turned by six revolutions its steady position is not known:
in an inclined hole the string falls to the low side, and far down a well a mark stands for many turns of the top drive,
then climbs the wall by the friction angle. A radius that crosses before must sweep the angle about the hole's axis. In
a hole known to be inclined, motion in the first two revolutions is the fall.

False alarms: white noise of standard deviation s per axis (after averaging) is above 4.5 s with probability
exp(-4.5^2 / 2) = 4e-5, and must be so in each of the two or more independent averages of a revolution, which gives less
than 1e-8 per revolution and mark: one in a year for four marks at 2 rev/s. `test/whirl/test_steady.py` checks for none
in as many revolutions as four marks make in a day, with noise of 5 % of the clearance. Noise that is not white over a
revolution (slow drift of a camera) is not covered.

The noise is measured on the bins: their third difference, demodulated with the precession, suppresses any steady or
growing orbit and amplifies white noise 20 times in power (binomial weights 1, -3, 3, -1). The radius of the
asynchronous part is averaged as far as the noise requires.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.compile.jit import any_of, strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import ASYNCHRONOUS, CAPACITY, bins_in, end_of
from drill_twin.whirl.onset.plane_swing import keeps_to_low_side, swing_radius, swings
from drill_twin.whirl.sample_bins import BINS

GAIN = 20.0
"""Power gain of a third difference on white noise: the sum of the squares of its weights, 1 + 9 + 9 + 1."""
MEMORY = 64
"""Memory of the noise [bins], four revolutions; chosen, not measured."""
UNSURE = math.sqrt(2.0 * criteria.FALSE_ALARM_FACTOR / math.sqrt(MEMORY))
"""Radius of a swing, over the noise, that the power of noise alone reaches: of n bins it scatters by 1 / sqrt(n)."""
OUTLIER = 16.0
"""Largest power of a single difference, over the present estimate: four standard deviations; chosen, not measured."""


@strict_kernel
def is_converged(averaged: Columns) -> bool:
    """Check that the noise has seen enough bins."""
    return bool(averaged.noise_bins[0] >= MEMORY // 4)


@strict_kernel
def update_noise(averaged: Columns, vector: ComplexArray, whirling: Mask) -> None:
    """Update the noise with the newest four bins over the clearance, demodulated, shape (4, m).

    Marks that whirl keep their estimate, since irregular motion is not noise.
    """
    converged = is_converged(averaged)
    averaged.noise_bins[0] = min(averaged.noise_bins[0] + 1, MEMORY)
    for k in range(whirling.size):
        first, second, third, last = vector[0, k], vector[1, k], vector[2, k], vector[3, k]
        across = last.real - 3.0 * third.real + 3.0 * second.real - first.real  # coefficients of a third difference
        up = last.imag - 3.0 * third.imag + 3.0 * second.imag - first.imag  # coefficients of the same
        power = (across * across + up * up) / (2.0 * GAIN)
        if converged:
            power = np.minimum(power, OUTLIER * averaged.power[k] + 1e-300)
        if not whirling[k]:
            averaged.power[k] += (power - averaged.power[k]) / averaged.noise_bins[0]
        averaged.level[k] = np.sqrt(averaged.power[k])


MOST_AVERAGED = BINS // 2
"""Most bins averaged: half a revolution, over which the precession is known well enough to turn bins back; chosen."""


def new_radius(clearance: Array) -> Columns:
    """Radius of each mark over the clearance, averaged over at most half a revolution, before the first bin."""
    return columns(
        "AveragedRadius",
        clearance.size,
        radius=0.0,  # over the clearance
        threshold=criteria.ONSET_RADIUS,  # of the radius
        release=criteria.ONSET_RADIUS,  # radius below which a candidate is dropped
        level=0.0,  # noise of a bin per axis over the clearance: its standard deviation
        power=0.0,  # square of the noise
        noise_bins=np.zeros(1, np.int64),  # bins that the noise has seen
        width=np.ones(1, np.int64),  # bins averaged
        clearance=clearance,  # [m]
        demodulated=np.zeros((MOST_AVERAGED, clearance.size), complex),  # work
    )


@strict_kernel
def average_radius(averaged: Columns, history: Columns, rate: Array, carrier: Array, whirling: Mask) -> None:
    """Average with the newest bin; `rate` of the asynchronous part, and of its `carrier` or 0 [rad/s], shape (m,)."""
    m, end = whirling.size, end_of(history)
    longest = min(MOST_AVERAGED, max(1, bins_in(history, 0.5)))
    bins = max(4, longest)  # a third difference needs four bins
    for i in range(bins):
        at = end - bins + i
        since = history.time[at] - history.time[end - 1]
        for k in range(m):
            angle = -(carrier[k] if carrier[k] != 0.0 else rate[k]) * since
            turned = history.vector[at, ASYNCHRONOUS, k] * complex(math.cos(angle), math.sin(angle))
            averaged.demodulated[i, k] = turned / averaged.clearance[k]
    update_noise(averaged, averaged.demodulated[bins - 4 : bins], whirling)
    level = averaged.level
    largest = level[0]
    for k in range(1, m):
        largest = np.maximum(largest, level[k])
    width = averaged.width[0] = width_for(largest, longest)
    for k in range(m):
        total, remaining = 0j, level[k] / math.sqrt(width)
        for i in range(bins - width, bins):
            total += averaged.demodulated[i, k]
        averaged.radius[k] = abs(total) / width
        averaged.threshold[k] = np.maximum(criteria.ONSET_RADIUS, criteria.FALSE_ALARM_FACTOR * remaining)
        averaged.release[k] = averaged.threshold[k] - remaining


@strict_kernel
def width_for(noise: float, longest: int) -> int:
    """Fewest bins, a power of 2 up to `longest`, that reduce the noise of a bin below the onset's threshold."""
    factor, radius = criteria.FALSE_ALARM_FACTOR, criteria.ONSET_RADIUS
    width = 1
    while width * 2 <= longest and noise * factor > radius * math.sqrt(width):
        width *= 2
    return width


INTERVAL = 4
"""Interval at which a displaced mark is checked [bins], to save time; chosen, not measured."""


def new_onsets(inclined: Mask) -> Columns:
    """State of the onsets of m marks before the first bin; `inclined`: whether the hole is inclined, shape (m,)."""
    return columns(
        "Onsets",
        inclined.size,
        began=math.nan,  # start of the present whirl, since the first sample [s]; nan without whirl
        detected=math.inf,  # its detection [rev]; inf without whirl
        active=False,  # in asynchronous whirl now
        time=math.nan,  # of a crossing of the threshold that is not confirmed, the candidate [s]; nan without one
        revolutions=math.nan,  # of the candidate [rev]
        noise=0.0,  # of a bin, at the candidate
        bin=0,  # number of the candidate's bin
        early=True,  # at the candidate the mark itself had turned too little for its steady position to be known
        displaced=False,  # has left its steady position
        falling=inclined.copy(),  # to the low side, in the first revolutions
        inclined=inclined,  # in an inclined hole
        plane=False,  # moves to and fro in a plane, or on the low side of an inclined hole
        swing=0.0,  # `swing_radius` over the clearance of a mark that swings; else 0
        small=False,  # the orbit has become small
        constant=False,  # it has swept no angle, or swings
        rest=np.zeros(CAPACITY, complex),  # work
    )


@strict_kernel
def watch(onsets: Columns, averaged: Columns, history: Columns) -> bool:
    """Check the newest bin for marks that begin to whirl; return whether `OnsetDetector.check` must decide."""
    m, now = onsets.began.size, history.revolutions[end_of(history) - 1]
    whirling = any_of(onsets.active)
    for k in range(m):
        if onsets.falling[k] and now > criteria.FALLING_TIME:
            return True
        if onsets.displaced[k] and (whirling or history.appended[0] % INTERVAL == 0):
            return True
        if math.isnan(onsets.time[k]) or averaged.radius[k] < averaged.release[k]:
            continue
        least = criteria.SWEEP_WINDOW if onsets.plane[k] else criteria.SUSTAIN  # a swing is dropped, not confirmed
        if math.isnan(onsets.began[k]) and not onsets.falling[k] and not now - onsets.revolutions[k] < least:
            return True
    for k in range(m):
        if math.isnan(onsets.began[k]) and not onsets.falling[k]:
            update_candidate(onsets, averaged, history, k)
    return False


@strict_kernel
def update_candidate(onsets: Columns, averaged: Columns, history: Columns, k: int) -> bool:
    """Start or drop the candidate of a mark; return whether the mark has a candidate that was not dropped."""
    if not (math.isnan(onsets.time[k]) or averaged.radius[k] < averaged.release[k]):
        return True
    newest = end_of(history) - 1
    onsets.time[k] = history.time[newest] if averaged.radius[k] > averaged.threshold[k] else math.nan
    onsets.revolutions[k] = history.revolutions[newest]
    onsets.noise[k], onsets.bin[k] = averaged.level[k], history.appended[0]
    onsets.early[k] = onsets.early[k] and abs(history.turned[k]) < math.tau * criteria.SEPARATION_MEMORY
    return False


@strict_kernel
def drop_candidates(onsets: Columns) -> None:
    """Forget what was seen before a gap."""
    onsets.time[:] = math.nan
    onsets.displaced[:] = False


@strict_kernel
def ends(
    onsets: Columns, averaged: Columns, orbit: Columns, history: Columns, arm: ComplexArray, carried: Array
) -> bool:
    """Find the orbits that have become `small` or `constant`; return whether `OnsetDetector.release` must decide.

    `arm` is that from the centre line to the marked points [m], and `carried` the rates of fast orbits [rad/s], which
    seen once a bin may pass for any motion; shapes (m,).
    """
    fall = criteria.RELEASE_RADIUS / criteria.ONSET_RADIUS
    bins, end, any_ends = bins_in(history, criteria.SWEEP_WINDOW), end_of(history), False
    first = end - bins
    side = bins_in(history, criteria.SIDE_WINDOW) // 2 * 2
    long = not history.revolutions[end - 1] - history.revolutions[first] < criteria.SWEEP_WINDOW - 0.5
    landed = long and history.revolutions[first] > criteria.FALLING_TIME
    for k in range(onsets.active.size):
        onsets.swing[k] = 0.0
        stays, noise = onsets.inclined[k] and keeps_to_low_side(history, arm[k], k, side), averaged.level[k]
        slow = abs(carried[k]) < criteria.DEFINITE_RATIO * math.tau * abs(orbit.rotation[0])
        noise_m = noise * averaged.clearance[k]
        onsets.plane[k] = slow and swings(history, arm[k], k, noise_m, stays, onsets.rest[:side])
        if landed and onsets.plane[k]:
            swing = swing_radius(history, arm[k], k, bins, 0) / averaged.clearance[k]
            swing = math.sqrt(max(swing * swing - 2.0 * noise * noise, 0.0))
            if swing > max(criteria.RELEASE_RADIUS, noise * UNSURE):
                onsets.swing[k] = swing
    if not any_of(onsets.active):
        return False
    for k in range(onsets.active.size):
        least = fall * averaged.threshold[k]
        onsets.small[k] = orbit.window_radius[k] < least or orbit.radius[0, k] < 0.5 * fall * averaged.threshold[k]
        swept = math.inf
        if long:
            low, high, low_in_string, high_in_string = math.inf, -math.inf, math.inf, -math.inf
            for i in range(first, end):
                angle = history.unwrapped[i, ASYNCHRONOUS, k]
                low, high = min(low, angle), max(high, angle)
                angle -= history.angle[i]
                low_in_string, high_in_string = min(low_in_string, angle), max(high_in_string, angle)
            swept = min(high - low, high_in_string - low_in_string)
        late = history.revolutions[first] > onsets.detected[k]
        onsets.constant[k] = late and (onsets.swing[k] > 0.0 or swept < criteria.LEAST_SWEPT_ANGLE)
        any_ends = any_ends or (onsets.active[k] and (onsets.small[k] or onsets.constant[k]))
    return any_ends
