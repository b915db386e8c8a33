# SPDX-License-Identifier: Apache-2.0
"""Irregular motion: how much of the last revolutions had no steady pace or radius."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria

RISE = 0.1
"""Irregular motion is dated to when its share of the time last rose above this."""


class Roughness:
    """Share of rough time of each mark, fading over `Criteria.rough_memory` revolutions, with hysteresis."""

    def __init__(self, marks: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._share = np.zeros(marks)
        self._travel = 0.0
        self.irregular: Mask = np.zeros(marks, bool)
        """Marks in irregular motion now."""
        self.rose = np.zeros(marks)
        """When the share last rose, since the first sample [s]."""
        self.last = np.zeros(marks)
        """When the motion was last rough, since the first sample [s]."""

    def update(self, coherence: Array, unevenness: Array, settled: Mask, time: float, travel: float) -> None:
        """Takes in the regularity of each mark at `time` [s] and `travel` [rev]; only `settled` motion can be rough."""
        rules = self._criteria
        rough = settled & ((coherence < rules.coherence) | (unevenness > rules.unevenness))
        gain = 1.0 - math.exp(-(travel - self._travel) / rules.rough_memory)
        self._travel = travel
        before = self._share
        share = np.where(settled, before + gain * (rough - before), 0.0)
        self.rose[(before < RISE) & (share >= RISE)] = time
        self.last[rough] = time
        self.irregular = (share > rules.rough_share) | (self.irregular & (share > rules.rough_end))
        self._share = share
