# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of M s^2 + C s + K, in full or on a basis of undamped modes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from drill_twin.base.arrays import Array, ComplexArray

Numbers = NDArray[np.int64]
"""Numbers of unknowns."""
MOST_UNKNOWNS = 250
"""Size from which the problem is reduced to a basis."""
BASIS = 60
"""Undamped modes in that basis."""


class Pencil(NamedTuple):
    """Mass, damping and stiffness, real or complex, shape (m, m) each."""

    mass: NDArray[Any]
    damping: NDArray[Any]
    stiffness: NDArray[Any]

    def on(self, basis: Array) -> Pencil:
        """Galerkin projection on the columns of a real basis."""
        return Pencil(*(basis.T @ matrix @ basis for matrix in self))


def undamped_basis(pencil: Pencil, count: int, loaded: Numbers | None = None) -> Array:
    """The lowest undamped modes of the symmetric part, with the static shapes under unit loads; columns.

    The static shapes (residual flexibility, MacNeal 1971) make up for the modes left out where a damper or spring at
    one point, such as the bit's friction, would need many of them.

    Args:
        pencil: The matrices.
        count: Modes.
        loaded: Numbers of the unknowns with a unit load.
    """
    stiffness, mass = pencil.stiffness.real, pencil.mass.real
    last = min(count, mass.shape[0]) - 1
    _, modes = scipy.linalg.eigh(0.5 * (stiffness + stiffness.T), 0.5 * (mass + mass.T), subset_by_index=[0, last])
    if loaded is None or not loaded.size or last + 1 >= mass.shape[0] - loaded.size:
        return np.asarray(modes)
    # stiffness made positive by mass, so that no buckled string has a singular one
    load = np.zeros((mass.shape[0], loaded.size))
    load[loaded, np.arange(loaded.size)] = 1.0
    shift = abs(float(np.min(np.einsum("ik,ij,jk->k", modes, stiffness, modes)))) + 1.0
    static = np.linalg.solve(stiffness + shift * mass, load)
    static -= modes @ (modes.T @ mass @ static)
    static /= np.sqrt(np.maximum(np.einsum("ik,ij,jk->k", static, mass, static), 1e-300))
    return np.hstack([modes, static])


def eigenvalues(pencil: Pencil) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues [rad/s], shape (2 m,), and their shapes as columns, shape (m, 2 m)."""
    values, vectors = np.linalg.eig(_first_order(pencil))
    return values, vectors[: pencil.mass.shape[0]]


def eigenvalues_only(pencil: Pencil) -> ComplexArray:
    """As `eigenvalues`, without shapes, in half the time."""
    return np.asarray(np.linalg.eigvals(_first_order(pencil)), np.complex128)


def _first_order(pencil: Pencil) -> NDArray[Any]:
    """Matrix of the same motion in position and velocity, shape (2 m, 2 m)."""
    m = pencil.mass.shape[0]
    state = np.zeros((2 * m, 2 * m), dtype=np.result_type(*pencil))
    state[:m, m:] = np.eye(m)
    state[m:] = -np.linalg.solve(pencil.mass, np.hstack([pencil.stiffness, pencil.damping]))
    return state


def damped_modes(pencil: Pencil, loaded: Numbers | None = None) -> tuple[ComplexArray, ComplexArray]:
    """As `eigenvalues`; a large problem on a basis of its lowest undamped modes."""
    if pencil.mass.shape[0] <= MOST_UNKNOWNS:
        return eigenvalues(pencil)
    basis = undamped_basis(pencil, BASIS, loaded)
    values, vectors = eigenvalues(pencil.on(basis))
    return values, basis @ vectors
