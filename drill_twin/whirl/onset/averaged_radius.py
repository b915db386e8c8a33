# SPDX-License-Identifier: Apache-2.0
"""Radius of the asynchronous part, averaged as far as the noise requires, and its threshold."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, History
from drill_twin.whirl.orbit.noise import Noise
from drill_twin.whirl.sample_bins import BINS


class AveragedRadius:
    """Radius of each mark over the clearance, averaged over at most half a revolution."""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self.noise = Noise(m)
        self.width = 1
        """Bins averaged."""
        self.radius = np.zeros(m)
        """Radius over the clearance, shape (m,)."""
        self.threshold = np.full(m, criteria.onset_radius)
        """Threshold of the radius over the clearance, shape (m,)."""
        self.release = self.threshold
        """Radius over the clearance below which a candidate is dropped, shape (m,)."""

    def update(self, history: History, rate: Array, whirling: Mask) -> None:
        """Average with the newest bin; `rate` of the asynchronous part [rad/s], shape (m,)."""
        longest = min(BINS // 2, max(1, history.bins_in(0.5)))
        window = history.newest(max(4, longest))
        time = history.time[window]
        demodulated = history.vector[window, ASYNCHRONOUS] * np.exp((-1j * rate) * (time - time[-1])[:, None])
        demodulated /= self._clearance
        self.noise.update(demodulated[-4:], whirling)
        level = self.noise.level
        self.width = self.width_for(float(level.max()), longest)
        remaining = level / math.sqrt(self.width)
        self.radius = np.abs(demodulated[-self.width :].sum(axis=0)) / self.width
        self.threshold = np.maximum(self._criteria.onset_radius, self._criteria.false_alarm_factor * remaining)
        self.release = self.threshold - remaining

    def width_for(self, noise: float, longest: int) -> int:
        """Fewest bins, a power of 2 up to `longest`, that reduce the noise of a bin below the onset's threshold."""
        factor, radius = self._criteria.false_alarm_factor, self._criteria.onset_radius
        width = 1
        while width * 2 <= longest and noise * factor > radius * math.sqrt(width):
            width *= 2
        return width
