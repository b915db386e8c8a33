# SPDX-License-Identifier: Apache-2.0
"""Severity of the motion that an analysis finds: acceleration of the marks from their positions, torsion of the bit.

The report takes the settled part of a recording, the analyzer node the last `WINDOW`; both by the functions here.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array
from drill_twin.core.severity import Bounds, Grade, grade
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.motion.stick_slip_index import REST

WINDOW = 5.0
"""Length of the window of the live severity [s]: some revolutions of the slowest drilling, 30 rpm; chosen."""
EVEN = 0.01
"""Largest difference of two steps of time, over their length, between which an acceleration is taken; stamps in whole
microseconds at 1 kHz are within it. Chosen, not measured."""
BACKWARDS = 0.05
"""Speed of the bit against the rotation, over the top drive's, from which it turns backwards; noise of a measured speed
is below it. Chosen, not measured."""


def accelerations(time: Array, values: ArrayLike) -> tuple[float, Array]:
    """Length of a step [s], NaN without samples, and second differences over its square, where two steps are even.

    Args:
        time: Times of T samples [s].
        values: Positions [m], real or complex, shape (T, ...).

    Returns:
        Of a sine of n samples a period the amplitude is too small by (sin(pi / n) / (pi / n))^2: 0.81 for 4, 0.97 for
        10 samples.
    """
    positions = np.asarray(values)
    if len(time) < 3:  # a second difference needs three samples: by its definition
        return math.nan, positions[:0]
    steps = np.diff(time)
    step = float(np.median(steps))
    even = np.abs(steps - step) <= EVEN * step
    return step, np.diff(positions, 2, axis=0)[even[1:] & even[:-1]] / step**2


def sizes(found: ArrayLike) -> tuple[float, float]:
    """Root mean square and largest size of the finite accelerations, shape (T,); NaN without any."""
    size = np.abs(found)
    known = size[np.isfinite(size)]
    return (math.sqrt(np.mean(known**2)), float(known.max())) if known.size else (math.nan, math.nan)


def turns_backwards(bit: ArrayLike, top: ArrayLike) -> Array:
    """Samples at which the bit turns against the rotation of the top drive, from their speeds [rad/s], shape (n,)."""
    bit, top = np.asarray(bit), np.asarray(top)
    return np.asarray((np.abs(top) > REST) & (bit * np.sign(top) < -BACKWARDS * np.abs(top)))


def torsion_grade(motion: BitMotion, index: float, bounds: Bounds, *, backwards: bool = False) -> Grade | None:
    """Grade of the rotation of the bit by its index; None while it is not known.

    A bit that stands while the top drive turns, or turned `backwards` in the time of its index, is severe; a free swing
    that dies away is none.
    """
    if motion is BitMotion.AT_REST or (motion is BitMotion.DECAYING and not backwards):
        return Grade.NONE
    if motion is BitMotion.STANDS or (backwards and math.isfinite(index)):
        return Grade.SEVERE
    return grade("stick_slip", index, bounds)
