# SPDX-License-Identifier: Apache-2.0
"""Whirl with two frequencies; `evidence/test/whirl_compare` has one that a run in time confirms."""

import math

import numpy as np

from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_states import whirl_states
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.whirl_compare.harmonic_balance import TwoFrequencyEquations, TwoFrequencyWhirl


def test_a_steady_whirl_is_none_with_two_frequencies(bench):
    equations = EquationsOfMotion(bench)
    steady = whirl_states(equations, Command(40.0, 6.5 * math.tau), random_starts=0)[0].whirl
    turning = TurningEquations(equations)
    coefficients = np.zeros((9, equations.unknowns))
    coefficients[0] = turning.frame.values(steady.u)
    coefficients[1] = 1e-5 * turning.clearance
    near = TwoFrequencyWhirl(steady.command, coefficients, steady.omega, 3.0)
    *_, instants = TwoFrequencyEquations(turning).over(near, near.even)
    assert np.abs([system.residual for system in instants]).max() < 1.0
    assert TwoFrequencyEquations(turning).newton(near) is None
