# SPDX-License-Identifier: Apache-2.0
"""Adaptive multiple importance sampling: a posterior from few calls, many runs at a time.

Cornuet, Marin, Mira and Robert 2012 (Scand. J. Stat. 39, 798): all draws of all rounds are weighted with the mixture
of the proposals they came from, so no run is thrown away. Most rounds draw about the draw of the largest weight, with
the spread of the draws next to it (Raftery and Bao 2010, Biometrics 66, 1162): so proposals follow a posterior which is
long and bent. While the likelihood is much narrower than the draws, it is raised to a power below 1 that leaves enough
of them alive (tempering).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize, special, stats

from drill_twin.core.arrays import Array

Ranges = Mapping[str, tuple[float, float]]
"""Lowest and highest value [SI] by key."""
END = 0.05
"""Part of a range at each of its ends."""
LOGARITHMIC = 20.0
"""Ratio of a range's ends from which it is uniform in the logarithm."""


def weighted_quantile(values: Array, weights: Array, share: float) -> Array:
    """Quantile of weighted draws, of shape (N,) or along the first axis of (N, T)."""
    flat = values.reshape(len(values), -1)
    order = np.argsort(flat, axis=0)
    total = np.cumsum(weights[order], axis=0)
    row = np.argmax(total >= share * total[-1], axis=0)
    return np.asarray(np.take_along_axis(flat, np.take_along_axis(order, row[None], 0), 0)[0].reshape(values.shape[1:]))


def in_ranges(cube: Array, ranges: Ranges) -> Array:
    """Values [SI] at positions in the unit cube, both of shape (N, d)."""
    columns = []
    for position, (low, high) in zip(cube.T, ranges.values(), strict=True):
        logarithmic = low > 0.0 and high >= LOGARITHMIC * low
        columns.append(low * (high / low) ** position if logarithmic else low + (high - low) * position)
    return np.array(columns).T


FREEDOM = 2
"""Degrees of freedom of the proposals: tails of Student's t reach along a posterior that is long and bent, where the
effective number of draws tells nothing of what was never drawn."""
_INFLATION = 2.0  # of the covariance of a proposal of all draws
_PRIOR_SHARE = 0.1  # of the draws of a round, from the prior: finds what the proposals left out
_GLOBAL = 3  # every so many rounds a proposal of all draws; the others are local
_NEAR = 0.1  # share of the draws that tells the spread of a local proposal


@dataclass(frozen=True)
class Sampling:
    """Weighted draws.

    Attributes:
        cube: Positions in the unit cube of the ranges, shape (N, d).
        weights: Weights of the draws, sum 1, shape (N,).
        log_likelihood: Shape (N,).
        power: Power of the likelihood; below 1 the draws are wider than the posterior.
    """

    cube: Array
    weights: Array
    log_likelihood: Array
    power: float

    @property
    def effective(self) -> float:
        """Effective number of draws, 1 / sum of squared weights (Kong 1992)."""
        return float(1.0 / np.sum(self.weights**2))

    @property
    def at_ends(self) -> Array:
        """Probability in the lowest and in the highest `END` of each range, shape (2, d)."""
        return np.array([self.weights @ (self.cube < END), self.weights @ (self.cube > 1.0 - END)])

    @property
    def intervals(self) -> Array:
        """Ends of the intervals in the unit cube, shape (2, d): 5 and 95 % quantiles.

        An interval reaches an end of its range, and has 95 % of the draws, where more draws are near it than of the
        prior: they cannot lie beyond it, so a quantile would leave out each truth that is near it.
        """
        low, high = (weighted_quantile(self.cube, self.weights, share) for share in (0.05, 0.95))
        near_low, near_high = self.at_ends > END
        return np.array([np.where(near_low, 0.0, low), np.where(near_high, 1.0, high)])


def sample(
    likelihood: Callable[[Array], Array],
    dimensions: int,
    *,
    members: int,
    rounds: int,
    effective: float,
    seed: int,
    done: Callable[[int, Sampling], None] | None = None,
) -> Sampling:
    """Draw from the posterior under a uniform prior.

    Args:
        likelihood: Called once a round with the positions of new draws in the unit cube, shape (M, d); returns the
            logarithm of the likelihood of all draws so far, shape (all M,).
        dimensions: Numbers to be found.
        members: Draws of a round.
        rounds: Rounds at most.
        effective: Effective number of draws with which it ends.
        seed: Of the draws.
        done: Called after each round with its number and the draws so far.
    """
    generator = np.random.default_rng(seed)
    proposals: list[Any] = []
    normal = np.zeros((0, dimensions))
    result: Sampling | None = None
    for number in range(rounds):
        proposal = None if result is None else _proposal(normal, result.weights, members, number)
        proposals.append(proposal)
        normal = np.concatenate((normal, _draws(proposal, members, dimensions, generator)))
        cube = special.ndtr(normal)
        found = likelihood(cube[-members:])
        result = _weighted(normal, cube, found, proposals, members)
        if done is not None:
            done(number + 1, result)
        if result.power == 1.0 and result.effective >= effective:
            break
    if result is None:
        raise ValueError(f"rounds: expected 1 or more, found {rounds}")
    return result


def sobol(dimensions: int, count: int, seed: int | np.random.Generator) -> Array:
    """First points of a scrambled Sobol sequence in the unit cube, shape (count, dimensions).

    They are balanced in powers of two; the points of the next power are drawn, and the first of them kept.
    """
    return np.asarray(stats.qmc.Sobol(dimensions, seed=seed).random_base2((count - 1).bit_length())[:count])


def _draws(proposal: Any, count: int, dimensions: int, generator: np.random.Generator) -> Array:
    """Draws in the space where the prior is standard normal: quasi-random (Sobol) from it, else from a proposal."""
    prior: Array = special.ndtri(np.clip(sobol(dimensions, count, generator), 1e-9, 1.0 - 1e-9))
    if proposal is None:
        return prior
    drawn = proposal.rvs(count, generator).reshape(count, dimensions)
    keep = round(_PRIOR_SHARE * count)
    drawn[:keep] = prior[:keep]
    return np.asarray(np.clip(drawn, -6.0, 6.0))


def _weighted(normal: Array, cube: Array, found: Array, proposals: list[Any], members: int) -> Sampling:
    prior = stats.norm.logpdf(normal).sum(axis=1)
    of_prior = np.log(_PRIOR_SHARE) + prior
    densities = [
        prior if each is None else np.logaddexp(of_prior, np.log1p(-_PRIOR_SHARE) + each.logpdf(normal).reshape(-1))
        for each in proposals
    ]
    base = prior - special.logsumexp(densities, axis=0) + np.log(len(densities))
    wanted: float = min(max(2.0 * normal.shape[1] + 2.0, members / 4.0), members / 1.5)

    def weights(power: float) -> Array:
        logarithm = base + np.where(np.isfinite(found), power * np.nan_to_num(found), -np.inf)
        return np.asarray(special.softmax(logarithm))

    def excess(power: float) -> float:
        return float(1.0 / np.sum(weights(power) ** 2)) - wanted

    power = 1.0
    if excess(1.0) < 0.0:
        power = float(optimize.brentq(excess, 0.0, 1.0, xtol=1e-9)) if excess(0.0) > 0.0 else 0.0
    return Sampling(cube, weights(power), found, power)


def _proposal(normal: Array, weights: Array, members: int, number: int) -> Any:
    """Student's t of all draws, or of draws next to the draw of the largest weight, where the prior is normal."""
    centre = weights @ normal
    spread = normal - centre
    covariance = _INFLATION * (spread.T * weights) @ spread + 1e-8 * np.eye(len(centre))
    if number % _GLOBAL:
        centre = normal[np.argmax(weights)]
        spread = normal - centre
        distance = np.einsum("ni,ij,nj->n", spread, np.linalg.inv(covariance), spread)
        near = np.argsort(distance)[: max(members, round(_NEAR * len(normal)))]
        mixed = 0.5 * (weights[near] / weights[near].sum() + 1.0 / len(near))
        covariance = (spread[near].T * mixed) @ spread[near] + 1e-8 * np.eye(len(centre))
    return stats.multivariate_t(centre, covariance, FREEDOM)
