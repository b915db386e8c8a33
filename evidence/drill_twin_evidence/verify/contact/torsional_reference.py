# SPDX-License-Identifier: Apache-2.0
"""Torsion of a string whose bit sticks and slips, integrated with events and without a regularised law.

Elements linear in the angle, inertia as the mean of consistent and lumped. While the bit sticks, its angle is held
until the torque that holds it passes that of the law at rest; while it slips, the torque is smooth. Each phase is
integrated by the Runge-Kutta method of order 8 of scipy, and ends where its event function vanishes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from drill_twin.core.arrays import Array

SHEAR, DENSITY = 206e9 / 2.6, 7850.0
NEAR, FAR = 5.0 / 12.0, 1.0 / 12.0


class Pipe(NamedTuple):
    """Piece of the string: length, outer and inner diameter [m]."""

    length: float
    outer: float
    inner: float


class Cycle(NamedTuple):
    """Limit cycle of the bit."""

    period: float
    """Mean period [s]."""
    peak: float
    """Largest speed [rad/s]."""


@dataclass(frozen=True)
class Torsion:
    """A string that the top turns at a given speed, reached linearly, and whose bit is in dry friction.

    Attributes:
        stiffness: Stiffness matrix [N m/rad], shape (n + 1, n + 1); the bit is node 0.
        inertia: Inertia matrix [kg m2].
        damping: Retardation time of twist [s].
        torque: Law of the bit: torque against a speed, not negative [N m].
        speed: Speed of the top [rad/s].
        spin_up: Time in which it is reached [s].
    """

    stiffness: Array
    inertia: Array
    damping: float
    torque: Callable[[float], float]
    speed: float
    spin_up: float

    def top(self, time: float) -> tuple[float, float, float]:
        """Angle [rad], speed and acceleration of the top."""
        if time < self.spin_up:
            rate = self.speed / self.spin_up
            return 0.5 * rate * time * time, rate * time, rate
        return self.speed * (time - 0.5 * self.spin_up), self.speed, 0.0

    def moments(self, time: float, state: Array) -> Array:
        """Torque of the twisted string on each node [N m]."""
        angle, speed, _ = self.top(time)
        n = state.size // 2
        return -self.stiffness @ (np.append(state[:n], angle) + self.damping * np.append(state[n:], speed))

    @cached_property
    def inverses(self) -> tuple[Array, Array]:
        """Inverses of the inertia of the nodes below the top, with the bit and without."""
        whole, above = np.linalg.inv(self.inertia[:-1, :-1]), np.linalg.inv(self.inertia[1:-1, 1:-1])
        return np.asarray(whole, float), np.asarray(above, float)

    def accelerations(self, time: float, state: Array, first: int, torque: float) -> Array:
        """Accelerations of the nodes below the top, those before the first of them at rest [rad/s2]."""
        n = state.size // 2
        load = self.moments(time, state)[first:n] - self.inertia[first:n, n] * self.top(time)[2]
        if first == 0:
            load[0] -= torque
        return np.concatenate([np.zeros(first), self.inverses[first] @ load])

    def holding(self, time: float, state: Array) -> float:
        """Torque that holds a bit at rest [N m]."""
        whole = np.append(self.accelerations(time, state, 1, 0.0), self.top(time)[2])
        return float(self.moments(time, state)[0] - self.inertia[0] @ whole)

    def run(self, seconds: float, every: float) -> tuple[Array, Array]:
        """Integrate from rest; returns times and speeds of the bit [rad/s]."""
        n = len(self.stiffness) - 1
        grid, found = np.arange(0.0, seconds, every), np.zeros(round(seconds / every))
        time, state, sign = 0.0, np.zeros(2 * n), 0.0
        while time < seconds - 1e-9:
            end = self.spin_up if time < self.spin_up - 1e-9 else seconds

            def rates(t: float, y: Array, way: float = sign) -> Array:
                first = 0 if way else 1
                return np.concatenate([y[n:], self.accelerations(t, y, first, way * self.torque(abs(y[n])))])

            def event(t: float, y: Array, way: float = sign) -> float:
                return float(way * y[n]) if way else self.torque(0.0) - abs(self.holding(t, y)) + 1e-9

            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
            part = solve_ivp(rates, (time, end), state, "DOP853", events=event, dense_output=True, rtol=1e-8, atol=1e-9)
            inside = (grid >= time) & (grid < part.t[-1])
            found[inside] = part.sol(grid[inside])[n] if inside.any() else 0.0
            time, state = float(part.t[-1]), part.y[:, -1].copy()
            if part.status == 1:
                state[n] = 0.0
                pull = self.holding(time, state)
                sign = float(np.sign(pull)) if abs(pull) >= self.torque(0.0) else 0.0
        return grid, found


def torsion(
    pipes: Sequence[Pipe],
    longest: float,
    damping: float,
    torque: Callable[[float], float],
    speed: float,
    spin_up: float,
) -> Torsion:
    """A string of pieces from the bit up, in elements of a largest length [m]; the rest as in `Torsion`."""
    lengths, polar = [], []
    for pipe in pipes:
        count = int(np.ceil(pipe.length / longest - 1e-9))
        lengths += [pipe.length / count] * count
        polar += [np.pi / 32.0 * (pipe.outer**4 - pipe.inner**4)] * count
    stiffness, inertia = np.zeros((2, len(lengths) + 1, len(lengths) + 1))
    for e, (length, area) in enumerate(zip(lengths, polar, strict=True)):
        stiffness[e : e + 2, e : e + 2] += SHEAR * area / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        inertia[e : e + 2, e : e + 2] += DENSITY * area * length * np.array([[NEAR, FAR], [FAR, NEAR]])
    return Torsion(stiffness, inertia, damping, torque, speed, spin_up)


def cycle_of(time: Array, speed: Array, level: float = 0.5) -> Cycle:
    """Period between passages of a level upwards [rad/s], at least 0.3 s apart, and peak of a steady cycle."""
    up = np.flatnonzero((speed[:-1] < level) & (speed[1:] >= level))
    passed = time[up] + (level - speed[up]) / (speed[up + 1] - speed[up]) * (time[up + 1] - time[up])
    passed = passed[np.insert(np.diff(passed) > 0.3, 0, True)]
    return Cycle(float(np.diff(passed).mean()), float(speed.max()))
