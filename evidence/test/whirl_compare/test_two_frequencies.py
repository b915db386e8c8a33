"""Whirl with two frequencies by harmonic balance, from a run in time, and a run that begins on it."""

import math

import numpy as np
import pytest

from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.load import override
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.whirl_compare import comparison
from drill_twin_evidence.whirl_compare.harmonic_balance import Series, TwoFrequencyEquations, times_j
from drill_twin_evidence.whirl_compare.motion import motion_of

COMMAND = Command(90.0, 3.2 * math.tau)


@pytest.fixture(scope="module")
def found(bench):
    """Equations, a run at 90 N and 3.2 rev/s, and the state found from it."""
    equations = EquationsOfMotion(bench)
    scene = comparison.with_marks(equations)
    (run,) = comparison._runs(scene, COMMAND.weight_on_bit, [COMMAND.rotation], 40.0, 1)
    return equations, scene, run, comparison._two_frequency_state(equations, COMMAND, run)


def test_the_motion_of_a_run_is_computed(found):
    equations, _, run, state = found
    assert state.is_stable
    assert state.neutral < 0.1
    assert comparison.is_on(equations, state.whirl, run.motion)
    assert not comparison.is_on(equations, state.whirl, run.motion._replace(second=run.motion.second * 1.5))
    speeds = np.array([state.whirl.omega, state.whirl.second]) - [run.motion.speed, run.motion.second]
    assert np.abs(speeds).max() < 1e-3 * COMMAND.rotation


def test_its_equations_hold_between_the_instants_that_newton_takes(found):
    equations, _, _, state = found
    whirl = state.whirl
    phases = whirl.sigma * np.linspace(0.0, math.tau / abs(whirl.sigma), 40)
    turning = TwoFrequencyEquations(TurningEquations(equations))
    _, _, change, instants = turning.over(whirl, Series(phases, whirl.harmonics))
    left = np.array([system.residual for system in instants])
    inertia = np.array([system.matrices[0] @ a for system, a in zip(instants, change, strict=True)])
    assert np.sqrt(np.mean(left**2)) < 0.3 * np.sqrt(np.mean(inertia**2))


def test_a_run_that_begins_on_it_stays(found):
    equations, scene, _, state = found
    whirl, axis = state.whirl, equations.on_axis(COMMAND)[0]
    start = Series(np.zeros(1), whirl.harmonics)
    turning = TwoFrequencyEquations(TurningEquations(equations))
    place, rate, _, _ = turning.over(whirl, start)
    u = axis + equations.rows(place[0]) - equations.rows(turning.turning.frame.values(axis))
    v = equations.rows(rate[0] - whirl.omega * times_j(turning.turning.frame, place)[0])
    v[:, 6] = COMMAND.rotation
    own = {"rig.weight_on_bit.value": COMMAND.weight_on_bit, "rig.rotation.value": COMMAND.rotation}
    twin = Twin(override(scene, own))
    twin.dynamics.begin(u, v, COMMAND)
    path = np.array([twin.advance(COMMAND, 0.01).marks.centre[:, :2] for _ in range(600)])
    motion = motion_of(path[..., 0] + 1j * path[..., 1], 0.01, scene.least_clearance)
    assert comparison.is_on(equations, whirl, motion)
