# SPDX-License-Identifier: Apache-2.0
"""Radius of the asynchronous part, averaged as far as the noise requires, and its threshold."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, History, bins_in, end_of
from drill_twin.whirl.orbit.noise import Noise, update_noise
from drill_twin.whirl.sample_bins import BINS, TIME

LONGEST = BINS // 2
"""Most bins averaged."""


class AveragedRadius(NamedTuple):
    """Radius of each mark over the clearance, averaged over at most half a revolution."""

    radius: Array  # (m,) over the clearance
    threshold: Array  # (m,) of the radius
    release: Array  # (m,) radius below which a candidate is dropped
    noise: Noise
    width: Integers  # (1,) bins averaged
    clearance: Array  # (m,) [m]
    demodulated: ComplexArray  # (LONGEST, m) work

    @classmethod
    def of(cls, clearance: Array, criteria: Criteria) -> AveragedRadius:
        """Radii before the first bin."""
        m = clearance.size
        threshold = np.full(m, criteria.onset_radius)
        return cls(
            np.zeros(m), threshold, threshold.copy(), Noise.of(m), np.ones(1, np.int64), clearance,
            np.zeros((LONGEST, m), complex),
        )  # fmt: skip


@strict_kernel
def average_radius(
    averaged: AveragedRadius, history: History, criteria: Criteria, rate: Array, carrier: Array, whirling: Mask
) -> None:
    """Average with the newest bin; `rate` of the asynchronous part, and of its `carrier` or 0 [rad/s], shape (m,)."""
    m, end = whirling.size, end_of(history)
    longest = min(LONGEST, max(1, bins_in(history, 0.5)))
    bins = max(4, longest)
    for i in range(bins):
        at = end - bins + i
        since = history.clock[at, TIME] - history.clock[end - 1, TIME]
        for k in range(m):
            angle = -(carrier[k] if carrier[k] != 0.0 else rate[k]) * since
            turned = history.complex_part[at, ASYNCHRONOUS, k] * complex(math.cos(angle), math.sin(angle))
            averaged.demodulated[i, k] = turned / averaged.clearance[k]
    update_noise(averaged.noise, averaged.demodulated[bins - 4 : bins], whirling)
    level = averaged.noise.level
    largest = level[0]
    for k in range(1, m):
        largest = np.maximum(largest, level[k])
    width = averaged.width[0] = width_for(criteria, largest, longest)
    for k in range(m):
        total, remaining = 0j, level[k] / math.sqrt(width)
        for i in range(bins - width, bins):
            total += averaged.demodulated[i, k]
        averaged.radius[k] = abs(total) / width
        averaged.threshold[k] = np.maximum(criteria.onset_radius, criteria.false_alarm_factor * remaining)
        averaged.release[k] = averaged.threshold[k] - remaining


@strict_kernel
def width_for(criteria: Criteria, noise: float, longest: int) -> int:
    """Fewest bins, a power of 2 up to `longest`, that reduce the noise of a bin below the onset's threshold."""
    factor, radius = criteria.false_alarm_factor, criteria.onset_radius
    width = 1
    while width * 2 <= longest and noise * factor > radius * math.sqrt(width):
        width *= 2
    return width
