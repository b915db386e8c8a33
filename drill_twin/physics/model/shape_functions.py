# SPDX-License-Identifier: Apache-2.0
"""Cubic Hermite shape functions at the two Gauss points of an element.

With unknowns r and r' at the nodes the centre line is C1, so curvature exists everywhere, and two points integrate a
straight beam's bending energy exactly. Stretch is sampled elsewhere (`drill_twin.physics.model.stretch`).
"""

import numpy as np

from drill_twin.core.arrays import Array

POINTS = 2
_XI = np.array([0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)])


def hermite(xi: Array, h: float) -> Array:
    """Values, first and second derivatives by arc length of the four shape functions.

    Args:
        xi: Place in the element, 0 to 1, shape (m,).
        h: Element length [m].

    Returns:
        Shape (m, 3, 4): derivative order 0, 1, 2 for r_0, r'_0, r_1, r'_1.
    """
    x, one = xi, np.ones_like(xi)
    value = [1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)]
    first = [(6 * x**2 - 6 * x) / h, 1 - 4 * x + 3 * x**2, (6 * x - 6 * x**2) / h, 3 * x**2 - 2 * x]
    second = [(12 * x - 6) / h**2, (6 * x - 4) / h, (6 - 12 * x) / h**2, (6 * x - 2) / h]
    return np.stack([np.stack([f * one for f in row], -1) for row in (value, first, second)], 1)


def gauss_places() -> Array:
    """Places of the two Gauss points in an element, 0 to 1, shape (2,); each weighs half the element."""
    return _XI.copy()


def element_mass(h: float) -> Array:
    """Consistent mass of a unit line density for r_0, r'_0, r_1, r'_1, shape (4, 4)."""
    return (h / 420.0) * np.array(
        [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
        ]
    )
