# SPDX-License-Identifier: Apache-2.0
"""False onsets in hours of steady rotation with noise."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.whirl import Analyzer, MarkInfo

CLEARANCE, OUTER = 0.08175, 0.00825
SPEED = 2.0
"""Rotation [rev/s]."""
BOW, OFFSET = 0.1, 0.2
"""Radius of the bow and static offset, over the clearance [-]."""
PART = 600.0
"""Length of the blocks of noise [s]."""


def false_onsets(hours: float, *, marks: int = 4, rate: float = 20.0, noise: float = 0.05, seed: int = 0) -> int:
    """Number of marks with an onset in `hours` of steady rotation of a bent, eccentric string.

    Args:
        hours: Length of the record [h].
        marks: Number of wall marks.
        rate: Samples in a second.
        noise: White noise of each mark on each axis, over the clearance.
        seed: Seed of the noise.
    """
    draw = np.random.default_rng([seed, 11])
    analyzer = Analyzer([MarkInfo(f"mark_{k + 1}", 0.1 * k, "wall", OUTER, CLEARANCE) for k in range(marks)])
    count = round(PART * rate)
    twist = 0.3 * np.arange(marks)
    place = np.empty((count, marks, 2))
    for part in range(math.ceil(hours * 3600.0 / PART)):
        time = part * PART + np.arange(count) / rate
        spin = math.tau * SPEED * time[:, None] - twist
        z = CLEARANCE * (OFFSET + BOW * np.exp(1j * spin)) + OUTER * np.exp(1j * spin)
        place[..., 0], place[..., 1] = z.real, z.imag
        place += noise * CLEARANCE * draw.normal(size=place.shape)
        stamps = np.round(time * 1e9).astype(np.int64)
        analyzer.push_block(stamps, place, spin, np.full(count, math.tau * SPEED))
    return sum(found is not None for found in analyzer.summary().mark_onset_s.values())
