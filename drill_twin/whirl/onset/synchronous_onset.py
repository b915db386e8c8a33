# SPDX-License-Identifier: Apache-2.0
"""Onset of synchronous whirl: the lateral motion grows at the frequency of rotation (the paper's surge).

A bow and an imbalance are synchronous too, and are no whirl while their size is constant. The synchronous part is whirl
if, over two revolutions, its radius is above 25 % of the clearance, at least twice its smallest value since rotation
began (so that a string which is badly bent from the start is not reported), and 80 % of the motion. The mean
place of the mark in these revolutions counts for nothing, so that a mark that stands, as in stick-slip, has no
synchronous part. The onset is the time at which the radius of the motion about the offset crossed the larger of these
two thresholds.
"""

import math

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import end_of
from drill_twin.whirl.onset.threshold_crossing import Crossing, Detection, synchronous_crossing

RELEASE = 0.8
"""Synchronous whirl ends below this fraction of its thresholds (hysteresis); chosen, not measured."""
WIDTH = 4
"""Bins averaged to find the crossing, a quarter of a revolution; chosen, not measured."""


def new_synchronous(m: int) -> Columns:
    """State of the synchronous whirl of m marks before the first bin."""
    return columns(
        "SynchronousOnsets",
        m,
        active=False,  # in synchronous whirl now
        began=math.nan,  # its start, since the first sample [s]; nan without
        smallest=math.inf,  # smallest radius so far, over the clearance
        threshold=0.0,  # of the radius over the clearance
    )


def synchronous_begins(
    onsets: Columns, clearance: Array, noise: Array, orbit: Columns, history: Columns
) -> list[Crossing]:
    """Date the crossings of the marks that began to whirl with the newest orbit.

    Args:
        onsets: What is known of the marks.
        clearance: Clearance of the marks [m], shape (m,).
        noise: Noise of a bin at the marks, over the clearance, shape (m,).
        orbit: The orbit.
        history: The bins.
    """
    found = []
    for mark in np.flatnonzero(onsets.active & np.isnan(onsets.began)).tolist():
        detection = Detection(
            mark=mark,
            clearance=float(clearance[mark]),
            threshold=float(onsets.threshold[mark]),
            radius=float(orbit.synchronous[mark]),
            noise=float(noise[mark]),
            width=WIDTH,
            coherence=float(orbit.synchronous_share[mark]),
        )
        found.append(synchronous_crossing(history, detection))
        onsets.began[mark] = found[-1].time
    return found


@strict_kernel
def watch_synchronous(onsets: Columns, history: Columns, orbit: Columns) -> bool:
    """Check the newest orbit of the marks; return whether one begins to whirl."""
    end = end_of(history)
    elapsed = history.revolutions[end - 1] - history.revolutions[end - history.length[0]]
    if elapsed < criteria.ORBIT_WINDOW - 0.2 or abs(orbit.rotation[0]) < criteria.REST_ROTATION:
        onsets.active[:] = False
        onsets.began[:] = math.nan
        return False
    found = False
    for k in range(onsets.active.size):
        radius, share = orbit.synchronous[k], orbit.synchronous_share[k]
        threshold = np.maximum(criteria.SYNCHRONOUS_RADIUS, criteria.SYNCHRONOUS_GROWTH * onsets.smallest[k])
        grown = radius > threshold and share > criteria.SYNCHRONOUS_SHARE
        held = radius > RELEASE * threshold and share > RELEASE * criteria.SYNCHRONOUS_SHARE
        onsets.active[k] = grown or (onsets.active[k] and held)
        onsets.smallest[k] = np.minimum(onsets.smallest[k], radius)
        onsets.threshold[k] = threshold
        if not onsets.active[k]:
            onsets.began[k] = math.nan
        found = found or (onsets.active[k] and math.isnan(onsets.began[k]))
    return found
