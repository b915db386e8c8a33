# SPDX-License-Identifier: Apache-2.0
"""Carrier of a fast orbit: its rate from sample to sample, and its radius from samples turned back by that rate.

A string that rolls whirls at minus its radius over its clearance, -10 to -50 times the rotation for a stabiliser. A bin
of 1/16 revolution then contains whole turns of the orbit, and its mean position none of it. So the angle swept between
neighbouring samples, arg sum conj(a_i) a_i+1 of the asynchronous part a (a pulse-pair estimate: Zrnic 1979), gives the
rate of an orbit that is faster than the rotation; the samples of a bin are averaged in a frame that turns with this
rate, and what the plain mean has lost of the orbit is given back. An orbit slower than `ENGAGED` is left as it is: a
bin shortens it by less than 1 %.

A rate is known while two samples are less than 0.4 of a turn apart; farther apart, neither sense nor pace is known.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.orbit.runout_separation import CALIBRATED_FROM

ENGAGED, RELEASED = 1.2, 1.0
"""Rate over the rotation from which an orbit has a carrier, and below which it has none any more: up to 1.2 a bin
shortens the orbit by less than 1 %, 1 - sinc(1.2 / 16)."""
MEMORY = 2.0
"""Memory of the angle between samples [rev]; chosen, not measured."""
LEAST_RADIUS = 0.005
"""Smallest radius of an orbit with a carrier, over the clearance: a tenth of `criteria.ONSET_RADIUS`; chosen."""
COHERENCE, CERTAIN, MARGIN = 0.5, 0.9, 4.0
"""Smallest coherence of the angles between n samples: `MARGIN` / sqrt(n), which noise alone exceeds with probability
exp(-16), between the first two."""
WITHIN = 7.0
"""Largest difference of the rates from sample to sample and from bin to bin, over the rotation: bins tell the rate but
for multiples of 16, so half of 16 less a margin."""
MIXED = 0.7
"""Share of the orbit left in the plain mean of a bin, below which a slow part is told from the orbit; chosen."""


def new_carrier(clearance: Array) -> Columns:
    """Carriers of m marks: none, before the first sample.

    There are sums over the samples of the present bin, and fading ones over the last revolutions.
    """
    return columns(
        "Carrier",
        clearance.size,
        rate=0.0,  # of the orbit [rad/s], right-handed about +z; 0 without a carrier
        carried=0.0,  # the rate in the last full bin [rad/s]
        interval=math.nan,  # mean time between samples [s]; nan before the second
        samples=math.inf,  # in a revolution; inf where not known
        definite=1.0,  # share of the ratios that the mark may have, which they show: 1 for definite findings
        hidden=False,  # an orbit turns too far between samples for its rate to be known
        orbit=0j,  # at the mean time of the last bin [m]; 0 without a carrier
        left=0j,  # share of the orbit in the mean position of the bin [m], where it can be told from slow motion
        shift=0j,  # part of the orbit that the mean position, without `left`, lacks [m]
        advance=0j,  # fading sum of the orbits of two bins in a row, conj(A_j) A_j+1, turned back [m^2]
        last=0j,  # asynchronous part at the last sample [m]
        seen=math.nan,  # time of the last sample [s]; nan before the first
        pairs=0j,  # fading sum of conj(a_i) a_i+1 turned back [m^2]
        lengths=0.0,  # fading sum of |a_i a_i+1| [m^2]
        intervals=0.0,  # fading sum of the intervals between samples [s]
        count=0.0,  # fading number of the intervals
        plain=0j,  # sum of a over the bin [m]
        turned=0j,  # sum of a turned back over the bin [m]
        turns=0j,  # sum of the turns back over the bin
        in_bin=0.0,  # samples
        begin=np.full(1, math.nan),  # time of the first sample of the present bin [s]
        clearance=clearance,  # [m]
    )


@strict_kernel
def turn_by(angle: float) -> complex:
    """Unit vector at an angle [rad]."""
    return complex(math.cos(angle), math.sin(angle))


@strict_kernel
def follow(
    carrier: Columns,
    separation: Columns,
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
    if math.isnan(carrier.begin[0]):
        carrier.begin[0] = time
    for k in range(seen.size):
        if not seen[k] or not separation.determinant[k] > CALIBRATED_FROM:
            continue
        rate, part = carrier.rate[k], position[k] - separation.offset[k] - separation.synchronous[k] * phasor[k]
        since = time - carrier.seen[k]
        if since > 0.0:  # not after the first
            pair = carrier.last[k].conjugate() * part
            carrier.lengths[k] += abs(pair)
            carrier.intervals[k] += since
            carrier.count[k] += 1.0
            carrier.pairs[k] += pair if rate == 0.0 else pair * turn_by(-rate * since)
        carrier.last[k], carrier.seen[k] = part, time
        if rate != 0.0:
            turn = turn_by(-rate * (time - carrier.begin[0]))
            carrier.plain[k] += part
            carrier.turned[k] += part * turn
            carrier.turns[k] += turn
            carrier.in_bin[k] += 1.0


@strict_kernel
def restore(carrier: Columns, full: Columns) -> None:
    """Find what the mean of a full bin lacks of the orbits, then the rates for the next."""
    seconds, slowest = full.seconds[0], math.tau * criteria.REST_ROTATION
    rotation = max(abs(full.turned[0]) / seconds, slowest) if seconds > 0.0 else slowest
    fade = math.exp(-max(full.elapsed[0], criteria.REST_ROTATION * seconds) / MEMORY)
    for k in range(carrier.rate.size):
        carrier.carried[k] = carrier.rate[k]
        before = carrier.orbit[k]
        apart = _find_orbit(carrier, k, full.time[0] - carrier.begin[0])
        if apart and before != 0.0:
            carrier.advance[k] += before.conjugate() * carrier.orbit[k] * turn_by(-carrier.rate[k] * seconds)
        else:
            carrier.advance[k] = 0.0
        _update_rate(carrier, k, rotation, seconds)
        carrier.advance[k] *= fade
        carrier.pairs[k] *= fade
        carrier.lengths[k] *= fade
        carrier.intervals[k] *= fade
        carrier.count[k] *= fade
    carrier.begin[0] = math.nan


@strict_kernel
def _find_orbit(carrier: Columns, k: int, middle: float) -> bool:
    """Find the orbit at the mean time of the bin, `middle` after its first sample [s]; tell if slow motion is apart."""
    n = carrier.in_bin[k]
    mean, turned, share = 0j, 0j, 0j
    if n > 1.0:
        turn = turn_by(carrier.rate[k] * middle)
        mean, turned = carrier.plain[k] / n, carrier.turned[k] * turn / n
        share = (carrier.turns[k] * turn / n).conjugate()
    carrier.in_bin[k] = carrier.plain[k] = carrier.turned[k] = carrier.turns[k] = 0.0
    # mean = slow + share orbit, turned = orbit + conj(share) slow
    power = share.real * share.real + share.imag * share.imag
    apart = n > 1.0 and power < MIXED * MIXED
    orbit = (turned - share.conjugate() * mean) / (1.0 - power) if apart else turned
    carrier.orbit[k] = orbit
    carrier.left[k] = share * orbit if apart else 0j
    carrier.shift[k] = orbit if apart else orbit - share * orbit
    return bool(apart)


@strict_kernel
def _update_rate(carrier: Columns, k: int, rotation: float, seconds: float) -> None:
    """Estimate the rate of the orbit of a mark, at a rotation [rad/s], with a bin `seconds` after the bin before.

    The angle between samples tells it within some turns of the string; slow motion beside the orbit makes it too small.
    From bin to bin the orbit is free of slow motion.
    """
    before, pair, size, count = carrier.rate[k], carrier.pairs[k], carrier.lengths[k], carrier.count[k]
    carrier.hidden[k] = False
    if count < 1.0 or size <= 0.0:
        carrier.rate[k] = 0.0
        return
    interval = carrier.interval[k] = carrier.intervals[k] / count
    rate = before + math.atan2(pair.imag, pair.real) / interval
    coherence = abs(pair) / size
    radius = math.sqrt(size / count) / carrier.clearance[k]
    least = min(max(COHERENCE, MARGIN / math.sqrt(count)), CERTAIN)
    orbits = radius > LEAST_RADIUS and coherence > least
    fast = abs(rate) > (ENGAGED if before == 0.0 else RELEASED) * rotation
    if orbits and abs(rate) * interval > math.tau / criteria.FEWEST_IN_ORBIT:
        carrier.hidden[k] = radius > criteria.RELEASE_RADIUS
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
def judge(carrier: Columns, seen: Mask, rotation: float, rolling_ratio: Array) -> None:
    """Judge what the samples show.

    Args:
        carrier: The carriers.
        seen: Marks that were seen, shape (m,); a mark whose orbit is too fast for the samples is taken out.
        rotation: Rotation [rev/s].
        rolling_ratio: Whirl ratio in pure rolling, shape (m,).
    """
    for k in range(seen.size):
        seen[k] = seen[k] and not carrier.hidden[k]
        turned = carrier.interval[k] * abs(rotation)
        carrier.samples[k] = 1.0 / turned if turned > 0.0 else math.inf
        needed = criteria.NEEDED_IN_ORBIT * max(criteria.DEFINITE_RATIO, abs(rolling_ratio[k]))
        carrier.definite[k] = min(1.0, carrier.samples[k] / needed)
