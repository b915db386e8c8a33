# SPDX-License-Identifier: Apache-2.0
"""Random matrix of the nonparametric probabilistic approach: positive definite with mean identity."""

import numpy as np

from drill_twin.core.arrays import Array

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
    drawn: Array = factor.T @ factor
    return drawn
