# SPDX-License-Identifier: Apache-2.0
"""A string that swings on the low side of an inclined hole, told from one that whirls there.

Both may move far, and neither goes round the hole. The asynchronous motion, a sum of turns exp(i omega t), has power P+
in the sense of rotation and P- against it. The rotary coefficient |P+ - P-| / (P+ + P-) (Gonella 1972) is 1 for a
circle, 0 for a swing in a plane, over an arc of the wall, or without order, and 2 p q / (p^2 + q^2) for an ellipse of
half axes p and q. A motion that stays on one side of the hole, with a coefficient below `Criteria.rotary`, is a swing:
an ellipse less than 0.27 as wide as long. Over a few revolutions a whirl near the rotation is not told from the
synchronous part, and is left out with it.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import ComplexArray
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.history import ASYNCHRONOUS, PHASOR, POSITION, History, end_of
from drill_twin.whirl.sample_bins import TIME


@strict_kernel
def keeps_to_one_side(history: History, arm: complex, k: int, bins: int) -> bool:
    """Check that the centre line at mark k has stayed within 90 degrees of its mean direction over the newest bins."""
    end, mean = end_of(history), 0j
    for i in range(end - bins, end):
        mean += history.complex_part[i, POSITION, k] - arm * history.complex_part[i, PHASOR, k]
    for i in range(end - bins, end):
        centre = history.complex_part[i, POSITION, k] - arm * history.complex_part[i, PHASOR, k]
        if not centre.real * mean.real + centre.imag * mean.imag > 0.0:
            return False
    return True


@strict_kernel
def swing_radius(history: History, k: int, bins: int, newer: int) -> float:
    """Rms radius [m] of the asynchronous part of mark k about a straight drift, as of a string that settles.

    Over so many bins before the newest `newer` ones.
    """
    end = end_of(history) - newer
    time, mean, middle, spread = history.clock[:, TIME], 0j, 0.0, 1e-300
    for i in range(end - bins, end):
        mean += history.complex_part[i, ASYNCHRONOUS, k] / bins
        middle += time[i] / bins
    drift, power = 0j, 0.0
    for i in range(end - bins, end):
        moved, since = history.complex_part[i, ASYNCHRONOUS, k] - mean, time[i] - middle
        drift += since * moved
        spread += since * since
        power += moved.real * moved.real + moved.imag * moved.imag
    left = power - (drift.real * drift.real + drift.imag * drift.imag) / spread
    return math.sqrt(max(left, 0.0) / bins)


def rotary_coefficient(centre: ComplexArray, phasor: ComplexArray) -> float:
    """Rotary coefficient of a mark, 0 to 1, without the offset and the synchronous part that fit its motion best.

    Args:
        centre: Centre line in successive bins [m].
        phasor: Unit vector of the spin in them.
    """
    parts = np.stack((np.ones_like(phasor), phasor), axis=1)
    rest = centre - parts @ np.linalg.lstsq(parts, centre, rcond=None)[0]
    power = np.abs(np.fft.fft(rest)[1:]) ** 2
    forward = power[: rest.size // 2]
    return float(abs(2.0 * forward.sum() - power.sum()) / (power.sum() + 1e-300))
