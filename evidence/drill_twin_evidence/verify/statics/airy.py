# SPDX-License-Identifier: Apache-2.0
"""Buckling loads of a string under its own weight: closed form in Airy functions."""

from __future__ import annotations

from functools import cache

import numpy as np

from drill_twin.core.arrays import Array

# Constraints at the bit: lateral position, slope.
_HOLDS = {"guided": (True, True), "pinned": (True, False), "sliding": (False, True), "free": (False, False)}


@cache
def critical_bit_load(bending: float, weight: float, length: float, bit_end: str) -> float:
    """Lowest weight on bit at which a vertical string, clamped at its top, buckles [N].

    At the arc s from the bit the slope obeys EI y''' + (F - w s) y' = c, c the side force at the bit (Lubinski 1950).
    With x = (s - F / w) / (EI / w)^(1/3): y' = a Ai(x) + b Bi(x) + c Hi(x) + ..., where the particular solution is
    made by variation of constants.

    Args:
        bending: EI [N m2].
        weight: Weight per length [N/m].
        length: Length of the string [m].
        bit_end: "guided", "pinned", "sliding" or "free".
    """
    from scipy.optimize import brentq

    unit = (bending / weight) ** (1.0 / 3.0)
    span = length / unit

    def determinant(load: float) -> float:
        return _determinant(load, span, *_HOLDS[bit_end])

    loads = np.linspace(0.05, 12.0, 60)
    values = [determinant(load) for load in loads]
    first = next(i for i in range(loads.size - 1) if values[i] * values[i + 1] < 0.0)
    root = float(brentq(determinant, loads[first], loads[first + 1], xtol=1e-12))
    return float(root * weight * unit)


def _determinant(load: float, span: float, place: bool, slope: bool) -> float:
    """Determinant that is zero where a bent equilibrium exists; load in w (EI / w)^(1/3), span in (EI / w)^(1/3)."""
    from scipy.special import airy

    nodes, weights = np.polynomial.legendre.leggauss(60)
    x = -load + 0.5 * span * (nodes + 1.0)
    ends = np.array([-load, span - load])

    def solutions(at: Array) -> Array:
        """Ai, Bi and a solution of theta'' - x theta = 1, and their slopes, shape (2, 3, points)."""
        ai, dai, bi, dbi = airy(at)
        s, w = 0.5 * (at[:, None] + load) * (nodes + 1.0) - load, 0.5 * (at[:, None] + load) * weights
        a, _, b, _ = airy(s)
        ia, ib = np.sum(w * a, 1), np.sum(w * b, 1)
        return np.array([[ai, bi, np.pi * (bi * ia - ai * ib)], [dai, dbi, np.pi * (dbi * ia - dai * ib)]])

    bit_and_top = solutions(ends)
    at_bit = bit_and_top[0 if slope else 1, :, 0]
    at_top = bit_and_top[0, :, 1]
    if not place:
        return float(np.linalg.det(np.array([at_bit[:2], at_top[:2]])))
    area = 0.5 * span * solutions(x)[0] @ weights
    return float(np.linalg.det(np.array([at_bit, at_top, area])))
