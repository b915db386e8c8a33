# SPDX-License-Identifier: Apache-2.0
"""Stability of a whirl with two frequencies: Floquet multipliers of small motions in the turning frame.

``M x'' + (C + 2 omega M J) x' + (K + omega C J + omega^2 M J J) x = 0`` has coefficients of period T = 2 pi / |sigma|.
It is integrated over one period by the midpoint rule from every unit position and velocity. Two of the multipliers are
1: the turn of the motion about the axis, and its shift in time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import ComplexArray
from drill_twin_evidence.whirl_compare.harmonic_balance import (
    HARMONICS,
    Series,
    TwoFrequencyEquations,
    TwoFrequencyWhirl,
)

STEPS = 400
"""Steps in a period."""
NEUTRAL = 0.2
"""Distance of the neutral multipliers from 1 that is good enough."""


@dataclass(frozen=True, eq=False)
class TwoFrequencyState:
    """A whirl with two frequencies and its stability."""

    whirl: TwoFrequencyWhirl
    multipliers: ComplexArray
    """Factors on small motions after one period in the turning frame, the largest first."""
    neutral: float
    """Largest distance from 1 of the two multipliers that are 1, as computed."""

    @property
    def growth(self) -> float:
        """Growth of the fastest disturbance [1/s]; negative: all decay."""
        return math.log(float(abs(self.multipliers[0]))) * abs(self.whirl.sigma) / math.tau

    @property
    def is_stable(self) -> bool:
        """True if every disturbance decays."""
        return self.growth < 0.0


def state_near(equations: TwoFrequencyEquations, guess: TwoFrequencyWhirl) -> TwoFrequencyState | None:
    """Whirl with two frequencies near a first guess, with as many harmonics as its neutral multipliers need; None if
    Newton's method does not converge with any.
    """
    found: TwoFrequencyState | None = None
    for harmonics in HARMONICS:
        whirl = equations.newton(guess.with_harmonics(harmonics))
        if whirl is None:
            continue
        state = state_of(equations, whirl)
        found = state if found is None else min(found, state, key=lambda one: one.neutral)
        if found.neutral < NEUTRAL:
            break
    return found


def state_of(equations: TwoFrequencyEquations, whirl: TwoFrequencyWhirl, steps: int = STEPS) -> TwoFrequencyState:
    """A whirl with its stability."""
    period = math.tau / abs(whirl.sigma)
    half_step = 0.5 * period / steps
    phases = np.linspace(half_step, period - half_step, steps) * whirl.sigma
    *_, instants = equations.over(whirl, Series(phases, whirl.harmonics))
    count = equations.turning.equations.unknowns
    u, v = np.vsplit(np.eye(2 * count), 2)
    for system in instants:
        stiffness, gyroscopic, mass = (system.rows.dense(part) for part in equations.tangents(whirl, system))
        middle = np.linalg.solve(
            mass / half_step + gyroscopic + half_step * stiffness, mass @ v / half_step - stiffness @ u
        )
        u, v = u + 2.0 * half_step * middle, 2.0 * middle - v
    found: ComplexArray = np.asarray(np.linalg.eigvals(np.vstack([u, v])), np.complex128)
    values = found[np.argsort(np.abs(found - 1.0))]
    others = values[2:]
    return TwoFrequencyState(whirl, others[np.argsort(-np.abs(others))], float(np.abs(values[1] - 1.0)))
