# SPDX-License-Identifier: Apache-2.0
"""Estimate of the measurement noise of the bins.

The third difference of bins, demodulated with the precession, suppresses any steady or growing orbit and amplifies
white noise 20 times in power (binomial weights 1, -3, 3, -1).
"""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import ComplexArray, Mask

GAIN = 20.0
"""Power gain of a third difference on white noise."""
MEMORY = 64
"""Memory [bins]."""
OUTLIER = 16.0
"""Largest power of a single difference, over the present estimate."""


class Noise:
    """Noise of a bin per axis, over the clearance, shape (m,)."""

    def __init__(self, marks: int) -> None:
        self._power = np.zeros(marks)
        self._count = 0
        self.level = np.zeros(marks)
        """Standard deviation per axis over the clearance."""

    @property
    def converged(self) -> bool:
        """True after enough bins."""
        return self._count >= MEMORY // 4

    def update(self, vector: ComplexArray, whirling: Mask) -> None:
        """Add the newest four bins over the clearance, demodulated with the precession, shape (4, m).

        Marks that whirl keep their estimate, since irregular motion is not noise.
        """
        difference = vector[3] - 3.0 * vector[2] + 3.0 * vector[1] - vector[0]
        power = (difference.real**2 + difference.imag**2) / (2.0 * GAIN)
        if self.converged:
            power = np.minimum(power, OUTLIER * self._power + 1e-300)
        self._count = min(self._count + 1, MEMORY)
        self._power += np.where(whirling, 0.0, (power - self._power) / self._count)
        self.level = np.sqrt(self._power)
