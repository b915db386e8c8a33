# SPDX-License-Identifier: Apache-2.0
"""Stability limit of an explicit scheme for the linear forces of a string, for comparison with the implicit one."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from drill_twin.core.arrays import Array
from drill_twin.physics.model.mesh import Rod


def explicit_limit(rod: Rod, *, damping_time: float = 0.0, drag: float = 0.0, wall: float = 0.0) -> float:
    """Largest stable step of central differences with lagged damping, for lateral motion [s].

    2 / w (sqrt(1 + z^2) - z) over all modes, with w their frequency and z their damping ratio (Belytschko, Liu and
    Moran 2000, section 6.2). The damping is the sum of a part proportional to bending and a part proportional to mass.

    Args:
        rod: The string; its ends are free, which bounds every other boundary condition.
        damping_time: Retardation time of bending [s].
        drag: Linear drag per length [N s/m2].
        wall: Stiffness of a linear wall in contact along the whole string [N/m2].
    """
    size = 2 * rod.arc.size
    mass, bend, bed = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    for e in range(rod.length.size):
        own = slice(2 * e, 2 * e + 4)
        mass[own, own] += rod.mass[e]
        bend[own, own] += rod.bending[e] * rod.pairs[e, :, 4].sum(axis=0).reshape(4, 4)
        bed[own, own] += rod.pairs[e, :, 0].sum(axis=0).reshape(4, 4)
    squares, shapes = eigh(bend + wall * bed, mass)
    loss = np.einsum("ik,ij,jk->k", shapes, damping_time * bend + drag * bed, shapes)
    moving = squares > 1e-6 * squares.max()
    w, c = np.sqrt(squares[moving]), loss[moving]
    limits: Array = 2.0 / w * (np.sqrt(1.0 + (0.5 * c / w) ** 2) - 0.5 * c / w)
    return float(limits.min())
