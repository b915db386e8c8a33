# SPDX-License-Identifier: Apache-2.0
"""Linear finite elements of a shaft with discs and bearings, many rotors at once.

A uniform Euler-Bernoulli shaft with rotary inertia on cubic elements, which are exact in statics where discs and
bearings sit at nodes; a probe reads the shape functions (Genta 2005, section 4; Friswell et al. 2010, chapter 5).
The code shares nothing with drill_twin's model.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEEL_DENSITY = 7850.0  # [kg/m3]

_STIFFNESS = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
_MASS = np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
_ROTARY = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30


def mesh(breaks: Real, parts: int) -> Real:
    """Return nodes [m] with equal parts between breaks [m] of shape (n, k): (n, (k - 1) parts + 1)."""
    steps = breaks[:, :-1, None] + np.diff(breaks, axis=1)[..., None] * (np.arange(parts) / parts)
    return np.concatenate([steps.reshape(len(breaks), -1), breaks[:, -1:]], axis=1)


@dataclass(frozen=True)
class Bearings:
    """Supports of n rotors: places [m], shape (n, bearings); 2 x 2 matrices, shape (n, bearings, 2, 2)."""

    places: Real
    stiffness: Real  # [N/m], rows and columns x, y
    damping: Real  # [N s/m]
    rotational: Real  # [N m/rad], shape (n, bearings)


@dataclass(frozen=True)
class Discs:
    """Rigid thin discs of n rotors, every array of shape (n, discs)."""

    places: Real  # [m]
    mass: Real  # [kg]
    diametral: Real  # [kg m2]
    polar: Real  # [kg m2]
    damping: Real  # [N s/m], of the disc against the room, alike in x and y


@dataclass(frozen=True)
class Rotors:
    """N rotors with one count of nodes; coordinates a node: x [m], slope of x [rad], then the same in y."""

    nodes: Real  # [m] along the shaft, rising, shape (n, nodes)
    bending_stiffness: Real  # [N m2], shape (n,)
    mass_per_length: Real  # [kg/m], shape (n,)
    diameter: float  # [m]
    discs: Discs
    bearings: Bearings

    def shapes(self, places: Real, *, slope: bool = False) -> Real:
        """Return the displacement (or slope [1/m]) at places [m] of shape (n, k) in nodal coordinates, (n, k, dof)."""
        at = (places[:, :, None] >= self.nodes[:, None, 1:-1]).sum(axis=2)
        start = np.take_along_axis(self.nodes, at, axis=1)
        size = np.take_along_axis(self.nodes, at + 1, axis=1) - start
        s = (places - start) / size
        if slope:
            bent = 6 * (s * s - s) / size
            local = [bent, 3 * s * s - 4 * s + 1, -bent, 3 * s * s - 2 * s]
        else:
            local = [
                1 - 3 * s**2 + 2 * s**3,
                size * (s - 2 * s**2 + s**3),
                3 * s**2 - 2 * s**3,
                size * (s**3 - s**2),
            ]
        whole = np.zeros((*places.shape, 2 * self.nodes.shape[1]))
        for corner in range(4):
            np.put_along_axis(whole, (2 * at + corner)[..., None], local[corner][..., None], axis=-1)
        return whole

    def _assembled(self, element: Real, power: int) -> Real:
        """Return the matrix of the shaft for an element matrix times its length to a power, (n, dof, dof)."""
        size = np.diff(self.nodes, axis=1)
        whole = np.zeros((len(size), 2 * self.nodes.shape[1], 2 * self.nodes.shape[1]))
        for i in range(size.shape[1]):
            scale = np.stack([np.ones_like(size[:, i]), size[:, i]] * 2, axis=1)
            local = element * scale[:, :, None] * scale[:, None, :] * (size[:, i] ** power)[:, None, None]
            whole[:, 2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += local
        return whole

    @cached_property
    def matrices(self) -> tuple[Real, Real, Real, Real]:
        """Mass, damping, gyroscopic (to be multiplied by the speed) and stiffness matrix, each (n, 2 dof, 2 dof)."""
        count, half = len(self.nodes), 2 * self.nodes.shape[1]
        bending = self.bending_stiffness[:, None, None] * self._assembled(_STIFFNESS, -3)
        line = self.mass_per_length[:, None, None]
        radius2 = self.diameter**2 / 16  # second moment of area over area
        shaft = line * self._assembled(_MASS, 1)
        rotary = line * radius2 * self._assembled(_ROTARY, -1)
        at_disc, tilt = self.shapes(self.discs.places), self.shapes(self.discs.places, slope=True)
        mass = shaft + rotary + _summed(self.discs.mass, at_disc) + _summed(self.discs.diametral, tilt)
        polar = 2 * rotary + _summed(self.discs.polar, tilt)
        air = _summed(self.discs.damping, at_disc)
        at_bearing, root = self.shapes(self.bearings.places), self.shapes(self.bearings.places, slope=True)
        turned = _summed(self.bearings.rotational, root)
        inertia, damping, gyroscopic, stiffness = (np.zeros((count, 2 * half, 2 * half)) for _ in range(4))
        sides = (slice(0, half), slice(half, 2 * half))
        for row, side in enumerate(sides):
            inertia[:, side, side] = mass
            stiffness[:, side, side] = bending + turned
            damping[:, side, side] = air
            for column, other in enumerate(sides):
                stiffness[:, side, other] += _summed(self.bearings.stiffness[:, :, row, column], at_bearing)
                damping[:, side, other] += _summed(self.bearings.damping[:, :, row, column], at_bearing)
        gyroscopic[:, sides[0], sides[1]] = polar  # forward whirl (x to y) is stiffened
        gyroscopic[:, sides[1], sides[0]] = -polar
        return inertia, damping, gyroscopic, stiffness

    def unbalance_response(self, speed: Real | float, probes: Real) -> Complex:
        """Return motion at probes [m, shape (n, k)] a unit unbalance [1 kg m] of each disc: (n, k, 2 axes, discs).

        Motion is the real part of the result times exp(i speed t) [m]; the unbalance points along x at t = 0 and turns
        from x to y. Speed [rad/s] is a number or of shape (n,).
        """
        inertia, damping, gyroscopic, stiffness = self.matrices
        turn = np.broadcast_to(np.asarray(speed, float), self.nodes.shape[:1])[:, None, None]
        dynamic = stiffness - turn**2 * inertia + 1j * turn * (damping + turn * gyroscopic)
        at_disc = self.shapes(self.discs.places)
        force = turn**2 * np.concatenate([at_disc, -1j * at_disc], axis=-1)
        answer = np.linalg.solve(dynamic, np.swapaxes(force, 1, 2))
        half = 2 * self.nodes.shape[1]
        at_probe = self.shapes(probes)
        return np.stack([at_probe @ answer[:, :half], at_probe @ answer[:, half:]], axis=2)

    def frequencies(self, speed: float) -> Complex:
        """Return the roots with positive imaginary part [rad/s], by size of it, of each rotor: shape (n, 2 dof)."""
        inertia, damping, gyroscopic, stiffness = self.matrices
        size = inertia.shape[-1]
        top = np.linalg.solve(inertia, np.concatenate([-stiffness, -(damping + speed * gyroscopic)], axis=2))
        unit = np.broadcast_to(np.eye(size), inertia.shape)
        state = np.concatenate([np.concatenate([np.zeros_like(unit), unit], axis=2), top], axis=1)
        roots = np.linalg.eigvals(state)
        order = np.argsort(np.where(roots.imag > 0, roots.imag, np.inf), axis=1)
        return np.take_along_axis(roots, order, axis=1)[:, :size]


def _summed(weights: Real, shapes: Real) -> Real:
    """Return the sum over points of weight times shape times shape transposed, shape (n, dof, dof)."""
    return (weights[..., None] * shapes).swapaxes(1, 2) @ shapes
