# SPDX-License-Identifier: Apache-2.0
"""Onset of synchronous whirl: the lateral motion grows at the frequency of rotation (the paper's surge).

A bow and an imbalance are synchronous too, and are no whirl while their size is constant. The synchronous part is whirl
if, over two revolutions, its radius is above 25 % of the clearance, at least twice its smallest value since rotation
began (so that a string which is badly bent from the start is not reported), and 80 % of the motion. The onset is the
time at which the radius of the motion about the offset crossed the larger of these two thresholds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import LENGTH, History, end_of
from drill_twin.whirl.onset.threshold_crossing import Crossing, Detection, synchronous_crossing
from drill_twin.whirl.orbit.orbit import ROTATION, Orbit
from drill_twin.whirl.sample_bins import REVOLUTIONS

RELEASE = 0.8
"""Synchronous whirl ends below this fraction of its thresholds."""
WIDTH = 4
"""Bins averaged to find the crossing."""


class SynchronousOnsets(NamedTuple):
    """State of knowledge of the synchronous whirl of m marks."""

    active: Mask  # (m,) in synchronous whirl now
    began: Array  # (m,) its start, since the first sample [s]; nan without
    smallest: Array  # (m,) smallest radius so far, over the clearance
    threshold: Array  # (m,) of the radius over the clearance

    @classmethod
    def of(cls, m: int) -> SynchronousOnsets:
        """Before the first bin."""
        return cls(np.zeros(m, bool), np.full(m, math.nan), np.full(m, math.inf), np.zeros(m))

    def check(self, clearance: Array, noise: Array, orbit: Orbit, history: History) -> list[Crossing]:
        """Crossings of the marks that began to whirl with the newest orbit.

        Args:
            clearance: Clearance of the marks [m], shape (m,).
            noise: Noise of a bin at the marks, over the clearance, shape (m,).
            orbit: The orbit.
            history: The bins.
        """
        found = []
        for mark in np.flatnonzero(self.active & np.isnan(self.began)).tolist():
            detection = Detection(
                mark=mark,
                clearance=float(clearance[mark]),
                threshold=float(self.threshold[mark]),
                radius=float(orbit.synchronous[mark]),
                noise=float(noise[mark]),
                width=WIDTH,
                coherence=float(orbit.synchronous_share[mark]),
            )
            crossing = synchronous_crossing(history, detection)
            self.began[mark] = crossing.time
            found.append(crossing)
        return found


@strict_kernel
def watch_synchronous(
    onsets: SynchronousOnsets, history: History, orbit: Orbit, criteria: Criteria, swing: Array
) -> bool:
    """Check the newest orbit of marks that `swing` by so much or not at all, shape (m,); return whether one whirls."""
    end = end_of(history)
    elapsed = history.clock[end - 1, REVOLUTIONS] - history.clock[end - history.counts[LENGTH], REVOLUTIONS]
    if elapsed < criteria.orbit_window - 0.2 or abs(orbit.numbers[ROTATION]) < criteria.rest_rotation:
        onsets.active[:] = False
        onsets.began[:] = math.nan
        return False
    found = False
    for k in range(onsets.active.size):
        radius, share = orbit.synchronous[k], orbit.synchronous_share[k]
        threshold = np.maximum(criteria.synchronous_radius, criteria.synchronous_growth * onsets.smallest[k])
        grown = radius > threshold and share > criteria.synchronous_share
        grown = grown and radius > criteria.synchronous_over_swing * swing[k]
        held = radius > RELEASE * threshold and share > RELEASE * criteria.synchronous_share
        onsets.active[k] = grown or (onsets.active[k] and held)
        onsets.smallest[k] = np.minimum(onsets.smallest[k], radius)
        onsets.threshold[k] = threshold
        if not onsets.active[k]:
            onsets.began[k] = math.nan
        found = found or (onsets.active[k] and math.isnan(onsets.began[k]))
    return found
