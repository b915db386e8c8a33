# SPDX-License-Identifier: Apache-2.0
"""Kind of a lateral motion, from the centre line at marks: steady whirl, two frequencies, or irregular.

A steady whirl turns as a whole. A motion of two frequencies is periodic in a turning frame: z(t) = sum over k of
c_k exp(i (w1 + k (w2 - w1)) t), with complex amplitudes c_k at each mark. Both speeds are fitted by least squares, with
the amplitudes eliminated (variable projection; Golub and Pereyra 1973). A small second part is a modulation of the
whirl w1; where two parts of a string are on the wall, each may whirl at a speed of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from drill_twin.core.arrays import Array, ComplexArray

AXIS, STEADY, TWO, IRREGULAR = "on the axis", "steady whirl", "two frequencies", "irregular"
ON_AXIS = 0.5
"""Largest radius over the clearance of a string on the axis."""
CHANGE = 0.02
"""Largest change of the shape of a steady whirl, and largest misfit of two frequencies, over the clearance."""
HARMONICS = 8
ON_WALL = 0.3
"""Least mean radius over the clearance of a mark that has a whirl speed of its own."""


class Motion(NamedTuple):
    """A motion over some time."""

    kind: str
    """`AXIS`, `STEADY`, `TWO` or `IRREGULAR`."""
    speed: float
    """Mean whirl speed of the mark with the largest radius [rad/s]."""
    second: float
    """Second speed of a motion of two frequencies [rad/s]; NaN otherwise."""
    change: float
    """Root mean square of the motion in the frame of that whirl, the largest of the marks, over the clearance."""
    misfit: float
    """Root mean square of what two frequencies leave, the largest of the marks, over the clearance; NaN: not fitted."""
    radius: Array
    """Mean radius of the marks over the clearance, shape (m,)."""


def motion_of(line: ComplexArray, period: float, clearance: float) -> Motion:
    """Kind and speeds of a motion.

    Args:
        line: x + i y of the centre line at the marks [m], shape (T, m).
        period: Time between samples [s].
        clearance: Smallest clearance in the hole [m].
    """
    z = line / clearance
    radius: Array = np.abs(z).mean(axis=0)
    angle = np.unwrap(np.angle(z), axis=0)
    rates = (angle[-1] - angle[0]) / ((z.shape[0] - 1) * period)
    lead = int(np.argmax(radius))
    if float(np.abs(z).max()) < ON_AXIS:
        return Motion(AXIS, float(rates[lead]), math.nan, math.nan, math.nan, radius)
    change = _spread(z * np.exp(-1j * angle[:, lead])[:, None])
    steady = Motion(STEADY, float(rates[lead]), math.nan, change, math.nan, radius)
    if change < CHANGE:
        return steady
    apart = np.abs(rates - rates[lead]) * (radius > ON_WALL)
    second = float(rates[int(np.argmax(apart))])
    if abs(second - rates[lead]) * z.shape[0] * period < 2.0 * math.tau:  # all parts turn together: the shape pulsates
        frame = z * np.exp(-1j * angle[:, lead])[:, None]
        other = frame[:, int(np.argmax(np.std(frame, axis=0)))]
        lines = np.abs(np.fft.fft((other - other.mean()) * np.hanning(other.size)))
        at = np.fft.fftfreq(other.size, period)
        second = float(rates[lead] + math.tau * abs(at[int(np.argmax(lines))]))
    speed, second, misfit = _fit(z, period, float(rates[lead]), second)
    return steady._replace(kind=TWO if misfit < CHANGE else IRREGULAR, speed=speed, second=second, misfit=misfit)


def _spread(z: ComplexArray) -> float:
    return float(np.sqrt(np.mean(np.abs(z - z.mean(axis=0)) ** 2, axis=0)).max())


def _fit(z: ComplexArray, period: float, first: float, second: float) -> tuple[float, float, float]:
    """Two speeds [rad/s], and the misfit, from first guesses."""
    times, order = period * np.arange(z.shape[0]), np.arange(-HARMONICS, HARMONICS + 1)

    def misfit(speeds: Array) -> float:
        turn = np.exp(1j * np.outer(times, speeds[0] + order * (speeds[1] - speeds[0])))
        amplitudes = np.linalg.lstsq(turn, z, rcond=None)[0]
        left: float = np.sqrt(np.mean(np.abs(z - turn @ amplitudes) ** 2, axis=0)).max()
        return left

    width = 2.0 / times[-1]
    around = np.array([[first, second], [first + width, second], [first, second + width]])
    options = {"initial_simplex": around, "xatol": 1e-4, "fatol": 1e-5, "maxfev": 120}
    found = minimize(misfit, around[0], method="Nelder-Mead", options=options)
    return float(found.x[0]), float(found.x[1]), float(found.fun)
