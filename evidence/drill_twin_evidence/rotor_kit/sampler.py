# SPDX-License-Identifier: Apache-2.0
"""Markov chains by differential evolution (ter Braak 2006) on standard normal unknowns, and R-hat (Gelman et al. 2013).

Each group is a population of walkers of its own, started from the prior and cooled from a flat likelihood; groups
never see one another, so agreement between groups is a check.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drill_twin_evidence.rotor_kit.elements import Real

COOLING = 0.3  # part of the steps in which the likelihood is raised from 1 % to its full weight; chosen, not measured
SETTLING = 0.45  # part of the steps that is thrown away, cooling included; R-hat judges whether it was enough
JUMPS = 0.1  # part of the moves with gamma = 1, which changes modes (ter Braak 2006)
JITTER = 1e-3  # standard deviation of the noise that keeps the proposal irreducible


@dataclass(frozen=True)
class Chains:
    """Draws of shape (groups, steps, walkers, unknowns), their log likelihood, and the part of accepted moves."""

    z: Real
    log_likelihood: Real
    accepted: float

    def r_hat(self) -> Real:
        """Return R-hat of each unknown between groups, each group split into halves: shape (unknowns,)."""
        groups, steps, walkers, size = self.z.shape
        half = steps // 2
        parts = self.z[:, : 2 * half].reshape(2 * groups, half * walkers, size)
        # Walkers of a group are not independent of one another; a group's mean is, and it is what is compared.
        within, between = parts.var(axis=1, ddof=1).mean(axis=0), parts.mean(axis=1).var(axis=0, ddof=1)
        result: Real = np.sqrt(1 + between / within)
        return result

    def drawn(self, count: int, rng: np.random.Generator) -> Real:
        """Return draws of the posterior without order, shape (count, unknowns)."""
        flat = self.z.reshape(-1, self.z.shape[-1])
        drawn: Real = flat[rng.choice(len(flat), size=count, replace=False)]
        return drawn


def sample(
    log_likelihood: Callable[[Real], Real],
    unknowns: int,
    *,
    groups: int,
    walkers: int,
    steps: int,
    seed: int,
    keep_every: int = 10,
) -> Chains:
    """Sample exp(log_likelihood(z)) N(z; 0, I); log_likelihood takes (n, unknowns) and may return -inf."""
    rng = np.random.default_rng(seed)
    z = rng.standard_normal((groups, walkers, unknowns))
    fit = log_likelihood(z.reshape(-1, unknowns)).reshape(groups, walkers)
    while (bad := ~np.isfinite(fit)).any():
        z[bad] = rng.standard_normal((int(bad.sum()), unknowns))
        fit[bad] = log_likelihood(z[bad])
    prior = -0.5 * (z**2).sum(axis=2)
    kept, kept_fit, moves, taken = [], [], 0, 0
    group = np.arange(groups)[:, None]
    half = walkers // 2
    for step in range(steps):
        weight = min(1.0, 0.01 ** (1 - step / (COOLING * steps)))
        order = rng.permuted(np.tile(np.arange(walkers), (groups, 1)), axis=1)
        for mine, others in ((order[:, :half], order[:, half:]), (order[:, half:], order[:, :half])):
            one = rng.integers(0, others.shape[1], mine.shape)
            two = (one + rng.integers(1, others.shape[1], mine.shape)) % others.shape[1]
            apart = z[group, np.take_along_axis(others, one, 1)] - z[group, np.take_along_axis(others, two, 1)]
            moved = rng.random((*mine.shape, unknowns)) < rng.choice([0.15, 0.4, 1.0], size=(*mine.shape, 1))
            size = 2.38 / np.sqrt(2 * np.maximum(1, moved.sum(axis=2)))
            size = np.where(rng.random(mine.shape) < JUMPS, 1.0, size * rng.uniform(0.3, 1.1, mine.shape))
            new = z[group, mine] + moved * (size[..., None] * apart + JITTER * rng.standard_normal(apart.shape))
            new_fit = log_likelihood(new.reshape(-1, unknowns)).reshape(mine.shape)
            new_prior = -0.5 * (new**2).sum(axis=2)
            gain = weight * (new_fit - fit[group, mine]) + new_prior - prior[group, mine]
            better = np.log(rng.random(mine.shape)) < gain
            rows = np.broadcast_to(group, mine.shape)[better]
            columns = mine[better]
            z[rows, columns], fit[rows, columns] = new[better], new_fit[better]
            prior[rows, columns] = new_prior[better]
            if step >= SETTLING * steps:
                moves, taken = moves + better.size, taken + int(better.sum())
        if step >= SETTLING * steps and step % keep_every == 0:
            kept.append(z.copy())
            kept_fit.append(fit.copy())
    return Chains(np.stack(kept, axis=1), np.stack(kept_fit, axis=1), taken / moves)
