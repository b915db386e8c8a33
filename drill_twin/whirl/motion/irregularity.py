# SPDX-License-Identifier: Apache-2.0
"""Irregular motion: share of the last revolutions without a steady rate or radius."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.orbit.orbit import Orbit

RISE = 0.1
"""Irregular motion starts when its share of the time last rose above this."""


class Irregularity(NamedTuple):
    """Share of irregular time of m marks, fading over `Criteria.irregularity_memory` revolutions, with hysteresis."""

    active: Mask  # (m,) in irregular motion now
    rose: Array  # (m,) time at which the share last rose, since the first sample [s]
    last: Array  # (m,) time at which the motion was last irregular, since the first sample [s]
    share: Array  # (m,)
    revolutions: Array  # (1,) of the last estimate [rev]

    @classmethod
    def of(cls, m: int) -> Irregularity:
        """Before the first estimate."""
        return cls(np.zeros(m, bool), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(1))


@strict_kernel
def update_irregularity(
    irregularity: Irregularity,
    orbit: Orbit,
    asynchronous: Mask,
    detected: Array,
    criteria: Criteria,
    time: float,
    revolutions: float,
) -> None:
    """Add an estimate.

    Args:
        irregularity: The shares.
        orbit: Orbits of the marks.
        asynchronous: Marks in asynchronous whirl, shape (m,).
        detected: Detection of that whirl [rev], shape (m,).
        criteria: Thresholds.
        time: Time since the first sample [s].
        revolutions: Revolutions since the first sample [rev].
    """
    gain = 1.0 - math.exp(-(revolutions - irregularity.revolutions[0]) / criteria.irregularity_memory)
    irregularity.revolutions[0] = revolutions
    for k in range(detected.size):
        row = 0 if asynchronous[k] else 1
        settled = revolutions - detected[k] > criteria.settling_time
        rough = orbit.coherence[row, k] < criteria.coherence or orbit.unevenness[row, k] > criteria.unevenness
        before, share = irregularity.share[k], 0.0
        if settled:
            share = before + gain * ((1.0 if rough else 0.0) - before)
        if before < RISE <= share:
            irregularity.rose[k] = time
        if settled and rough:
            irregularity.last[k] = time
        held = irregularity.active[k] and share > criteria.irregularity_off
        irregularity.active[k] = share > criteria.irregularity_on or held
        irregularity.share[k] = share
