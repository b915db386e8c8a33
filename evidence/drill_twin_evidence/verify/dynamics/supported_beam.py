# SPDX-License-Identifier: Apache-2.0
"""Frequencies of a beam that lies on the low side of a straight hole, by numpy and scipy alone.

Independent of `drill_twin`: cubic beam elements with the geometric stiffness of the axial load, pinned at the bit and
clamped at the top on the axis, moving in both planes. The wall holds with the force K d^1.5 per length at two Gauss
points of an element. Friction mu of a string that turns pushes each contact point around the hole. Omitted are inner
damping, torque, and stretch.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csc_array, diags_array
from scipy.sparse.linalg import LinearOperator, eigs, splu, spsolve

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Solve = Callable[[Complex], Complex]
GAUSS = 0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)
FIRST, LEAST, MOST = 0.02, 5e-3, 1e3
"""Step of Newton's method as a time over which inertia holds changes small: the first, and its bounds [s]."""
HELD = 10.0
"""Length over which the first guess goes from the axis at an end to the wall [m]."""
STEPS, TOLERANCE = 400, 1e-7
"""Of Newton's method; the tolerance is over the largest weight of an element."""


class Piece(NamedTuple):
    """A uniform part of the beam."""

    length: float
    """[m]."""
    bending: float
    """EI [N m2]."""
    line_mass: float
    """That moves across [kg/m]."""
    across: float
    """Weight across the hole [N/m]."""
    along: float
    """Weight along the hole [N/m]."""
    clearance: float
    """Radius of the hole less that of the beam [m]."""


class Beam(NamedTuple):
    """A beam on the low side, from the bit up."""

    pieces: tuple[Piece, ...]
    load: float
    """Weight on bit [N]."""
    stiffness: float
    """K of the wall [N/m^2.5]."""
    friction: float = 0.0
    """mu [-]."""
    absorbed_from: float = math.inf
    """Distance from the bit [m] from which motion is absorbed, the more the higher."""
    absorption: float = 0.0
    """Rate of that at the top [1/s]."""
    spacing: float = 0.25
    """Largest length of an element [m]."""


class Matrices(NamedTuple):
    """Of one plane, m deflections and slopes."""

    arc: Array
    """Nodes from the bit [m]."""
    mass: csc_array
    absorption: csc_array
    stiffness: csc_array
    weight: Array
    """[N, N m], shape (m,)."""
    points: csc_array
    """From unknowns to the deflection at the Gauss points."""
    share: Array
    """Length of each Gauss point [m]."""
    clearance: Array
    """There [m]."""


def symmetric(a: Array, b: Array, c: Array, d: Array, e: Array, f: Array | None = None) -> Array:
    """Matrices of elements for deflection and slope at both ends; `f` couples a deflection with the other slope."""
    f = b if f is None else f
    rows = ((a, b, c, f), (b, d, -f, e), (c, -f, a, -b), (f, e, -b, d))
    return np.stack([np.stack(row, -1) for row in rows], 1)


def matrices(beam: Beam) -> Matrices:
    """Matrices of a beam."""
    counts = [math.ceil(piece.length / beam.spacing) for piece in beam.pieces]
    h = np.repeat([piece.length / count for piece, count in zip(beam.pieces, counts, strict=True)], counts)
    _, bending, mass, across, along, clearance = (np.repeat(values, counts) for values in np.transpose(beam.pieces))
    arc, one = np.append(0.0, np.cumsum(h)), np.ones_like(h)
    tension = np.cumsum(along * h) - 0.5 * along * h - beam.load
    number = 2 * np.arange(h.size)[:, None] + np.arange(4)
    row, column = np.repeat(number, 4, axis=1).ravel(), np.tile(number, (1, 4)).ravel()
    size = 2 * (h.size + 1)

    def whole(factor: Array, elements: Array) -> csc_array:
        return csc_array(((factor[:, None, None] * elements).ravel(), (row, column)), shape=(size, size))

    inertia = symmetric(156 * one, 22 * h, 54 * one, 4 * h * h, -3 * h * h, -13 * h)
    middle = 0.5 * (arc[1:] + arc[:-1])
    rise = np.clip((middle - beam.absorbed_from) / max(arc[-1] - beam.absorbed_from, 1e-9), 0.0, 1.0)
    stiff = whole(bending / h**3, symmetric(12 * one, 6 * h, -12 * one, 4 * h * h, 2 * h * h)) + whole(
        tension / (30 * h), symmetric(36 * one, 3 * h, -36 * one, 4 * h * h, -h * h)
    )
    weight = np.zeros(size)
    np.add.at(weight, number, (across * h)[:, None] * np.stack([0.5 * one, h / 12, 0.5 * one, -h / 12], 1))
    shapes = [
        np.stack([one * (1 - 3 * x**2 + 2 * x**3), h * (x - 2 * x**2 + x**3), one * (3 * x**2 - 2 * x**3),
                  h * (x**3 - x**2)], 1)
        for x in GAUSS
    ]  # fmt: skip
    point = np.repeat(np.arange(2 * h.size), 4)
    points = csc_array((np.concatenate(shapes).ravel(), (point, np.tile(number.ravel(), 2))), shape=(2 * h.size, size))
    return Matrices(
        arc,
        whole(mass * h / 420, inertia),
        whole(beam.absorption * rise**2 * mass * h / 420, inertia),
        stiff,
        weight,
        points,
        np.tile(0.5 * h, 2),
        np.tile(clearance, 2),
    )


def contact(beam: Beam, of: Matrices, x: Array, y: Array) -> tuple[Array, Array, list[list[Array]]]:
    """Forces on the Gauss points [N], and minus their derivatives by x and y [N/m]."""
    radius = np.maximum(np.hypot(x, y), 1e-12)
    depth = np.maximum(radius - of.clearance, 0.0)
    force, slope = beam.stiffness * of.share * depth**1.5, 1.5 * beam.stiffness * of.share * np.sqrt(depth)
    normal, around = (x / radius, y / radius), (-y / radius, x / radius)
    held = [n + beam.friction * c for n, c in zip(normal, around, strict=True)]
    turned = [c - beam.friction * n for n, c in zip(normal, around, strict=True)]
    derivative = [
        [slope * held[i] * normal[k] + force / radius * turned[i] * around[k] for k in range(2)] for i in range(2)
    ]
    return -force * held[0], -force * held[1], derivative


def at_rest(beam: Beam, of: Matrices, free: NDArray[np.int64]) -> csc_array:
    """Stiffness of the free unknowns of both planes about the balance on the low side.

    Raises:
        ValueError: No balance is found.
    """
    size, transposed = of.weight.size, of.points.T
    both, mass = (block_array([[one, None], [None, one]]) for one in (of.stiffness, of.mass))
    load = np.append(of.weight, np.zeros(size))
    ends = np.clip(np.minimum(of.arc, of.arc[-1] - of.arc) / HELD, 0.0, 1.0)
    gap = np.append(of.clearance[: of.arc.size - 1], 0.0) * ends
    climb = math.atan(beam.friction)
    u = np.zeros(2 * size)
    u[0:size:2], u[size::2] = gap * math.cos(climb), -gap * math.sin(climb)
    step, last = FIRST, math.inf
    for _ in range(STEPS):
        x_force, y_force, derivative = contact(beam, of, of.points @ u[:size], of.points @ u[size:])
        residual = load - both @ u + np.append(transposed @ x_force, transposed @ y_force)
        walls = [[transposed @ diags_array(value) @ of.points for value in row] for row in derivative]
        tangent = csc_array(both + block_array(walls))[free][:, free]
        largest = float(np.abs(residual[free]).max())
        if largest < TOLERANCE * load.max():
            return tangent
        step = float(np.clip(step * np.clip(last / largest, 0.5, 3.0), LEAST, MOST))
        last = largest
        change = spsolve(csc_array(tangent + csc_array(mass)[free][:, free] / step**2), residual[free])
        u[free] += change * min(1.0, 0.5 * gap.max() / float(np.abs(change).max()))
    raise ValueError(f"expected a beam at rest on the low side, found a residual of {last:.3g} N")


class Found(NamedTuple):
    """A mode."""

    eigenvalue: complex
    """Growth and angular frequency [1/s]."""
    at: float
    """Place of the largest motion, from the bit [m]."""
    up_down: float
    """Share of the squared motion that is up and down [-]."""


def _inverse(solve: Solve, mass: csc_array, damping: csc_array, shift: complex, vector: Complex) -> Complex:
    """(A - shift B)^-1 B of the companion form, whose vectors are the shape and the shape times the eigenvalue."""
    place, rate = np.split(vector, 2)
    moved = solve(-(mass @ rate) - damping @ place - shift * (mass @ place))
    return np.append(moved, place + shift * moved)


def modes_near(beam: Beam, near: list[float], count: int = 12) -> list[Found]:
    """Modes nearest to each of some angular frequencies [rad/s], `count` for each; sorted by frequency, each once.

    Raises:
        ValueError: The beam has no balance.
    """
    terms = matrices(beam)
    size = terms.weight.size
    one = np.setdiff1d(np.arange(size), [0, size - 2, size - 1])
    free = np.append(one, one + size)
    stiffness = at_rest(beam, terms, free)
    mass, damping = (
        csc_array(block_array([[part, None], [None, part]]))[free][:, free] for part in (terms.mass, terms.absorption)
    )
    found: list[Found] = []
    for shift in (1j * frequency for frequency in near):
        solve = splu(csc_array(stiffness + shift * damping + shift**2 * mass)).solve
        operator = LinearOperator(
            (2 * free.size, 2 * free.size), partial(_inverse, solve, mass, damping, shift), dtype=complex
        )
        values, vectors = eigs(operator, k=count, v0=np.ones(2 * free.size, complex))
        for value, vector in zip(shift + 1.0 / values, vectors.T, strict=True):
            if any(abs(value - other.eigenvalue) < 1e-6 * abs(value) for other in found):
                continue
            shape = np.zeros(2 * size, complex)
            shape[free] = vector[: free.size]
            x, y = abs(shape[0:size:2]) ** 2, abs(shape[size::2]) ** 2
            found.append(Found(complex(value), float(terms.arc[np.argmax(x + y)]), float(x.sum() / (x + y).sum())))
    return sorted(found, key=lambda mode: mode.eigenvalue.imag)
