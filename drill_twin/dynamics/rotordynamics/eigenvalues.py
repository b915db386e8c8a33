# SPDX-License-Identifier: Apache-2.0
"""Eigenvalues of M s^2 + C s + K: all, the nearest to zero, or on a basis of undamped modes.

The one delayed force of regenerative cutting makes them eigenvalues of M s^2 + C s + K - exp(-s T) b c^T. The delay
makes the equation transcendental. The delayed force depends on a single number, y = c.q, so only y is carried over the
delay: by Chebyshev collocation of y(t - x), 0 <= x <= T, as a transport equation (Breda, Maset and Vermiglio 2005),
which makes the equation an ordinary eigenvalue problem.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from ctypes import CDLL
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import RunError

Numbers = NDArray[np.int64]
"""Numbers of unknowns."""
MOST_UNKNOWNS = 250
"""Size from which only the eigenvalues nearest to zero are computed."""
NEAREST = 160
"""Number of these."""
REFINED, DOUBTFUL, ITERATIONS = 24, 1e-4, 3
"""Smallest eigenvalues that are refined (a table shows 12 of a kind), share of their square from which rounding may
spoil them, and iterations: the first cubes the error of the shape; chosen."""
SHIFT = 0.01
"""Point that they are nearest to [rad/s]: not zero, where a string that may turn or advance freely is singular."""
ROOM = 60
"""Least number of vectors of Arnoldi's method: eight eigenvalues of a well took 271 products with 20, 112 with 60."""


class Pencil(NamedTuple):
    """Mass, damping and stiffness, real or complex, shape (m, m) each; sparse ones for `damped_modes` alone."""

    mass: Any
    damping: Any
    stiffness: Any

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
    load = np.eye(mass.shape[0])[:, loaded]
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


def damped_modes(pencil: Pencil) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues and modes as in `eigenvalues`; of a large problem, the eigenvalues nearest to zero.

    No basis of undamped modes will do for a large problem: friction on the wall couples the stiff motion into the wall
    with the soft motion along it. The symmetric part of such a stiffness has a large negative eigenvalue at each point
    of contact.

    Raises:
        RunError: The iteration does not converge.
    """
    if pencil.mass.shape[0] <= MOST_UNKNOWNS:
        return refined(pencil, *eigenvalues(pencil))
    return modes_near(pencil)


def refined(pencil: Pencil, values: ComplexArray, vectors: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues and shapes, the smallest by inverse iteration where rounding in the largest may spoil them.

    The QR algorithm is exact up to rounding of its largest entry, eps |s|^2 of the largest eigenvalue: a stiff short
    element moves the first mode of a soft string by percents. Inverse iteration with the quadratic pencil keeps the
    small eigenvalues as exact as the matrices are.
    """
    order, mass, damping, stiffness = np.argsort(np.abs(values)), *pencil
    doubt = np.finfo(float).eps * np.abs(values).max() ** 2
    for k in order[:REFINED]:
        if doubt <= DOUBTFUL * abs(values[k]) ** 2 or abs(values[k]) == 0.0:
            continue
        value, shape = values[k], vectors[:, k]
        for _ in range(ITERATIONS):
            with suppress(np.linalg.LinAlgError):  # exactly singular: the value is exact
                shape = np.linalg.solve(
                    value**2 * mass + value * damping + stiffness, (2.0 * value * mass + damping) @ shape
                )
            shape /= np.linalg.norm(shape)
            roots = np.roots([shape.conj() @ matrix @ shape for matrix in pencil])
            value = roots[np.argmin(np.abs(roots - value))]
        values[k], vectors[:, k] = value, shape
    return values, vectors


def rounding(pencil: Pencil, values: ComplexArray, vectors: ComplexArray) -> Array:
    """Bound of the error of eigenvalues [1/s] by the rounding of the entries of the matrices, shape (k,).

    4 eps |v| (|s|^2 |M| + |s| |C| + |K|) |v| over |v (2 s M + C) v| (Tisseur 2000, theorem 5, by entries; an entry is
    the sum of some products, and the largest error over 1 eps among drawn rotors was 2.5, of a rotor on no springs).
    """
    size, amount = np.abs(vectors), np.abs(values)
    moved = sum(abs(matrix) @ size * amount**power for matrix, power in zip(pencil, (2, 1, 0), strict=True))
    slope = 2.0 * values * (pencil.mass @ vectors) + pencil.damping @ vectors
    own = np.abs((vectors.conj() * slope).sum(axis=0))
    return np.asarray(4.0 * np.finfo(float).eps * (size * moved).sum(axis=0) / np.maximum(own, 1e-300))


def at_least(change: complex, *least: float) -> complex:
    """Change of an eigenvalue, each part with at least the size of the errors by rounding [1/s]."""
    return complex(*(np.copysign(max(abs(part), *least), part) for part in (change.real, change.imag)))


def normed(shape: ComplexArray) -> ComplexArray:
    """Shape whose largest entry is 1."""
    largest = shape[int(np.argmax(np.abs(shape)))]
    return shape / largest if largest != 0.0 else shape


def modes_near(
    pencil: Pencil, shift: complex = SHIFT, count: int = NEAREST, accuracy: float = 0.0
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues nearest to a point [rad/s], as of `nearest_to`, and their shapes as columns.

    Position and velocity are eliminated by hand: a system of m unknowns is solved in place of 2 m.
    """
    size = pencil.mass.shape[0]
    mass, damping, stiffness = map(scipy.sparse.csc_array, pencil)
    inverse = scipy.sparse.linalg.splu((stiffness + shift * damping + shift**2 * mass).tocsc())
    kind = np.result_type(mass.dtype, damping.dtype, stiffness.dtype, type(shift))

    def product(z: NDArray[Any]) -> NDArray[Any]:
        ahead = z[size:] + shift * z[:size]
        position = -inverse.solve(mass @ ahead + damping @ z[:size])
        return np.concatenate([position, z[:size] + shift * position])

    values, vectors = nearest_to(product, 2 * size, kind, shift, count, accuracy)
    return values, vectors[:size]


def nearest_to(
    product: Callable[[NDArray[Any]], NDArray[Any]],
    size: int,
    kind: Any,
    shift: complex = SHIFT,
    count: int = NEAREST,
    accuracy: float = 0.0,
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues s of A z = s B z nearest to a point, their vectors as columns: Arnoldi's method, shifted, inverted.

    Args:
        product: Product of (A - shift B)^-1 B with a vector, shape (k,).
        size: k.
        kind: Type of the vectors.
        shift: The point [rad/s].
        count: Number of eigenvalues.
        accuracy: Error over the size of 1 / (s - shift) that ends the iteration; 0: the least that it can tell.

    Raises:
        RunError: The iteration does not converge.
    """
    operator, few = scipy.sparse.linalg.LinearOperator((size, size), matvec=product, dtype=kind), min(count, size - 2)
    room, threads = min(max(2 * few + 1, ROOM), size), threads_of_blas(1)
    try:
        values, vectors = scipy.sparse.linalg.eigs(operator, k=few, v0=np.ones(size, kind), ncv=room, tol=accuracy)
    except scipy.sparse.linalg.ArpackError as error:
        raise RunError(f"expected the modes of the string, found none: {error}; try other elements") from error
    finally:
        threads_of_blas(threads)
    return shift + 1.0 / values, vectors


def threads_of_blas(count: int) -> int:
    """Set the number of threads of scipy's OpenBLAS; returns the number before, 0 of another BLAS, which has no change.

    In Arnoldi's method two threads wait for each other far longer than they compute: a well took 18 s of processor
    time in place of 2 s on a busy machine.
    """
    library = CDLL(scipy.linalg.cython_blas.__file__)  # and what it is linked with
    name = next((one for one in ("scipy_openblas", "openblas") if hasattr(library, f"{one}_set_num_threads")), "")
    before = library[f"{name}_get_num_threads"]() if name and count else 0
    if before:
        library[f"{name}_set_num_threads"](count)
    return int(before)


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
    """Eigenvalues [rad/s] and shapes as columns, shape (m, k), none of them neutral; of a large problem few.

    Args:
        pencil: Real matrices, full or sparse; the stiffness includes b c^T.
        delay: The delayed force.
        points: Intervals of the collocation.
    """
    m = pencil.mass.shape[0]
    transport = 2.0 / delay.time * differentiation(points)[1:]
    mass, damping, stiffness = map(scipy.sparse.csc_array, pencil)
    unit, force = scipy.sparse.diags_array(np.ones(m)), scipy.sparse.lil_array((m, points))
    force[:, [points - 1]] = delay.force[:, None]
    arm = scipy.sparse.csc_array(np.outer(transport[:, 0], delay.arm))
    left = scipy.sparse.block_array(
        [[None, unit, None], [-stiffness, -damping, force], [arm, None, scipy.sparse.csc_array(transport[:, 1:])]]
    )
    right = scipy.sparse.block_diag([unit, mass, scipy.sparse.diags_array(np.ones(points))])
    if m <= MOST_UNKNOWNS:
        values, vectors = np.linalg.eig(np.linalg.solve(right.toarray(), left.toarray()))
    else:
        inverse = scipy.sparse.linalg.splu((left - SHIFT * right).tocsc())
        values, vectors = nearest_to(lambda z: inverse.solve(right @ z), left.shape[0], left.dtype)
    kept = np.abs(values) * delay.time > NEUTRAL
    return values[kept], vectors[:m, kept]
