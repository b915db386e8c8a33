# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of M s^2 + C s + K - exp(-s T) b c^T: linear motion with one delayed force, that of regenerative cutting.

The delay makes the equation transcendental. Its force depends on a single number, y = c.q, so only y is carried over
the delay: by Chebyshev collocation of y(t - x), 0 <= x <= T, as a transport equation (Breda, Maset and Vermiglio 2005),
which makes an ordinary eigenvalue problem of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.rotordynamics.eigenvalues import MOST_UNKNOWNS, Numbers, Pencil, as_dense, nearest_to_zero

POINTS = 40
"""Intervals of the collocation: eigenvalues of up to about this size over the delay are converged."""
NEUTRAL = 1e-6
"""Size over 1 / T of the eigenvalue that steady advance gives, exactly zero: a bit may be at any depth."""


class Delay(NamedTuple):
    """Delayed force b c^T q(t - T), the opposite of a part of the stiffness."""

    time: float
    """T [s]."""
    force: Array
    """b, shape (m,)."""
    arm: Array
    """c, shape (m,)."""

    def on(self, basis: Array) -> Delay:
        """Galerkin projection on the columns of a real basis."""
        return Delay(self.time, basis.T @ self.force, basis.T @ self.arm)

    def of(self, part: Numbers) -> Delay:
        """The delay of some of the unknowns."""
        return Delay(self.time, self.force[part], self.arm[part])


def differentiation(points: int) -> Array:
    """Chebyshev differentiation matrix on cos(j pi / N), j = 0 to N (Trefethen 2000, ch. 6)."""
    place = np.arange(points + 1)
    x = np.cos(np.pi * place / points)
    c = np.where((place == 0) | (place == points), 2.0, 1.0) * (-1.0) ** place
    matrix = np.outer(c, 1.0 / c) / (x[:, None] - x + np.eye(points + 1))
    return np.asarray(matrix - np.diag(matrix.sum(axis=1)))


def delayed_modes(pencil: Pencil, delay: Delay, points: int = POINTS) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues [rad/s] and their shapes as columns, shape (m, k), without the neutral one; few of a large problem.

    Args:
        pencil: Real matrices, full or sparse; the stiffness includes b c^T.
        delay: The delayed force.
        points: Intervals of the collocation.
    """
    m = pencil.mass.shape[0]
    transport = 2.0 / delay.time * differentiation(points)[1:]
    unit, force, arm = sp.eye_array(m), np.zeros((m, points)), np.zeros((points, m))
    force[:, -1] = delay.force
    arm[:] = np.outer(transport[:, 0], delay.arm)
    left = sp.block_array([
        [None, unit, None],
        [sp.csc_array(-pencil.stiffness), sp.csc_array(-pencil.damping), sp.csc_array(force)],
        [sp.csc_array(arm), None, sp.csc_array(transport[:, 1:])],
    ])  # fmt: skip
    right = sp.block_diag([unit, sp.csc_array(pencil.mass), sp.eye_array(points)])
    if m <= MOST_UNKNOWNS:
        values, vectors = np.linalg.eig(np.linalg.solve(as_dense(right), as_dense(left)))
    else:
        values, vectors = nearest_to_zero(left, right)
    kept = np.abs(values) * delay.time > NEUTRAL
    return values[kept], vectors[:m, kept]
