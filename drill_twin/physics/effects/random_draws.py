# SPDX-License-Identifier: Apache-2.0
"""Seeded random functions as sums of harmonics, independent of mesh and time step, and random matrices.

``z(x) = sum_j exp(i (k_j x + phi_j)) / sqrt(N)`` with uniform phases and k_j from the normal distribution of width
1 / l is, for many harmonics, a Gaussian process in the complex plane (two random components, no direction preferred)
of mean square one and correlation exp(-(x / l)^2 / 2) (Shinozuka and Deodatis 1991). The k_j are drawn one from each of
N equally likely strata, so that few harmonics follow the spectrum closely. The matrices follow the nonparametric
probabilistic approach: positive definite with mean identity.
"""

import math
from statistics import NormalDist

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model import DiscreteModel

HARMONICS = 64


def generator(model: DiscreteModel, seed: int, purpose: str) -> np.random.Generator:
    """Random generator from the scene's seed, an effect's seed and a purpose, so that effects are independent."""
    return np.random.default_rng([model.seed, seed, *purpose.encode()])


def normal_strata(random: np.random.Generator, number: int) -> Array:
    """Standard normal random numbers in random order, one from each of `number` equally likely strata."""
    share = (random.permutation(number) + random.uniform(0.0, 1.0, number)) / number
    return np.array([NormalDist().inv_cdf(min(max(float(p), 1e-12), 1.0 - 1e-12)) for p in share])


def random_line(
    places: Array, correlation: float, random: np.random.Generator, derivative: int = 0
) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    """Random function z = x + i y of the arc length with mean square one, or its derivative.

    Args:
        places: Arc lengths [m], shape (m,).
        correlation: Length l at which the correlation is exp(-1/2) [m].
        random: Source of randomness.
        derivative: Order of the derivative.

    Returns:
        Shape (m,) [1 / m^derivative].
    """
    waves = normal_strata(random, HARMONICS) / correlation
    turns = np.exp(1j * (np.multiply.outer(places, waves) + random.uniform(0.0, math.tau, HARMONICS)))
    return np.asarray(turns @ ((1j * waves) ** derivative) / np.sqrt(HARMONICS))


SIZE = 2
MOST_SCATTER = float(np.sqrt((SIZE + 1.0) / (SIZE + 5.0)))
"""Dispersion from which the inverse of the random matrix has no second moment, sqrt(3 / 7) for a 2 x 2 matrix."""


def random_matrix(dispersion: float, random: np.random.Generator) -> Array:
    """Draw the random matrix G, shape (2, 2).

    G = L^T L with L upper triangular, L_jk = s U_jk above the diagonal and s sqrt(2 V_j) on it; s = dispersion /
    sqrt(n + 1), U normal, V_j of a gamma law with parameter (n + 1) / (2 dispersion^2) + (1 - j) / 2 (Soize 2000).
    Then E[G] = I and E[|G - I|^2] = n dispersion^2 in the Frobenius norm.

    Args:
        dispersion: 0 for the identity, below `MOST_SCATTER`.
        random: Source of randomness.
    """
    if dispersion == 0.0:
        return np.eye(SIZE)
    scale = dispersion / np.sqrt(SIZE + 1.0)
    shapes = (SIZE + 1.0) / (2.0 * dispersion**2) - 0.5 * np.arange(SIZE)
    factor = np.diag(scale * np.sqrt(2.0 * random.gamma(shapes)))
    factor[np.triu_indices(SIZE, 1)] = scale * random.standard_normal(SIZE * (SIZE - 1) // 2)
    return np.asarray(factor.T @ factor)
