# SPDX-License-Identifier: Apache-2.0
"""Deflation: Newton's method kept away from the steady whirls that are known (Farrell, Birkisson and Funke 2015).

The residual F is multiplied by m = prod(1 / d_i^2 + 1), d_i the distance from a known whirl. Newton's step for m F is
that for F times a number, so that deflation costs two products a step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations

LONGEST = 4.0
"""Largest factor on a step; deflated steps may be of any length and sign."""


class Deflation:
    """Factor on Newton's step, by the distance from known whirls.

    A whirl turned about the axis is the same whirl: the distance is the least over all turns, shapes over the clearance
    (root mean square) and whirl speeds over the rotation together.
    """

    def __init__(self, turning: TurningEquations, known: Sequence[SteadyWhirl]) -> None:
        """Take the known whirls of the same equations."""
        self._turning, self._known = turning, known

    def factor(self, whirl: SteadyWhirl, step: Array, change: float) -> float:
        """Factor on a Newton step of the free unknowns, shape (m,), and of omega.

        From m F with step d of F: 1 / (1 - m' d / m) (Sherman and Morrison).
        """
        speed, clearance = max(abs(whirl.command.rotation), 1e-3), self._turning.clearance
        z, moved, slope = _line(whirl.u), _line(self._turning.equations.rows(step)), 0.0
        for other in self._known:
            own = _line(other.u)
            overlap = complex(np.vdot(own, z))
            away = (z - own * (overlap / max(abs(overlap), 1e-300))) / clearance
            ahead = (whirl.omega - other.omega) / speed
            square = max(float(np.mean(np.abs(away) ** 2)) + ahead**2, 1e-24)
            along = 2.0 * (float(np.mean((away.conj() * moved).real)) / clearance + ahead * change / speed)
            slope -= along / (square * (1.0 + square))
        factor = 1.0 / (1.0 - slope) if abs(1.0 - slope) > 1e-12 else LONGEST
        return float(np.clip(factor, -LONGEST, LONGEST))


def _line(u: Array) -> ComplexArray:
    """Positions x + i y of the nodes."""
    return np.asarray(u[:, 0] + 1j * u[:, 1], np.complex128)
