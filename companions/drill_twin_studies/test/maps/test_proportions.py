# SPDX-License-Identifier: Apache-2.0
"""Limits of a counted share, against another library and by what they promise."""

import doctest

import pytest
from scipy import stats

from drill_twin_studies.maps import proportions
from drill_twin_studies.maps.proportions import proportion_interval


def test_examples():
    assert doctest.testmod(proportions) == (0, 3)


@pytest.mark.parametrize(("count", "trials"), [(0, 1), (1, 1), (0, 5), (1, 5), (5, 5), (41, 42), (60, 200)])
@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.95])
def test_limits_are_those_of_scipy(count, trials, confidence):
    expected = stats.binomtest(count, trials).proportion_ci(confidence, method="exact")
    assert proportion_interval(count, trials, confidence) == pytest.approx(tuple(expected), abs=1e-9)


@pytest.mark.parametrize("chance", [0.01, 0.2, 0.5, 0.93])
@pytest.mark.parametrize("trials", [1, 4, 20])
def test_limits_hold_at_least_as_often_as_they_say(chance, trials):
    held = sum(
        stats.binom.pmf(count, trials, chance)
        for count in range(trials + 1)
        if proportion_interval(count, trials)[0] <= chance <= proportion_interval(count, trials)[1]
    )
    assert held >= 0.95 - 1e-9


def test_no_trials_say_nothing():
    assert proportion_interval(0, 0) == (0.0, 1.0)
