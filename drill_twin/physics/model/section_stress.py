# SPDX-License-Identifier: Apache-2.0
"""Stress at cross-sections: strain of the turning material, bending stress of a shape, what is read of a section."""

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.mesh import SPIN, Rod, element_unknowns, hermite, youngs_modulus
from drill_twin.physics.model.strain import strain_at

SCALARS = ("moment_x", "moment_y", "axial_force", "stress", "largest_stress", "cycles", "damage")
"""Bending moments that curve the string towards x and y of the turning material [N m], axial force [N], largest normal
stress at the surface now and so far [Pa], stress cycles and damage of the fibre with the most damage."""
MOMENT_X, MOMENT_Y, AXIAL_FORCE, STRESS, LARGEST_STRESS, CYCLES, DAMAGE = range(len(SCALARS))


def strain_samples(rod: Rod, element: NDArray[np.int64], share: Array) -> Array:
    """Weights of the stretch at the ends and at the inner sample of its element for that at a section, shape (s, 3).

    Quadratic in the element; next to a change of section the inner sample alone, which carries the force.

    Args:
        rod: The string.
        element: Element of each section, shape (s,).
        share: Coordinate in it, 0 to 1, shape (s,).
    """
    jump = np.concatenate([[False], np.diff(rod.axial) != 0.0, [False]])
    alone = (jump[element] | jump[element + 1])[:, None]
    quadratic = [2.0 * (share - 0.5) * (share - 1.0), 2.0 * share * (share - 0.5), 4.0 * share * (1.0 - share)]
    return np.where(alone, [0.0, 0.0, 1.0], np.stack(quadratic, -1))


@kernel
def out_of_frame(frame: Array, x: float, y: float, z: float) -> Triple:
    """Rotate a vector out of the frame of the bit."""
    return (
        frame[0, 0] * x + frame[1, 0] * y + frame[2, 0] * z,
        frame[0, 1] * x + frame[1, 1] * y + frame[2, 1] * z,
        frame[0, 2] * x + frame[1, 2] * y + frame[2, 2] * z,
    )


@kernel
def combine(w: Array, lower: Triple, slope: Triple, upper: Array) -> Triple:
    """Combination of r and r' of the lower node, given, and the upper node, a row."""
    return (
        w[0] * lower[0] + w[1] * slope[0] + w[2] * upper[0] + w[3] * upper[3],
        w[0] * lower[1] + w[1] * slope[1] + w[2] * upper[1] + w[3] * upper[4],
        w[0] * lower[2] + w[1] * slope[2] + w[2] * upper[2] + w[3] * upper[5],
    )


@kernel
def length_of(x: float, y: float, z: float) -> float:
    """Length of a vector."""
    return float(np.sqrt(x * x + y * y + z * z))


@kernel
def material_strain(
    rod: Rod, e: int, share: float, first: Array, second: Array, samples: Array, bow: Array, frame: Array, u: Array
) -> Triple:
    """Curvature about which the turning material is bent at a section, two components [1/m], and axial strain.

    Args:
        rod: The string.
        e: Element of the section.
        share: Coordinate in it, 0 to 1.
        first: First derivatives of the shape functions there, shape (4,).
        second: Second derivatives, shape (4,).
        samples: Weights of the stretch (`strain_samples`), shape (3,).
        bow: Stress-free curvature [1/m], shape (2,).
        frame: Frame of the bit, in which its row is after a step (`drill_twin.dynamics.solver.boundary`).
        u: Rows (r, r', psi).
    """
    row, upper = u[e], u[e + 1]
    lower, slope = (row[0], row[1], row[2]), (row[3], row[4], row[5])
    if e == 0:
        lower = out_of_frame(frame, row[0] - frame[0, 3], row[1] - frame[1, 3], row[2] - frame[2, 3])
        slope = out_of_frame(frame, row[3], row[4], row[5])
    a, b = combine(first, lower, slope, upper), combine(second, lower, slope, upper)
    inner = combine(rod.inner[e], lower, slope, upper)
    stretch = (
        samples[0] * length_of(slope[0], slope[1], slope[2])
        + samples[1] * length_of(upper[3], upper[4], upper[5])
        + samples[2] * length_of(inner[0], inner[1], inner[2])
    )
    psi = (1.0 - share) * row[SPIN] + share * upper[SPIN]
    cos_psi, sin_psi, rest = np.cos(psi), np.sin(psi), (0.0, 0.0, 0.0)
    q = strain_at(e, 0, a, b, rest, rest, psi, cos_psi, sin_psi, 0.0, 0.0, 0.0)
    along = q.qz / (1.0 + q.tz)  # into the frame of the smallest rotation of z onto t, then back by the spin
    x, y = q.qx - q.tx * along, q.qy - q.ty * along
    return x * cos_psi + y * sin_psi - bow[0], y * cos_psi - x * sin_psi - bow[1], stretch - 1.0


PLACES = np.array([0.0, 0.5, 1.0])
"""Places in an element at which the curvature is evaluated."""


def curvature(rod: Rod, u: Array) -> Array:
    """Curvature r' x r'' / |r'|^3 of the centre line at the ends and the middle of each element [1/m].

    Args:
        rod: The string, n elements.
        u: Node rows (r, r', psi), shape (..., n + 1, 7).

    Returns:
        Vectors about which the string is bent, shape (..., n, 3 places, 3).
    """
    n = rod.length.size
    shape = hermite(np.tile(PLACES, n), np.repeat(rod.length, 3)).reshape(n, 3, 3, 4)
    first, second = (np.einsum("npk,...nkx->...npx", shape[:, :, order], element_unknowns(u)) for order in (1, 2))
    return np.asarray(np.cross(first, second) / np.linalg.norm(first, axis=-1, keepdims=True) ** 3)


def bending_stress(rod: Rod, u: Array) -> Array:
    """Largest bending stress of each element, at the outer fibre of its body [Pa], shape (..., n); as `curvature`."""
    return np.asarray(youngs_modulus(rod) * rod.outer_radius * np.linalg.norm(curvature(rod, u), axis=-1).max(axis=-1))
