# SPDX-License-Identifier: Apache-2.0
"""Horizontal beam on stabilisers by numpy alone: sag onto its blades, then its frequencies up-down and sideways.

Independent of `drill_twin`: cubic beam elements with the geometric stiffness of a constant axial load, pinned at the
bit, clamped at the top. A blade touches at two points with the force K d^1.5 per length. Up-down it holds with the
slope of that force, sideways, in a round hole, with the force over its distance from the hole's axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SPACING = 0.15
"""Largest length of an element [m]."""


class Blade(NamedTuple):
    """A stabiliser."""

    begin: float
    """From the bit [m]."""
    length: float
    """[m]."""
    clearance: float
    """Radius of the hole less that of the blades [m]."""


class Beam(NamedTuple):
    """A uniform beam on blades."""

    length: float
    """[m]."""
    bending: float
    """EI [N m2]."""
    line_mass: float
    """[kg/m]."""
    weight: float
    """Across the beam [N/m]."""
    compression: float
    """[N]."""
    stiffness: float
    """K of the wall [N/m^2.5]."""
    blades: tuple[Blade, ...]


def symmetric(a: float, b: float, c: float, d: float, e: float, f: float | None = None) -> Array:
    """Matrix of an element for deflection and slope at both ends; `f` couples a deflection with the other slope."""
    f = b if f is None else f
    return np.array([[a, b, c, f], [b, d, -f, e], [c, -f, a, -b], [f, e, -b, d]])


def frequencies(beam: Beam, count: int) -> tuple[Array, Array]:
    """Natural frequencies [rad/s] up-down and sideways, lowest first, shape (count,) each."""
    size = math.ceil(beam.length / SPACING)
    h = beam.length / size
    bend = beam.bending / h**3 * symmetric(12, 6 * h, -12, 4 * h * h, 2 * h * h)
    load = beam.compression / (30 * h) * symmetric(36, 3 * h, -36, 4 * h * h, -h * h)
    inertia = beam.line_mass * h / 420 * symmetric(156, 22 * h, 54, 4 * h * h, -3 * h * h, -13 * h)
    unknowns = 2 * (size + 1)
    stiff, mass, weight = np.zeros((unknowns, unknowns)), np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    for e in range(size):
        own = slice(2 * e, 2 * e + 4)
        stiff[own, own] += bend - load
        mass[own, own] += inertia
        weight[own] += beam.weight * h * np.array([0.5, h / 12, 0.5, -h / 12])
    rows, clearances, shares = [], [], []
    for blade in beam.blades:
        for place in (0.5 - 0.5 / math.sqrt(3), 0.5 + 0.5 / math.sqrt(3)):
            x = (blade.begin + place * blade.length) / h
            e = min(int(x), size - 1)
            x -= e
            row = np.zeros(unknowns)
            row[2 * e : 2 * e + 4] = [1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3),
                                      3 * x**2 - 2 * x**3, h * (x**3 - x**2)]  # fmt: skip
            rows.append(row)
            clearances.append(blade.clearance)
            shares.append(0.5 * blade.length)
    at, clearance, hertz = np.array(rows), np.array(clearances), beam.stiffness * np.array(shares)
    free = np.setdiff1d(np.arange(unknowns), [0, unknowns - 2, unknowns - 1])
    sag = np.zeros(unknowns)
    for _ in range(200):  # Newton's method with a short step
        depth = np.maximum(at @ sag - clearance, 0.0)
        slope = 1.5 * hertz * np.sqrt(np.maximum(depth, 1e-7))
        tangent = stiff + at.T @ (slope[:, None] * at)
        change = np.linalg.solve(tangent[np.ix_(free, free)],
                                 (weight - stiff @ sag - at.T @ (hertz * depth**1.5))[free])  # fmt: skip
        sag[free] += change * min(1.0, 2e-4 / float(np.abs(change).max()))
        if float(np.abs(change).max()) < 1e-12:
            break
    else:
        raise ValueError("expected a beam at rest on its blades, found none")
    depth = np.maximum(at @ sag - clearance, 0.0)
    part = np.ix_(free, free)
    found = []
    for held in (1.5 * hertz * np.sqrt(depth), hertz * depth**1.5 / np.maximum(at @ sag, 1e-12)):
        whole = stiff + at.T @ (held[:, None] * at)
        found.append(np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass[part], whole[part])).real)[:count]))
    return found[0], found[1]
