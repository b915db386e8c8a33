# SPDX-License-Identifier: Apache-2.0
"""Bending stress of a string from its shape."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model.mesh import Rod, Tube
from drill_twin.physics.model.shape_functions import hermite

PLACES = np.array([0.0, 0.5, 1.0])
"""Places in an element at which the curvature is evaluated."""


def curvature(rod: Rod, u: Array) -> Array:
    """Curvature |r' x r''| / |r'|^3 of the centre line at the ends and the middle of each element [1/m], shape (n, 3).

    Args:
        rod: The string, n elements.
        u: Node rows (r, r', psi), shape (n + 1, 7).
    """
    lengths, place = np.unique(rod.length, return_inverse=True)
    shape = np.stack([hermite(PLACES, float(length)) for length in lengths])[place]
    ends = np.stack([u[:-1, 0:3], u[:-1, 3:6], u[1:, 0:3], u[1:, 3:6]], 1)
    first, second = (np.einsum("npk,nkx->npx", shape[:, :, order], ends) for order in (1, 2))
    return np.asarray(np.linalg.norm(np.cross(first, second), axis=-1) / np.linalg.norm(first, axis=-1) ** 3)


def bending_stress(rod: Rod, tubes: list[Tube], u: Array) -> Array:
    """Largest bending stress E r_o |q| of each element, at the outer fibre of its body [Pa], shape (n,).

    Args:
        rod: The string, n elements.
        tubes: Its uniform pieces from the bit up.
        u: Node rows (r, r', psi), shape (n + 1, 7).
    """
    tops = np.cumsum([tube.length for tube in tubes])
    middles = 0.5 * (rod.arc[:-1] + rod.arc[1:])
    modulus = np.array([tube.youngs_modulus for tube in tubes])[np.searchsorted(tops[:-1], middles)]
    return np.asarray(modulus * rod.outer_radius * curvature(rod, u).max(axis=1))
