# SPDX-License-Identifier: Apache-2.0
"""Places of the string in its mesh."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array, Integers
from drill_twin.physics.model.mesh import Rod
from drill_twin.physics.model.shape_functions import hermite


class MeshPlaces(NamedTuple):
    """Elements that hold p places, and the shape functions there."""

    element: Integers
    """Shape (p,)."""
    xi: Array
    """Place in the element, 0 to 1, shape (p,)."""
    shape: Array
    """Shape functions and their derivatives by arc length, as of `hermite`; shape (p, 3, 4)."""


def locate(rod: Rod, arc: ArrayLike) -> MeshPlaces:
    """Locate arc lengths from the bit [m], shape (p,), in the mesh of a string."""
    at = np.asarray(arc, dtype=float).reshape(-1)
    element = np.clip(np.searchsorted(rod.arc, at, side="right") - 1, 0, rod.length.size - 1)
    xi = (at - rod.arc[element]) / rod.length[element]
    shape = [hermite(np.array([x]), float(rod.length[e]))[0] for x, e in zip(xi, element, strict=True)]
    return MeshPlaces(element.astype(np.int64), xi, np.reshape(shape, (-1, 3, 4)))
