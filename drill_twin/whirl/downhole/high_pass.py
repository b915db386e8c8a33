# SPDX-License-Identifier: Apache-2.0
"""Position from lateral acceleration: integrated twice, less a drift that is estimated with it.

The drift is the fourth integral of white noise, the motion that remains is white noise about zero; a Kalman filter
separates them. Once its gain has settled, it is a Butterworth high pass of fourth order: with q and r the densities of
the two, the corner is (q / r)^(1/8). It begins without any knowledge of position, velocity and mean acceleration, as of
a string that moves already, so that what the filter does not know yet appears as too small a
motion, never as too large a motion.
"""

import math
from typing import NamedTuple

import numpy as np

from drill_twin.whirl import criteria

GRAVITY = 9.81
"""Gravity that tilt turns into lateral force, in the estimate of the noise [m/s^2]: 9.80665 (CGPM 1901), rounded."""
UNKNOWN = 1e8
"""Variance of the state before the first interval, over the variance of the motion: a deviation of 10^4 times the
motion; chosen, not measured."""
SETTLED = 1e-12
"""Largest relative change of a gain that has settled; chosen, not measured."""
_NOISE_GAIN = 1.0 / (8.0 * math.sin(3.0 * math.pi / 8.0))  # integral of x^4 / (1 + x^8) over all x, by 2 pi
_STEP = np.array([[1.0, 1.0, 0.5, 1.0 / 6.0], [0.0, 1.0, 1.0, 0.5], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]])
"""Taylor expansion of position and its first three derivatives over an interval of length 1."""


class ToolNoise(NamedTuple):
    """Noise of the instruments of a sub: standard deviation of a sample."""

    force: float
    """Of the accelerometers [m/s^2]."""
    rate: float
    """Of the gyroscopes [rad/s]."""


def corner_for(clearance: float, noise: ToolNoise, interval: float) -> float:
    """Lowest corner at which the noise of the position stays below the threshold of an onset [rad/s].

    The variance of the position is k S_f / a^3 + k g^2 S_w / a^5 on each axis, with S = sigma^2 T of accelerometers and
    gyroscopes, the corner a and k = 1 / (8 sin(3 pi / 8)): the integrals of the spectra behind the high pass.

    Args:
        clearance: Lateral clearance of the section [m].
        noise: Noise of the instruments.
        interval: Time between samples T [s].
    """
    allowed = (criteria.ONSET_RADIUS * clearance / criteria.FALSE_ALARM_FACTOR) ** 2
    force, tilt = (_NOISE_GAIN * interval * part**2 / allowed for part in (noise.force, GRAVITY * noise.rate))
    roots = np.roots([1.0, 0.0, 0.0, -force, 0.0, -tilt])  # one is positive (Descartes)
    return float(max(roots.real[np.abs(roots.imag) <= 1e-9 * np.abs(roots)]))


class HighPass:
    """Integral of the integral of means over intervals, at their ends, less its drift."""

    def __init__(self, corner: float, interval: float) -> None:
        """Begin without knowledge; corner [rad/s], interval [s]."""
        self._square = interval**2
        angle = corner * interval
        self._driven = angle**8  # (q / r)^(1/8) is the corner, by the formula above
        self._covariance = UNKNOWN * np.diag(angle ** np.array([0.0, 2.0, 4.0, 6.0]))
        self._gain = (0.0, 0.0, 0.0, 0.0)
        self._settled = False
        self._state = 0j, 0j, 0j, 0j  # position and its first three differences in an interval [m]

    def __call__(self, acceleration: complex) -> complex:
        """Position [m] after one more mean [m/s^2]."""
        if not self._settled:
            self._update_gain()
        position, velocity, mean, rate = self._state
        pushed = acceleration * self._square + mean
        position += velocity + 0.5 * pushed + rate / 6.0  # Taylor expansion, as `_STEP`
        one, two, three, four = self._gain
        self._state = (
            (1.0 - one) * position,
            velocity + pushed + 0.5 * rate - two * position,  # Taylor expansion
            mean + rate - three * position,
            rate - four * position,
        )
        return self._state[0]

    def _update_gain(self) -> None:
        """Gain for the next interval, of a measurement of zero with unit variance."""
        before = _STEP @ self._covariance @ _STEP.T
        before[3, 3] += self._driven
        gain = before[:, 0] / (before[0, 0] + 1.0)
        after = before - np.outer(gain, before[0])
        self._covariance = 0.5 * (after + after.T)  # mean of both, so that round-off leaves it symmetric
        one, two, three, four = gain.tolist()
        last, self._gain = self._gain, (one, two, three, four)
        self._settled = all(abs(a - b) <= SETTLED * b for a, b in zip(last, self._gain, strict=True))
