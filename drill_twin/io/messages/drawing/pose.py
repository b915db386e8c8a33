# SPDX-License-Identifier: Apache-2.0
"""Orientation of a section as a quaternion: the spin about z, then the shortest rotation of z onto the tangent."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array

_ANTIPARALLEL = 1e-12


def orientation(tangents: Array, spin: Array, out: Array) -> Array:
    """Unit quaternions x y z w of sections with these tangents and spins [rad].

    With a = (-t_y, t_x, 0, 1 + t_z)/sqrt(2 + 2 t_z), the shortest rotation of z onto t, the result is a times the
    rotation by the spin about z. A tangent straight down (t_z = -1) has no shortest rotation; the one about y is used.

    Args:
        tangents: Unit tangents, shape (..., 3).
        spin: Spins [rad], shape (...,).
        out: Result, written and returned, shape (..., 4).
    """
    half = 0.5 * spin
    cosine, sine = np.cos(half), np.sin(half)
    up = np.maximum(0.5 + 0.5 * tangents[..., 2], _ANTIPARALLEL)
    scalar = np.sqrt(up)
    x = -0.5 * tangents[..., 1] / scalar
    y = 0.5 * tangents[..., 0] / scalar
    down = up <= _ANTIPARALLEL
    if down.any():
        x[down], y[down], scalar[down] = 0.0, 1.0, 0.0
    out[..., 0] = x * cosine + y * sine
    out[..., 1] = y * cosine - x * sine
    out[..., 2] = scalar * sine
    out[..., 3] = scalar * cosine
    return out


def spin_of(quaternions: Array) -> Array:
    """Spins [rad], in (-2 pi, 2 pi], of quaternions x y z w, shape (..., 4): the inverse of `orientation`."""
    return 2.0 * np.arctan2(quaternions[..., 2], quaternions[..., 3])


def tangent_of(quaternions: Array) -> Array:
    """Unit tangents, shape (..., 3), of quaternions x y z w, shape (..., 4): the directions of their z axes."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    return np.stack((2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)), axis=-1)
