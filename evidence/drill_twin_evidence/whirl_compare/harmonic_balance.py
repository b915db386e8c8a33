# SPDX-License-Identifier: Apache-2.0
"""Whirl with two frequencies by harmonic balance in the frame that turns with one of them.

Where one part of a string whirls at omega and another at omega + sigma, ``u(t) = R(omega t) w(sigma t)`` with w of
period 2 pi: a limit cycle in the turning frame. With x' and x'' the derivatives of ``x(t) = w(sigma t)`` it solves

``M a + f(x, v) = 0``, ``v = x' + omega J x``, ``a = x'' + 2 omega J x' + omega^2 J J x``

at all times. x is a Fourier series; the forces are evaluated over a period and transformed back (alternating
frequency/time, Cameron and Griffin 1989), and Newton's method takes the coefficients, omega and sigma. Two coefficients
are held, which fixes the direction of the shape and the begin of the period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.rotordynamics.block_rows import solve_banded
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame
from drill_twin.dynamics.solver.linearisation import DAMPING, MASS
from drill_twin.physics.model.mesh import SPIN
from drill_twin.scene.set_points.command import Command

HARMONICS = 24, 36, 54
"""Harmonics tried in turn: more where the string leaves the wall and comes back."""
SAMPLES = 4
"""Instants in a period at which forces are evaluated, over the harmonics."""
ITERATIONS = 25
TOLERANCE = 1e-8
"""Size of the last Newton step over the clearance."""
LARGEST_MOVE = 0.2
"""Longest Newton step over the clearance; a longer one is shortened to it."""
FARTHEST = 0.3
"""Distance from the first guess, over the clearance, at which the iteration is given up."""
LEAST_CHANGE = 0.02
"""Least first harmonic over the clearance; less is a steady whirl."""


def times_j(frame: TurningFrame, values: Array) -> Array:
    """Rows of values of the free unknowns, shape (T, m), times J, which is minus J applied to each row."""
    result = np.zeros_like(values)
    result[:, frame.x], result[:, frame.y] = values[:, frame.y], -values[:, frame.x]
    return result


def across(frame: TurningFrame, values: Array) -> Array:
    """Rows of values of the free unknowns, shape (T, m), times -J J: their part across the axis."""
    return -times_j(frame, times_j(frame, values))


class Series:
    """Values of a Fourier series and its first two derivatives at phases, as matrices (T, 2 H + 1) of coefficients.

    Coefficients are the mean, then H of the cosines, then H of the sines.
    """

    def __init__(self, phases: Array, harmonics: int) -> None:
        """Take the phases [rad], shape (T,)."""
        order = np.arange(1, harmonics + 1)
        cos, sin, zero = np.cos(np.outer(phases, order)), np.sin(np.outer(phases, order)), np.zeros((phases.size, 1))
        self.value: Array = np.hstack([zero + 1.0, cos, sin])
        self.first: Array = np.hstack([zero, -order * sin, order * cos])
        self.second: Array = np.hstack([zero, -(order**2) * cos, -(order**2) * sin])


@dataclass(frozen=True, eq=False)
class TwoFrequencyWhirl:
    """Motion of a string of which two parts whirl at speeds of their own."""

    command: Command
    coefficients: Array
    """Fourier coefficients of the free unknowns in the turning frame, shape (2 H + 1, m)."""
    omega: float
    """Speed of the frame, and mean whirl speed of a part of the string [rad/s]."""
    sigma: float
    """Frequency in that frame [rad/s]: the other part whirls at omega + sigma."""

    @property
    def harmonics(self) -> int:
        """Number H of harmonics."""
        return len(self.coefficients) // 2

    @property
    def second(self) -> float:
        """Whirl speed of the other part [rad/s]."""
        return self.omega + self.sigma

    def with_harmonics(self, harmonics: int) -> TwoFrequencyWhirl:
        """The same motion with another number of harmonics; those added are zero."""
        kept = min(harmonics, self.harmonics)
        values = np.zeros((2 * harmonics + 1, self.coefficients.shape[1]))
        values[: kept + 1] = self.coefficients[: kept + 1]
        values[harmonics + 1 : harmonics + 1 + kept] = self.coefficients[self.harmonics + 1 :][:kept]
        return replace(self, coefficients=values)

    @cached_property
    def even(self) -> Series:
        """The series at evenly spaced phases of a period."""
        count = SAMPLES * self.harmonics + 1
        return Series(np.linspace(0.0, 2.0 * np.pi, count, endpoint=False), self.harmonics)


class TwoFrequencyEquations:
    """The equations of a scene over a period in a turning frame.

    Attributes:
        turning: The equations in a turning frame.
    """

    def __init__(self, turning: TurningEquations) -> None:
        """Take the equations of a scene with a wall."""
        self.turning = turning

    def over(self, whirl: TwoFrequencyWhirl, series: Series) -> tuple[Array, Array, Array, list[Linearised]]:
        """Position, velocity and acceleration in the turning frame, shape (T, m) each, and the equations there."""
        equations, frame, omega = self.turning.equations, self.turning.frame, whirl.omega
        place = series.value @ whirl.coefficients
        rate = whirl.sigma * series.first @ whirl.coefficients
        change = whirl.sigma**2 * series.second @ whirl.coefficients
        # rows of values, so that J x is minus x J
        speed = rate - omega * times_j(frame, place)
        acceleration = change - 2.0 * omega * times_j(frame, rate) - omega**2 * across(frame, place)
        axis, turn = equations.on_axis(whirl.command)
        fixed = axis - equations.rows(frame.values(axis))
        spin = np.zeros_like(turn)
        spin[:, SPIN] = whirl.command.rotation
        instants = [
            equations.evaluate(whirl.command, fixed + equations.rows(x), spin + equations.rows(v), equations.rows(a))
            for x, v, a in zip(place, speed, acceleration, strict=True)
        ]
        return place, rate, change, instants

    def tangents(self, whirl: TwoFrequencyWhirl, system: Linearised) -> tuple[Array, Array, Array]:
        """Stiffness, damping and mass of small motions in the turning frame, as block rows."""
        mass = system.tangents[MASS]
        gyroscopic = system.tangents[DAMPING] + 2.0 * whirl.omega * system.rows.times_j(mass)
        return self.turning.stiffness(system, whirl.omega), gyroscopic, mass

    def newton(self, start: TwoFrequencyWhirl, iterations: int = ITERATIONS) -> TwoFrequencyWhirl | None:
        """Whirl with two frequencies near a first guess; None if Newton's method does not converge, or to one that
        does not change in the turning frame.
        """
        whirl, clearance = start, self.turning.clearance
        for _ in range(iterations):
            held = self._held(whirl)
            step = self._step(whirl, held)
            changes = step[held].copy()
            step[held] = 0.0
            size = float(np.abs(step).max()) / clearance
            if not np.isfinite(size):
                return None
            share = min(1.0, LARGEST_MOVE / max(size, TOLERANCE))
            moved = whirl.coefficients + share * step.reshape(-1, len(whirl.coefficients)).T
            omega, sigma = whirl.omega + share * changes[0], whirl.sigma + share * changes[1]
            whirl = replace(whirl, coefficients=moved, omega=float(omega), sigma=float(sigma))
            away = whirl.even.value @ (moved - start.coefficients)
            if float(np.abs(away).max()) > FARTHEST * clearance:
                return None
            if size < TOLERANCE:
                first = np.hypot(moved[1], moved[1 + whirl.harmonics])[self.turning.frame.x].max()
                return whirl if first > LEAST_CHANGE * clearance else None
        return None

    def _held(self, whirl: TwoFrequencyWhirl) -> list[int]:
        """Numbers of the coefficients in whose places omega and sigma are: the direction of the node that is farthest
        from the axis in the mean, and the phase of the largest first harmonic.
        """
        h, count = whirl.harmonics, len(whirl.coefficients)
        cos, sin = whirl.coefficients[1], whirl.coefficients[1 + h]
        place = int(np.argmax(np.hypot(cos, sin)))
        smaller = 1 + h if abs(cos[place]) > abs(sin[place]) else 1
        return [self.turning.frame.farthest(whirl.coefficients[0]) * count, place * count + smaller]

    def _step(self, whirl: TwoFrequencyWhirl, held: Sequence[int]) -> Array:
        """Newton step of the coefficients, by unknown; omega and sigma in place of those held."""
        series, frame, omega, sigma = whirl.even, self.turning.frame, whirl.omega, whirl.sigma
        place, rate, change, instants = self.over(whirl, series)
        back, count, rows = np.linalg.pinv(series.value), len(whirl.coefficients), instants[0].rows
        entries, by_omega, by_sigma = [], np.zeros_like(place), np.zeros_like(place)
        for j, system in enumerate(instants):
            stiffness, gyroscopic, mass = self.tangents(whirl, system)
            entries.append([rows.entries(blocks) for blocks in (stiffness, gyroscopic, mass)])
            turned = -times_j(frame, place[j : j + 1])[0]
            moved = -times_j(frame, rate[j : j + 1])[0] - omega * across(frame, place[j : j + 1])[0]
            by_omega[j] = rows.times(system.tangents[DAMPING], turned) + 2.0 * rows.times(mass, moved)
            by_sigma[j] = (rows.times(gyroscopic, rate[j]) + 2.0 * rows.times(mass, change[j])) / sigma
        parts = (series.value, sigma * series.first, sigma**2 * series.second)
        weights = np.hstack([np.einsum("kj,jl->klj", back, part).reshape(count**2, -1) for part in parts])
        values = np.concatenate(np.array(entries).transpose(1, 0, 2)).T @ weights.T
        order = np.arange(count)
        row = rows.row[:, None, None] * count + order[:, None]
        column = rows.column[:, None, None] * count + order
        rights = [(back @ part).T.ravel() for part in (by_omega, by_sigma)]
        residual = np.array([system.residual for system in instants])
        half = (int(np.abs(rows.row - rows.column).max()) + 1) * count - 1
        store = np.zeros((rows.unknowns * count, 3 * half + 1))
        store[column, 2 * half + row - column] = values.reshape(-1, count, count)
        return np.asarray(solve_banded(store, half, -(back @ residual).T.ravel(), held, rights))


def from_amplitudes(
    equations: EquationsOfMotion, command: Command, place: ComplexArray, slope: ComplexArray, omega: float, sigma: float
) -> TwoFrequencyWhirl:
    """First guess from amplitudes c_k of ``x + i y = sum c_k exp(i (omega + k sigma) t)``.

    Args:
        equations: Of the scene.
        command: Weight on bit and rotation.
        place: Amplitudes at the nodes [m], for k from -H to H, shape (2 H + 1, n + 1).
        slope: Their derivatives along the arc.
        omega: Speed of the frame [rad/s].
        sigma: Frequency in it [rad/s].
    """
    harmonics = len(place) // 2
    axis, _ = equations.on_axis(command)

    def coefficients(lines: ComplexArray) -> tuple[Array, Array]:
        after, before = lines[harmonics + 1 :], lines[harmonics - 1 :: -1]
        both = np.concatenate([lines[harmonics : harmonics + 1], after + before, 1j * (after - before)])
        return both.real, both.imag

    rows = np.zeros((2 * harmonics + 1, *axis.shape))
    rows[0] = axis
    (rows[..., 0], rows[..., 1]), (rows[..., 3], rows[..., 4]) = coefficients(place), coefficients(slope)
    values = rows[..., equations.columns][:, equations.free]
    return TwoFrequencyWhirl(command, values, omega, sigma)
