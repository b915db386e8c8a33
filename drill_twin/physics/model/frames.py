# SPDX-License-Identifier: Apache-2.0
"""Smallest rotation of the z axis onto a tangent, from which the spin is counted."""

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel


@kernel
def rotate_to_tangent(tx: float, ty: float, tz: float, x: float, y: float) -> Triple:
    """Rotate a direction (x, y, 0) by the smallest rotation that takes z to the unit vector t."""
    across = x * tx + y * ty
    share = across / (1.0 + tz)
    return x - tx * share, y - ty * share, -across


def transverse_axes(tangent: Array) -> tuple[Array, Array]:
    """Axes x and y of the frame `hole`, turned by the smallest rotation of z onto the tangent; shape (..., 3) each."""
    x, y, z = tangent[..., 0], tangent[..., 1], tangent[..., 2]
    fold = 1.0 + z
    return (
        np.stack((1.0 - x * x / fold, -x * y / fold, -x), axis=-1),
        np.stack((-x * y / fold, 1.0 - y * y / fold, -y), axis=-1),
    )
