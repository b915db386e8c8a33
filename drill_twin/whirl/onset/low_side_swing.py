# SPDX-License-Identifier: Apache-2.0
"""A string that swings on the low side of an inclined hole, told from a string that whirls there.

Both may move far, and neither goes round the hole. The motion of the centre line, without offset, drift and the part
that turns with the string, is a sum of turns exp(i omega t) with power P+ in one sense and P- in the other. The rotary
coefficient |P+ - P-| / (P+ + P-) (Gonella 1972) is 1 for a circle, 0 for a swing in a plane, over an arc of the wall,
or without order, and 2 p q / (p^2 + q^2) for an ellipse of half axes p and q. A motion that stays on the low side, with
a coefficient below `criteria.ROTARY`, is a swing: an ellipse less than 0.27 as wide as long. Over so few revolutions a
whirl near the rotation is not told from the part that turns with the string, and is left out too.
"""

from __future__ import annotations

import math

from drill_twin.core.arrays import ComplexArray
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import end_of


@strict_kernel
def _centre(history: Columns, arm: complex, k: int, i: int) -> complex:
    """Centre line at mark k [m]."""
    return complex(history.position[i, k] - arm * history.phasor[i, k])


@strict_kernel
def keeps_to_low_side(history: Columns, arm: complex, k: int, bins: int) -> bool:
    """Check that mark k has stayed within 90 degrees of its mean direction, which is on the low side, +x."""
    end, mean = end_of(history), 0j
    for i in range(end - bins, end):
        mean += _centre(history, arm, k, i)
    for i in range(end - bins, end):
        centre = _centre(history, arm, k, i)
        if not centre.real * mean.real + centre.imag * mean.imag > 0.0:
            return False
    return mean.real > 0.0


@strict_kernel
def _fit(history: Columns, arm: complex, k: int, first: int, end: int) -> tuple[float, complex, complex, complex]:
    """Mean time [s], offset [m], drift [m/s] and part that turns with the string [m] that fit the bins best."""
    n, middle, spread, mean, mean_turn, drift, turn = end - first, 0.0, 1e-300, 0j, 0j, 0j, 0j
    for i in range(first, end):
        middle += history.time[i] / n
        mean += _centre(history, arm, k, i) / n
        mean_turn += history.phasor[i, k] / n
    for i in range(first, end):
        since = history.time[i] - middle
        spread += since * since
        drift += since * _centre(history, arm, k, i)
        turn += since * history.phasor[i, k]
    drift, turn = drift / spread, turn / spread
    both, size = 0j, 1e-9 * n
    for i in range(first, end):
        since = history.time[i] - middle
        phasor = history.phasor[i, k] - mean_turn - turn * since
        both += (_centre(history, arm, k, i) - mean - drift * since) * phasor.conjugate()
        size += phasor.real * phasor.real + phasor.imag * phasor.imag
    synchronous = both / size
    return middle, mean - synchronous * mean_turn, drift - synchronous * turn, synchronous


@strict_kernel
def _rest(history: Columns, arm: complex, k: int, i: int, fit: tuple[float, complex, complex, complex]) -> complex:
    """Motion in a bin beside the fit [m]."""
    middle, offset, drift, synchronous = fit
    since = history.time[i] - middle
    return complex(_centre(history, arm, k, i) - offset - drift * since - synchronous * history.phasor[i, k])


@strict_kernel
def swing_radius(history: Columns, arm: complex, k: int, bins: int, newer: int) -> float:
    """Rms radius [m] of the motion of mark k over so many bins before the newest `newer`."""
    end, power = end_of(history) - newer, 0.0
    fit = _fit(history, arm, k, end - bins, end)
    for i in range(end - bins, end):
        rest = _rest(history, arm, k, i, fit)
        power += (rest.real * rest.real + rest.imag * rest.imag) / bins
    return math.sqrt(power)


@strict_kernel
def rotary_coefficient(history: Columns, arm: complex, k: int, rest: ComplexArray) -> float:
    """Rotary coefficient of mark k over as many of the newest bins as `rest`, work of even size, has; 0 to 1.

    P+ - P- is the power of the motion with its discrete Hilbert transform, whose kernel is a cotangent of odd lags.
    """
    bins = rest.size
    first = end_of(history) - bins
    fit = _fit(history, arm, k, first, first + bins)
    mean, total, difference = 0j, 1e-300, 0.0
    for i in range(bins):
        rest[i] = _rest(history, arm, k, first + i, fit)
        mean += rest[i]
        total += bins * (rest[i].real * rest[i].real + rest[i].imag * rest[i].imag)
    for lag in range(1, bins, 2):
        area = 0.0
        for i in range(lag, bins):
            area += rest[i].imag * rest[i - lag].real - rest[i].real * rest[i - lag].imag
        difference += 4.0 * area / math.tan(math.pi * lag / bins)
    return abs(difference) / (total - mean.real * mean.real - mean.imag * mean.imag)
