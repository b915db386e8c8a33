# SPDX-License-Identifier: Apache-2.0
"""Estimate of the measurement noise of the bins.

The third difference of bins, demodulated with the precession, suppresses any steady or growing orbit and amplifies
white noise 20 times in power (binomial weights 1, -3, 3, -1).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel

GAIN = 20.0
"""Power gain of a third difference on white noise."""
MEMORY = 64
"""Memory [bins]."""
OUTLIER = 16.0
"""Largest power of a single difference, over the present estimate."""


class Noise(NamedTuple):
    """Noise of a bin per axis over the clearance, of m marks."""

    level: Array  # (m,) standard deviation
    power: Array  # (m,)
    bins: Integers  # (1,)

    @classmethod
    def of(cls, m: int) -> Noise:
        """Noise before the first bin."""
        return cls(np.zeros(m), np.zeros(m), np.zeros(1, np.int64))

    @property
    def converged(self) -> bool:
        """True after enough bins."""
        return bool(self.bins[0] >= MEMORY // 4)


@strict_kernel
def update_noise(noise: Noise, vector: ComplexArray, whirling: Mask) -> None:
    """Add the newest four bins over the clearance, demodulated with the precession, shape (4, m).

    Marks that whirl keep their estimate, since irregular motion is not noise.
    """
    converged = noise.bins[0] >= MEMORY // 4
    noise.bins[0] = min(noise.bins[0] + 1, MEMORY)
    for k in range(whirling.size):
        first, second, third, last = vector[0, k], vector[1, k], vector[2, k], vector[3, k]
        across = last.real - 3.0 * third.real + 3.0 * second.real - first.real
        up = last.imag - 3.0 * third.imag + 3.0 * second.imag - first.imag
        power = (across * across + up * up) / (2.0 * GAIN)
        if converged:
            power = np.minimum(power, OUTLIER * noise.power[k] + 1e-300)
        if not whirling[k]:
            noise.power[k] += (power - noise.power[k]) / noise.bins[0]
        noise.level[k] = np.sqrt(noise.power[k])
