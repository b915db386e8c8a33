# SPDX-License-Identifier: Apache-2.0
"""A string that swings to and fro in a plane, told from a string that whirls.

The motion of the centre line, without offset, drift and the part that turns with the string, is a sum of turns
exp(i omega t) with power P+ in one sense and P- in the other. The rotary coefficient |P+ - P-| / (P+ + P-) (Gonella
1972) is 1 for a circle, 0 for a swing in a plane, over an arc of the wall, or without order, and 2 p q / (p^2 + q^2)
for an ellipse of half axes p and q. Below `criteria.ROTARY` the motion is a swing, an ellipse less than 0.27 as wide as
long, where it also

* keeps to the low side of an inclined hole, or
* lies along one line: |sum z^2| / sum |z|^2 is 0 for a circle and (p^2 - q^2) / (p^2 + q^2) for an ellipse, 0.87 for
  the ellipse of that width. Motion without order has a small rotary coefficient too, and no direction. The drift counts
  here: a buckled string that vibrates in a plane, and turns slowly, whirls; or
* lies along an arc about the hole's axis, and comes back: its radius varies as little as the width of that ellipse, its
  angle makes no full turn and passes the middle of its range at least twice.

A swing as fast as the rotation loses its forward half to the part that turns with the string, and looks like a backward
circle: the motion is judged with that part as well. A whirl at -1 of the rotation beside a bow of its own size is the
same motion, and counts as a swing. Over so few revolutions a whirl near the rotation is not told from the part that
turns with the string on the low side, and is left out too.
"""

import math

from drill_twin.core.arrays import ComplexArray
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.history import end_of

FEWEST = 4
"""Fewest bins: offset, drift and the part that turns with the string are three numbers."""
LINE = math.sqrt(1.0 - criteria.ROTARY**2)
"""Least |sum z^2| / sum |z|^2 of a motion along a line, as of the ellipse at the bound of the rotary coefficient."""


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
def _along_arc(history: Columns, arm: complex, k: int, bins: int) -> bool:
    """Check that mark k has moved to and fro along an arc about the hole's axis."""
    end, low, high, angle = end_of(history), 0.0, 0.0, 0.0
    first = before = _centre(history, arm, k, end - bins)
    mean, radius, power = 0j, 0.0, 0.0
    for i in range(end - bins, end):
        centre = _centre(history, arm, k, i)
        step, before = centre * before.conjugate(), centre
        angle += math.atan2(step.imag, step.real)
        low, high = min(low, angle), max(high, angle)
        mean, radius, power = mean + centre / bins, radius + abs(centre) / bins, power + abs(centre - first) ** 2 / bins
    across, side, passages, angle, before = 0.0, 0.0, 0, 0.0, first
    for i in range(end - bins, end):
        centre = _centre(history, arm, k, i)
        across += (abs(centre) - radius) ** 2 / bins
        step, before = centre * before.conjugate(), centre
        angle += math.atan2(step.imag, step.real)
        beyond = angle - 0.5 * (low + high)
        if abs(beyond) > 0.25 * (high - low) and beyond * side <= 0.0:
            passages, side = passages + 1, beyond
    there_and_back = passages > 2 and high - low < math.tau
    return there_and_back and across < 0.5 * (1.0 - LINE) * (power - abs(mean - first) ** 2)


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
def swings(history: Columns, arm: complex, k: int, noise: float, low_side: bool, rest: ComplexArray) -> bool:
    """Check that mark k moves to and fro over as many of the newest bins as `rest`, work of even size, has.

    Args:
        history: The bins.
        arm: From the centre line to the marked point [m].
        k: Index of the mark.
        noise: Of a bin per axis [m].
        low_side: Whether the mark keeps to the low side of an inclined hole; along an arc it need not.
        rest: Work, of even size.
    """
    bins = rest.size
    if bins < FEWEST:
        return False
    first = end_of(history) - bins
    low_side = low_side or _along_arc(history, arm, k, bins)
    middle, offset, drift, synchronous = _fit(history, arm, k, first, first + bins)
    for kept in range(2):  # without and with the part that turns with the string
        mean, squares, power, moved = 0j, 0j, 0.0, 0.0
        for i in range(bins):
            turning = synchronous * history.phasor[first + i, k] if kept else 0j
            rest[i] = _rest(history, arm, k, first + i, (middle, offset, drift, synchronous)) + turning
            mean += rest[i] / bins
        for i in range(bins):
            rest[i] -= mean
            power += rest[i].real * rest[i].real + rest[i].imag * rest[i].imag
            place = rest[i] + drift * (history.time[first + i] - middle)
            squares += place * place
            moved += place.real * place.real + place.imag * place.imag
        if moved > 2.0 * power:
            continue  # it drifts farther than it swings
        along = power > 0.0 and abs(squares) > LINE * (moved - 2.0 * bins * noise * noise)
        if (along or (low_side and not kept)) and _rotary_coefficient(rest, power) < criteria.ROTARY:
            return True
    return False


@strict_kernel
def _rotary_coefficient(rest: ComplexArray, power: float) -> float:
    """Rotary coefficient, 0 to 1, of a motion of mean 0 over bins of even number, and the sum of its squares.

    P+ - P- is the power of the motion with its discrete Hilbert transform, whose kernel is a cotangent of odd lags.
    """
    bins, difference = rest.size, 0.0
    for lag in range(1, bins, 2):
        area = 0.0
        for i in range(lag, bins):
            area += rest[i].imag * rest[i - lag].real - rest[i].real * rest[i - lag].imag
        difference += 4.0 * area / math.tan(math.pi * lag / bins)  # formula of the discrete Hilbert transform
    return abs(difference) / (bins * power + 1e-300)


def to_and_fro(vector: ComplexArray) -> bool:
    """Check that a vector, shape (n,), moves along one line, and to both sides of 0: no whirl, as far as is seen."""
    power = float((vector.real**2 + vector.imag**2).sum())
    along = abs(complex((vector**2).sum())) > LINE * power
    return along and abs(complex(vector.sum())) ** 2 < 0.5 * vector.size * power
