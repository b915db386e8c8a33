# SPDX-License-Identifier: Apache-2.0
"""Steady whirl of a rod and its stability by equations of its own: the reference of `contact.whirl_states`.

Nothing of drill_twin is imported. The centre line z = x + i y of an Euler-Bernoulli beam turns with omega; drag brakes
it, damping of the material acts in the frame of the rod, the wall presses as K d^1.5 (1 + chi d_dot) and rubs by
mu / (1 + delta s). Contact is summed at any number of Gauss points in each cubic element, its tangents are taken by
complex steps (Squire and Trapp 1998).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Physics(NamedTuple):
    """Numbers of rod, hole and set-points; SI."""

    length: float
    bending: float
    line_mass: float
    line_weight: float
    retardation: float
    drag: float
    clearance: float
    outer_radius: float
    wall_stiffness: float
    wall_damping: float
    friction: float
    decay: float
    creep: float
    load: float
    rotation: float
    bit_friction: float | None = None
    """Coefficient under a bit that slides; None: the bit is held on the axis."""
    bit_radius: float = 1.0


def wall_damping(restitution: float, speed: float) -> float:
    """Factor chi [s/m] of a wall by its restitution at a speed: a = chi v, a - ln(1 + a) = -e a - ln(1 - e a)."""

    def excess(a: float) -> float:
        return a * (1.0 + restitution) - float(np.log1p(a)) + float(np.log1p(-restitution * a))

    return float(brentq(excess, 1e-6, (1.0 - 1e-12) / restitution)) / speed


class WhirlingRod:
    """Mesh of equal cubic elements; unknowns z and z' of each node from the bit up."""

    def __init__(self, physics: Physics, elements: int, points: int) -> None:
        """Assemble the linear part with four Gauss points, and contact with `points` of them in each element."""
        self.physics, n = physics, elements
        h = physics.length / n
        self.nodes = np.linspace(0.0, physics.length, n + 1)
        weights, (_, slope, curvature), at = self._shapes(4, n, h)
        value = self._shapes(4, n, h)[1][0]
        force = physics.line_weight * at - physics.load
        bent = physics.bending * curvature.T @ (weights[:, None] * curvature)
        whole = value.T @ (weights[:, None] * value)
        kept = np.arange(2, 2 * n)
        if physics.bit_friction is not None:
            kept = np.insert(kept, 0, 0)
        self.kept, part = kept, np.ix_(kept, kept)
        self.mass = (physics.line_mass * whole)[part].astype(complex)
        self.damping = (physics.drag * whole + physics.retardation * bent)[part].astype(complex)
        stiff = bent + slope.T @ ((weights * force)[:, None] * slope)
        self.stiffness = (stiff - 1j * physics.rotation * physics.retardation * bent)[part]
        weights, (value, _, _), _ = self._shapes(points, n, h)
        self.weights, self.at_contact = weights, value[:, kept]

    @staticmethod
    def _shapes(points: int, n: int, h: float) -> tuple[Real, tuple[Real, Real, Real], Real]:
        """Weights, shape functions with two derivatives as rows of a whole matrix, and places of Gauss points."""
        x, weight = np.polynomial.legendre.leggauss(points)
        x = 0.5 * (x + 1.0)
        orders = (
            (1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)),
            ((6 * x**2 - 6 * x) / h, 1 - 4 * x + 3 * x**2, (6 * x - 6 * x**2) / h, 3 * x**2 - 2 * x),
            ((12 * x - 6) / h**2, (6 * x - 4) / h, (6 - 12 * x) / h**2, (6 * x - 2) / h),
        )
        rows = [np.zeros((n * points, 2 * n + 2)) for _ in orders]
        for e in range(n):
            for matrix, functions in zip(rows, orders, strict=True):
                matrix[e * points : (e + 1) * points, 2 * e : 2 * e + 4] = np.stack(functions, -1)
        places = (np.arange(n)[:, None] + x).ravel() * h
        return np.tile(0.5 * h * weight, n), (rows[0], rows[1], rows[2]), places

    def wall(self, x: Any, y: Any, vx: Any, vy: Any) -> tuple[Any, Any]:
        """Force of the wall per length by place and velocity of the centre line; analytic in each."""
        own = self.physics
        radius = np.sqrt(x * x + y * y)
        nx, ny = x / radius, y / radius
        depth = radius - own.clearance
        depth = np.where(depth.real > 0.0, depth, 0.0)
        press = own.wall_stiffness * depth * np.sqrt(depth) * (1.0 + own.wall_damping * (nx * vx + ny * vy))
        slip = nx * vy - ny * vx + own.outer_radius * own.rotation
        fast = slip * np.where(slip.real < 0.0, -1.0, 1.0)
        rub = own.friction / (1.0 + own.decay * fast) * press * slip / np.sqrt(slip**2 + own.creep**2)
        return press * nx - rub * ny, press * ny + rub * nx

    def bit(self, x: Any, y: Any, vx: Any, vy: Any) -> tuple[Any, Any]:
        """Force of the rock on a face that turns and slides: mu P v / sqrt(v^2 + (Omega r)^2)."""
        own = self.physics
        rim = own.bit_radius * own.rotation
        size = (own.bit_friction or 0.0) * own.load / np.sqrt(vx * vx + vy * vy + rim * rim)
        return size * vx + 0.0 * x, size * vy + 0.0 * y

    def _point_forces(self, q: Complex, omega: float) -> tuple[Complex, Real, Real]:
        """Contact forces on the unknowns, and their derivatives by place and by velocity, all as real pairs."""
        m = q.size
        out, by_place, by_speed = np.zeros(m, complex), np.zeros((2 * m, 2 * m)), np.zeros((2 * m, 2 * m))
        first = np.zeros((1, m))
        first[0, 0] = 1.0
        laws = [(self.wall, self.at_contact, self.weights)]
        if self.physics.bit_friction is not None:
            laws.append((self.bit, first, np.ones(1)))
        for law, rows, weights in laws:
            z, v = rows @ q, 1j * omega * (rows @ q)
            parts = [z.real, z.imag, v.real, v.imag]
            x, y = law(*(part + 0j for part in parts))
            out += rows.T @ (weights * (x.real + 1j * y.real))
            for k in range(4):
                moved = [part + (1e-30j if k == j else 0j) for j, part in enumerate(parts)]
                target = by_place if k < 2 else by_speed
                column = slice(m * (k % 2), m * (k % 2) + m)
                for row, slope in enumerate(law(*moved)):
                    target[m * row : m * row + m, column] += rows.T @ ((weights * slope.imag / 1e-30)[:, None] * rows)
        return out, by_place, by_speed

    def _tangents(self, q: Complex, omega: float) -> tuple[Complex, Real, Real, Real]:
        """Residual, and mass, damping and stiffness of small motions in the frame of the whirl."""
        force, by_place, by_speed = self._point_forces(q, omega)
        linear = self.stiffness + 1j * omega * self.damping - omega**2 * self.mass
        turn = _pairs(1j * omega * np.eye(q.size))
        stiffness = _pairs(linear) + by_place + by_speed @ turn
        damping = _pairs(self.damping + 2j * omega * self.mass) + by_speed
        return linear @ q + force, _pairs(self.mass), damping, stiffness

    def whirl(self, arc: Real, place: Complex, slope: Complex, omega: float) -> tuple[float, Complex]:
        """Whirl speed [rad/s] and eigenvalues in its frame [1/s], fastest growth first, without that of a turn.

        Args:
            arc: Nodes of a first guess from the bit up [m].
            place: Its centre line x + i y [m].
            slope: Derivative of it by the arc.
            omega: Its whirl speed [rad/s].

        Raises:
            ValueError: Newton's method does not converge.
        """
        spline = CubicHermiteSpline(arc, place, slope)
        q = np.stack([spline(self.nodes), spline(self.nodes, 1)], 1).ravel()[self.kept]
        m, held = q.size, int(np.argmax(np.abs(q * (self.kept % 2 == 0))))
        q *= abs(q[held]) / q[held]
        for _ in range(60):
            residual, mass, damping, stiffness = self._tangents(q, omega)
            pair = np.concatenate([q.real, q.imag])
            turned = _pairs(1j * np.eye(m)) @ pair
            # the imaginary part of the held place stays 0, its column is that of omega
            matrix = stiffness.copy()
            matrix[:, m + held] = damping @ turned
            step = -np.linalg.solve(matrix, np.concatenate([residual.real, residual.imag]))
            change, step[m + held] = float(step[m + held]), 0.0
            size = max(float(np.abs(step).max()) / self.physics.clearance, abs(change / self.physics.rotation))
            q, omega = q + step[:m] + 1j * step[m:], omega + change
            if size < 1e-10:
                break
        else:
            raise ValueError("expected Newton's method to converge from the first guess, found that it does not")
        _, mass, damping, stiffness = self._tangents(q, omega)
        state = np.block(
            [[np.zeros((2 * m, 2 * m)), np.eye(2 * m)], [-scipy.linalg.solve(mass, np.hstack([stiffness, damping]))]]
        )
        values = np.linalg.eigvals(state)
        values = np.delete(values, int(np.argmin(np.abs(values))))
        return omega, values[np.argsort(-values.real)]


def _pairs(matrix: NDArray[Any]) -> Real:
    """A complex matrix on real and imaginary parts."""
    result: Real = np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
    return result
