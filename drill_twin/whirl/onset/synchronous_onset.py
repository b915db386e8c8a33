# SPDX-License-Identifier: Apache-2.0
"""Onset of synchronous whirl: the lateral motion grows at the frequency of rotation (the paper's surge).

A bow and an imbalance are synchronous too, and are no whirl while their size is constant. The synchronous part is whirl
if, over two revolutions, its radius is above 25 % of the clearance, at least twice its smallest value since rotation
began (so that a string which is badly bent from the start is not reported), and 80 % of the motion. The onset is the
time at which the radius of the motion about the offset crossed the larger of these two thresholds.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import History
from drill_twin.whirl.onset.threshold_crossing import Crossing, Detection, synchronous_crossing
from drill_twin.whirl.orbit.orbit import Orbit

RELEASE = 0.8
"""Synchronous whirl ends below this fraction of its thresholds."""
WIDTH = 4
"""Bins averaged to find the crossing."""


class SynchronousOnsetDetector:
    """Detector of synchronous whirl of each mark."""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self._smallest = np.full(m, math.inf)
        self.active: Mask = np.zeros(m, bool)
        """Marks in synchronous whirl now."""
        self.began: list[float | None] = [None] * m
        """Start of the present synchronous whirl of each mark, since the first sample [s]."""

    def update(self, history: History, orbit: Orbit, noise: Array) -> list[Crossing]:
        """Check the newest orbit; `noise` of a bin per axis over the clearance. Return the new onsets."""
        criteria = self._criteria
        revolutions = history.revolutions
        elapsed = revolutions[history.newest(1).start] - revolutions[history.newest(history.length).start]
        if elapsed < criteria.orbit_window - 0.2 or abs(orbit.rotation) < criteria.rest_rotation:
            self.active[:] = False
            self.began = [None] * len(self.began)
            return []
        radius, share = orbit.synchronous, orbit.synchronous_share
        threshold = np.maximum(criteria.synchronous_radius, criteria.synchronous_growth * self._smallest)
        grown = (radius > threshold) & (share > criteria.synchronous_share)
        held = self.active & (radius > RELEASE * threshold) & (share > RELEASE * criteria.synchronous_share)
        self.active = grown | held
        self._smallest = np.minimum(self._smallest, radius)
        found = []
        for mark, active in enumerate(self.active.tolist()):
            if not active:
                self.began[mark] = None
            elif self.began[mark] is None:
                detection = Detection(
                    mark=mark,
                    clearance=float(self._clearance[mark]),
                    threshold=float(threshold[mark]),
                    radius=float(radius[mark]),
                    noise=float(noise[mark]),
                    width=WIDTH,
                    coherence=float(share[mark]),
                )
                crossing = synchronous_crossing(history, detection)
                self.began[mark] = crossing.time
                found.append(crossing)
        return found
