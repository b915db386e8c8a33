# SPDX-License-Identifier: Apache-2.0
"""Replicas of a run: a small random velocity at time zero, by which chaotic runs diverge."""

from __future__ import annotations

import numpy as np

from drill_twin.dynamics.equilibrium.static_equilibrium import random_shape
from drill_twin.dynamics.twin.twin import Twin

PERTURBATION = 1e-4
"""Size of the random velocity by which replicas of a run differ [m/s]; far below the speed of whirl."""


def perturb(twin: Twin, seed: int) -> None:
    """Add a small smooth random lateral velocity, so that chaotic runs diverge."""
    random = np.random.default_rng(seed)
    _, v = twin.unknowns
    place, slope = random_shape(twin.rod.arc, random)
    v[:, 0:2] += PERTURBATION * place
    v[:, 3:5] += PERTURBATION * slope
