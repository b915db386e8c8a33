# SPDX-License-Identifier: Apache-2.0
"""Irregular motion: share of the last revolutions without a steady rate or radius."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria

RISE = 0.1
"""Irregular motion starts when its share of the time last rose above this."""


class Irregularity:
    """Share of irregular time of each mark, fading over `Criteria.irregularity_memory` revolutions, with hysteresis."""

    def __init__(self, marks: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._share = np.zeros(marks)
        self._revolutions = 0.0
        self.active: Mask = np.zeros(marks, bool)
        """Marks in irregular motion now."""
        self.rose = np.zeros(marks)
        """Time at which the share last rose, since the first sample [s]."""
        self.last = np.zeros(marks)
        """Time at which the motion was last irregular, since the first sample [s]."""

    def update(self, coherence: Array, unevenness: Array, settled: Mask, time: float, revolutions: float) -> None:
        """Add an estimate.

        Args:
            coherence: Coherence of the angle of each mark, shape (m,).
            unevenness: Unevenness of its radius, shape (m,).
            settled: Marks whose motion may be irregular, shape (m,).
            time: Time since the first sample [s].
            revolutions: Revolutions since the first sample [rev].
        """
        criteria = self._criteria
        irregular = settled & ((coherence < criteria.coherence) | (unevenness > criteria.unevenness))
        gain = 1.0 - math.exp(-(revolutions - self._revolutions) / criteria.irregularity_memory)
        self._revolutions = revolutions
        before = self._share
        share = np.where(settled, before + gain * (irregular - before), 0.0)
        self.rose[(before < RISE) & (share >= RISE)] = time
        self.last[irregular] = time
        self.active = (share > criteria.irregularity_on) | (self.active & (share > criteria.irregularity_off))
        self._share = share
