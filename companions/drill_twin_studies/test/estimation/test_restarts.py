# SPDX-License-Identifier: Apache-2.0
"""Restarts: a number that has jumped is found, and no number where the members had lost the motion."""

from dataclasses import replace

import numpy as np
import pytest

from drill_twin.api.scenes import load_scene
from drill_twin_studies.estimation.estimate import FilterWindow, WindowTiming
from drill_twin_studies.estimation.members import EstimatorMembers
from drill_twin_studies.estimation.restarts import Restarts

RANGES = {"bit_torque_stribeck.sticking": (0.55, 0.95), "load_factor": (0.9, 1.1)}
CHANNELS, ERRORS = ("torque", "hookload"), np.array([100.0, 1000.0])  # N m, N
PACE = WindowTiming(0.1, frames=20, samples=10)
PAIRS = np.vstack((np.zeros((PACE.tail, 10)), np.kron(np.eye(10), [[0.5], [0.5]])))  # of frames, to a sample
WINDOW = FilterWindow(np.tile([55e3, 10.0, np.nan], (20, 1)), {}, np.array([PAIRS, PAIRS]))


@pytest.fixture
def followed():
    """Members with nearly the numbers of a rig, and their restarts, by what happens to either at a time."""
    scene = load_scene("two_mass", {"wob": "55 kN", "numerics.step": "20 ms", "numerics.frame_rate": 10.0})

    def follow(rig_changes=0.0, lost=False):
        members, rig = (EstimatorMembers(scene, RANGES, count, PACE, 3, (), CHANNELS) for count in (16, 1))
        members.set_numbers(0.02 * members.normal)
        rig.set_numbers(np.zeros((1, 2)))
        restarts = Restarts(members, CHANNELS, 1.0)
        for window in range(10):
            if window == 8:
                rig.set_numbers(np.array([[rig_changes, 0.0]]))
                for twin in members.twins if lost else ():
                    twin.unknowns[1][:, 6] += 5.0  # rad/s
            restarts.begin(WINDOW)
            both = [each.advance(WINDOW)[1].channels for each in (members, rig)]
            restarts.end(np.array([both[1][name].mean(axis=0) for name in CHANNELS]))
        return restarts, members

    return follow


@pytest.mark.slow
@pytest.mark.parametrize(("rig_changes", "lost", "chosen"), [(1.0, False, [True, False]), (0.0, True, [False, False])])
def test_what_was_measured_is_explained_by_the_number_that_jumped_or_by_a_motion_that_was_lost(
    followed, rig_changes, lost, chosen
):
    found = followed(rig_changes, lost)[0].found(np.array([True, True]), ERRORS, 2)
    assert found.chosen.tolist() == chosen
    assert found.windows > 2 or not lost
    assert lost or found.centre[0] == pytest.approx(0.84, abs=0.1)


def test_trials_leave_the_members_as_they_were(followed):
    restarts, members = followed()
    _, untouched = followed()
    assert restarts.found(np.array([True, True]), ERRORS, 2) is not None
    late = replace(WINDOW, weights=np.roll(WINDOW.weights, -1, axis=1))  # means that began a frame before the window
    assert np.array_equal(*(each.advance(late)[1].channels["torque"] for each in (members, untouched)))
