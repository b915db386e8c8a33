"""Branches of steady whirl: folds, the same state on both sides of a value, ends that are told."""

import math

import numpy as np
import pytest

from drill_twin.api import rotordynamics as api
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.rotordynamics.steady.branches import branch, key_of, load_of, passes, speed_of
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.scene.set_points.command import Command
from drill_twin.studies.whirl_states import PARAMETERS

FAST = Command(40.0, 6.5 * math.tau)


@pytest.fixture
def turning(fast):
    return TurningEquations(fast[0])


@pytest.fixture
def state(fast):
    return next(one for one in fast[1] if one.is_stable)


@pytest.mark.slow
def test_a_branch_over_speed_turns_back_at_a_fold_where_stability_is_lost(turning, state):
    found = branch(speed_of(turning, FAST, 2.0 * math.tau, 7.0 * math.tau), state.whirl, FAST.rotation)
    assert found.parameter in PARAMETERS  # as the axis of the figure is labelled
    assert len(found.folds) == 1
    fold = found.folds[0]
    assert found.values[fold] < FAST.rotation
    assert found.values[fold] == pytest.approx(found.values.min(), rel=1e-3)
    stable = np.array([one.is_stable for one in found.states])
    assert stable[fold + 2 :].all() != stable[: fold - 1].any()
    assert passes(found, state, FAST.rotation)
    assert all(one in {"end of the range", "the string leaves the wall"} for one in found.ends)


@pytest.mark.slow
def test_points_of_a_branch_are_states(turning, state):
    found = branch(load_of(turning, FAST, 30.0, 50.0), state.whirl, FAST.weight_on_bit)
    assert found.parameter in PARAMETERS
    for one in found.states[:: max(1, len(found.states) // 4)]:
        assert np.abs(turning.at(one.whirl).residual).max() < 1e-6
    again = turning.newton(found.states[0].whirl)
    assert again is not None
    assert again.omega == pytest.approx(found.states[0].whirl.omega, rel=1e-6)


@pytest.mark.long
def test_any_number_of_the_scene_is_a_parameter(turning, state):
    key = "effects.wall_friction.coefficient"
    found = branch(key_of(turning, FAST, key, 0.20, 0.21), state.whirl, 0.205)
    assert found.values.min() < 0.202
    assert found.values.max() > 0.208
    slow, fast = (found.states[int(k)].ratio for k in (found.values.argmax(), found.values.argmin()))
    assert slow < fast  # friction on the wall brakes the forward whirl


def test_a_range_without_the_value_is_refused(bench):
    with pytest.raises(SceneError, match="expected a range of wob around its value 40"):
        api.branches(bench, over="wob", span="50..60 N")
    with pytest.raises(SceneError, match="expected one of the keys"):
        api.branches(bench, over="numerics.nothing", span=(50.0, 60.0))
