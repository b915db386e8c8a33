# SPDX-License-Identifier: Apache-2.0
"""Carrier of a fast orbit: its rate from sample to sample, and its radius from samples turned back by that rate.

A string that rolls whirls at minus its radius over its clearance, -10 to -50 times the rotation for a stabiliser. A bin
of 1/16 revolution then contains whole turns of the orbit, and its mean position none of it. So the angle swept between
neighbouring samples, arg sum conj(a_i) a_i+1 of the asynchronous part a (a pulse-pair estimate: Zrnic 1979), gives the
rate of an orbit that is faster than the rotation; the samples of a bin are averaged in a frame that turns with this
rate, and what the plain mean has lost of the orbit is given back. An orbit slower than `ENGAGED` is left as it is: a
bin shortens it by less than 1 %.

A rate is known while two samples are less than 0.4 of a turn apart; beyond, neither its sense nor its pace is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.orbit.runout_separation import CALIBRATED_FROM, RunoutSeparation
from drill_twin.whirl.sample_bins import ANGLE, REVOLUTIONS, TIME, Bin

ENGAGED, RELEASED = 1.2, 1.0
"""Rate over the rotation from which an orbit has a carrier, and below which it has none any more."""
MEMORY = 2.0
"""Memory of the angle between samples [rev]."""
LEAST_RADIUS = 0.005
"""Smallest radius of an orbit with a carrier, over the clearance."""
COHERENCE, CERTAIN, MARGIN = 0.5, 0.9, 4.0
"""Smallest coherence of the angles between n samples: `MARGIN` / sqrt(n), which noise alone exceeds with probability
exp(-16), between the first two."""
WITHIN = 7.0
"""Largest difference of the rates from sample to sample and from bin to bin, over the rotation; bins tell it but for
multiples of 16."""
MIXED = 0.7
"""Share of the orbit left in the plain mean of a bin, below which a slow part is told from it."""


class Carrier(NamedTuple):
    """Carriers of m marks; sums over the samples of the present bin, and fading ones over the last revolutions."""

    rate: Array  # (m,) of the orbit [rad/s], right-handed about +z; 0 without a carrier
    carried: Array  # (m,) the rate in the last full bin [rad/s]
    interval: Array  # (m,) mean time between samples [s]; nan before the second
    samples: Array  # (m,) in a revolution; inf where not known
    definite: Array  # (m,) share of the ratios that the mark may have, which they show: 1 for definite findings
    hidden: Mask  # (m,) an orbit turns too far between samples for its rate to be known
    orbit: ComplexArray  # (m,) at the mean time of the last bin [m]; 0 without a carrier
    left: ComplexArray  # (m,) of it in the mean position of the bin [m], where that can be told from slow motion
    shift: ComplexArray  # (m,) what the mean position, without that, lacks of it [m]
    advance: ComplexArray  # (m,) fading sum of the orbits of two bins in a row, conj(A_j) A_j+1, turned back [m^2]
    last: ComplexArray  # (m,) asynchronous part at the last sample [m]
    seen: Array  # (m,) its time [s]; nan before the first
    pairs: ComplexArray  # (m,) fading sum of conj(a_i) a_i+1 turned back [m^2]
    sizes: Array  # (3, m) fading sums of |a_i a_i+1| [m^2], of intervals [s] and of 1
    bin_sums: ComplexArray  # (3, m) of a [m], of a turned back [m] and of the turn
    in_bin: Array  # (m,) samples
    clock: Array  # as `Bin.numbers`, of the last bin, and time of the first sample of the present one [s]
    clearance: Array  # (m,) [m]

    @classmethod
    def of(cls, clearance: Array) -> Carrier:
        """No carrier, before the first sample."""
        m = clearance.size
        orbit, left, shift, advance, last, pairs = np.zeros((6, m), complex)
        return cls(
            np.zeros(m), np.zeros(m), np.full(m, math.nan), np.full(m, math.inf), np.ones(m),
            np.zeros(m, bool), orbit, left, shift, advance, last, np.full(m, math.nan),
            pairs, np.zeros((3, m)), np.zeros((3, m), complex), np.zeros(m), np.array([0.0, 0.0, 0.0, math.nan]),
            clearance,
        )  # fmt: skip


@strict_kernel
def turn_by(angle: float) -> complex:
    """Unit vector at an angle [rad]."""
    return complex(math.cos(angle), math.sin(angle))


@strict_kernel
def follow(
    carrier: Carrier,
    separation: RunoutSeparation,
    time: float,
    position: ComplexArray,
    phasor: ComplexArray,
    seen: Mask,
) -> None:
    """Add a sample.

    Args:
        carrier: The carriers.
        separation: Offset and synchronous part.
        time: Time since the first sample [s].
        position: Position of the marked points [m], shape (m,).
        phasor: Unit vector of the spin, shape (m,).
        seen: Marks with a valid position, shape (m,).
    """
    if math.isnan(carrier.clock[3]):
        carrier.clock[3] = time
    for k in range(seen.size):
        if not seen[k] or not separation.determinant[k] > CALIBRATED_FROM:
            continue
        rate, part = carrier.rate[k], position[k] - separation.offset[k] - separation.synchronous[k] * phasor[k]
        since = time - carrier.seen[k]
        if since > 0.0:  # not after the first
            pair = carrier.last[k].conjugate() * part
            carrier.sizes[0, k] += abs(pair)
            carrier.sizes[1, k] += since
            carrier.sizes[2, k] += 1.0
            carrier.pairs[k] += pair if rate == 0.0 else pair * turn_by(-rate * since)
        carrier.last[k], carrier.seen[k] = part, time
        if rate != 0.0:
            turn = turn_by(-rate * (time - carrier.clock[3]))
            carrier.bin_sums[0, k] += part
            carrier.bin_sums[1, k] += part * turn
            carrier.bin_sums[2, k] += turn
            carrier.in_bin[k] += 1.0


@strict_kernel
def restore(carrier: Carrier, full: Bin, criteria: Criteria) -> None:
    """Find what the mean of a full bin lacks of the orbits, then the rates for the next."""
    clock, now = carrier.clock, full.numbers
    elapsed, seconds = now[REVOLUTIONS] - clock[REVOLUTIONS], now[TIME] - clock[TIME]
    slowest = math.tau * criteria.rest_rotation
    rotation = max(abs(now[ANGLE] - clock[ANGLE]) / seconds, slowest) if seconds > 0.0 else slowest
    fade = math.exp(-max(elapsed, criteria.rest_rotation * seconds) / MEMORY)
    for k in range(carrier.rate.size):
        carrier.carried[k] = carrier.rate[k]
        before = carrier.orbit[k]
        apart = _find_orbit(carrier, k, now[TIME] - clock[3])
        if apart and before != 0.0:
            carrier.advance[k] += before.conjugate() * carrier.orbit[k] * turn_by(-carrier.rate[k] * seconds)
        else:
            carrier.advance[k] = 0.0
        _update_rate(carrier, k, rotation, seconds, criteria)
        carrier.advance[k] *= fade
        carrier.pairs[k] *= fade
        for row in range(3):
            carrier.sizes[row, k] *= fade
    for k in range(3):
        clock[k] = now[k]
    clock[3] = math.nan


@strict_kernel
def _find_orbit(carrier: Carrier, k: int, middle: float) -> bool:
    """Find the orbit at the mean time of the bin, `middle` after its first sample [s]; tell if slow motion is apart."""
    n, sums = carrier.in_bin[k], carrier.bin_sums
    mean, turned, share = 0j, 0j, 0j
    if n > 1.0:
        turn = turn_by(carrier.rate[k] * middle)
        mean, turned, share = sums[0, k] / n, sums[1, k] * turn / n, (sums[2, k] * turn / n).conjugate()
    carrier.in_bin[k] = sums[0, k] = sums[1, k] = sums[2, k] = 0.0
    # mean = slow + share orbit, turned = orbit + conj(share) slow
    power = share.real * share.real + share.imag * share.imag
    apart = n > 1.0 and power < MIXED * MIXED
    orbit = (turned - share.conjugate() * mean) / (1.0 - power) if apart else turned
    carrier.orbit[k] = orbit
    carrier.left[k] = share * orbit if apart else 0j
    carrier.shift[k] = orbit if apart else orbit - share * orbit
    return apart


@strict_kernel
def _update_rate(carrier: Carrier, k: int, rotation: float, seconds: float, criteria: Criteria) -> None:
    """Estimate the rate of the orbit of a mark, at a rotation [rad/s], with a bin `seconds` after the one before.

    The angle between samples tells it within some turns of the string; slow motion beside the orbit makes it too small.
    From bin to bin the orbit is free of slow motion.
    """
    before, pair, (size, intervals, count) = carrier.rate[k], carrier.pairs[k], carrier.sizes[:, k]
    carrier.hidden[k] = False
    if count < 1.0 or size <= 0.0:
        carrier.rate[k] = 0.0
        return
    interval = carrier.interval[k] = intervals / count
    rate = before + math.atan2(pair.imag, pair.real) / interval
    coherence = abs(pair) / size
    radius = math.sqrt(size / count) / carrier.clearance[k]
    least = min(max(COHERENCE, MARGIN / math.sqrt(count)), CERTAIN)
    orbits = radius > LEAST_RADIUS and coherence > least
    fast = abs(rate) > (ENGAGED if before == 0.0 else RELEASED) * rotation
    if orbits and abs(rate) * interval > math.tau / criteria.fewest_in_orbit:
        carrier.hidden[k] = radius > criteria.release_radius
        fast = False
    advance = carrier.advance[k]
    if advance != 0.0:
        finer = before + math.atan2(advance.imag, advance.real) / seconds
        if abs(finer - rate) < WITHIN * rotation:
            rate = finer
            carrier.advance[k] = abs(advance)
        else:
            carrier.advance[k] = 0.0
    carrier.rate[k] = rate if orbits and fast else 0.0
    carrier.pairs[k] = pair * turn_by((before - carrier.rate[k]) * interval)


@strict_kernel
def judge(carrier: Carrier, seen: Mask, rotation: float, rolling_ratio: Array, criteria: Criteria) -> None:
    """Judge what the samples show.

    Args:
        carrier: The carriers.
        seen: Marks that were seen, shape (m,); not those with an orbit that is too fast for the samples.
        rotation: Rotation [rev/s].
        rolling_ratio: Whirl ratio in pure rolling, shape (m,).
        criteria: Thresholds.
    """
    for k in range(seen.size):
        seen[k] = seen[k] and not carrier.hidden[k]
        turned = carrier.interval[k] * abs(rotation)
        carrier.samples[k] = 1.0 / turned if turned > 0.0 else math.inf
        needed = criteria.needed_in_orbit * max(criteria.definite_ratio, abs(rolling_ratio[k]))
        carrier.definite[k] = min(1.0, carrier.samples[k] / needed)
