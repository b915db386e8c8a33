# SPDX-License-Identifier: Apache-2.0
"""Replicas of a run: a small random velocity at time zero, by which chaotic runs diverge."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.dynamics.twin.twin import Twin

PERTURBATION = 1e-4
"""Size of the random velocity by which replicas of a run differ [m/s]; far below the speed of whirl."""
WAVES = 5
"""Number of half waves along the string in the random velocity."""


def perturb(twin: Twin, seed: int) -> None:
    """Add a small smooth random lateral velocity, so that chaotic runs diverge."""
    random = np.random.default_rng(seed)
    _, v = twin.unknowns
    arc = twin.rod.arc / twin.rod.arc[-1]
    for half_waves in range(1, WAVES + 1):
        wave = math.pi * half_waves
        for column in range(2):
            size = PERTURBATION * random.normal() / half_waves
            # sin^2 and its slope vanish at both ends, which fits every boundary condition
            v[:, column] += size * np.sin(wave * arc) ** 2
            v[:, 3 + column] += size * wave / twin.rod.arc[-1] * np.sin(2.0 * wave * arc)
