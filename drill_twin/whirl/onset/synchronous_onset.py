# SPDX-License-Identifier: Apache-2.0
"""Onset of synchronous whirl: the paper's surge, where the string is thrown out at the rate of its rotation.

A bow and an imbalance turn with the string too, and are no whirl while they keep their size. The synchronous part is
taken for whirl when, over two revolutions, its radius is above 25 % of the clearance, it is at least twice the
smallest it has been since rotation began (so it has grown, and a string that is badly bent from the start is not
taken for a whirling one), and it makes up 80 % of the motion. The time reported is when the moving radius crossed
that threshold (the larger of the two).
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import History
from drill_twin.whirl.onset.threshold_crossing import Crossing, Evidence, synchronous_crossing
from drill_twin.whirl.orbit.orbit import Orbit

RELEASE = 0.8
"""The surge is over below this fraction of its threshold."""
WIDTH = 4
"""Bins averaged when the crossing is dated."""


class SurgeDetector:
    """Watches the synchronous part of each mark."""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self._steady = np.full(m, math.inf)
        self.active: Mask = np.zeros(m, bool)
        """Marks in synchronous whirl now."""
        self.began: list[float | None] = [None] * m
        """When the present surge of each mark began, since the first sample [s]."""

    def update(self, history: History, orbit: Orbit, noise: Array) -> list[Crossing]:
        """Takes in the newest bin; `noise` of a bin per axis over the clearance. Returns the new onsets."""
        rules = self._criteria
        turned = history.travel[history.newest(1).start] - history.travel[history.newest(history.length).start]
        if turned < rules.orbit_window - 0.2 or abs(orbit.rotation) < rules.rest_rotation:
            self.active[:] = False
            self.began = [None] * len(self.began)
            return []
        threshold = np.maximum(rules.surge_radius, rules.surge_growth * self._steady)
        grown = (orbit.synchronous > threshold) & (orbit.purity > rules.surge_purity)
        held = self.active & (orbit.synchronous > RELEASE * threshold) & (orbit.purity > RELEASE * rules.surge_purity)
        self.active = grown | held
        self._steady = np.minimum(self._steady, orbit.synchronous)
        found = []
        for mark, active in enumerate(self.active.tolist()):
            if not active:
                self.began[mark] = None
            elif self.began[mark] is None:
                known = Evidence(
                    mark=mark,
                    clearance=float(self._clearance[mark]),
                    threshold=float(threshold[mark]),
                    size=float(orbit.synchronous[mark]),
                    noise=float(noise[mark]),
                    width=WIDTH,
                    coherence=float(orbit.purity[mark]),
                )
                crossing = synchronous_crossing(history, known)
                self.began[mark] = crossing.time
                found.append(crossing)
        return found
