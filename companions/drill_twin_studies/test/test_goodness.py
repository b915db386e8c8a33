# SPDX-License-Identifier: Apache-2.0
"""Goodness of fit against residuals that are known: noise, noise that lasts, and what a model leaves out."""

import numpy as np
import pytest

from drill_twin_studies.goodness import (
    SCATTER,
    correlation_limit,
    goodness,
    independent_samples,
    lag_one,
    limit_of_samples,
    noise_of,
    sentence,
)

TIME = np.arange(0.0, 40.0, 0.1)
SWING = 1e3 * np.sin(1.3 * TIME)


def judged(residual, noise):
    return goodness(SWING + residual, SWING, 0.0, noise, noise, limit_of_samples(residual.size))


def test_noise_on_a_smooth_swing_is_found_and_gaps_do_not_matter():
    noise = 20.0 * np.random.default_rng(1).standard_normal(TIME.size)
    assert noise_of(SWING + noise) == pytest.approx(20.0, rel=0.1)
    gap = np.where((TIME > 5.0) & (TIME < 9.0), np.nan, SWING + noise)
    assert noise_of(gap) == pytest.approx(20.0, rel=0.1)
    assert noise_of(SWING[:8]) == 0.0


def test_one_model_in_a_thousand_that_is_right_is_called_unexplained():
    draw = np.random.default_rng(2)
    ratios = [np.mean(white**2) / noise_of(white) ** 2 for white in draw.standard_normal((4000, 250))]
    assert np.var(ratios) == pytest.approx(SCATTER / 250, rel=0.15)
    exceeded = np.mean(np.array(ratios) > limit_of_samples(250))
    assert exceeded < 4e-3
    lasting = [lag_one(white) > correlation_limit(250) for white in draw.standard_normal((4000, 250))]
    assert np.mean(lasting) < 4e-3


def test_a_model_that_is_right_leaves_noise():
    found = judged(20.0 * np.random.default_rng(3).standard_normal(TIME.size), 20.0)
    assert found.explained
    assert found.ratio == pytest.approx(1.0, abs=0.1)
    assert found.correlation == pytest.approx(0.0, abs=0.15)
    assert found.inside == pytest.approx(0.9, abs=0.05)
    assert sentence({"torque": found}) == ""


def test_a_residual_that_lasts_is_told_though_it_is_no_larger_than_the_noise():
    noise = np.random.default_rng(5).standard_normal(TIME.size + 1)
    lasting = noise[1:] + 0.4 * noise[:-1]
    found = goodness(SWING + lasting, SWING, 0.0, 1.1, 1.1, 1.5, correlation_limit(TIME.size))
    assert found.chi_square < 1.5
    assert not found.explained
    assert "times the noise, but it lasts: +0.3" in sentence({"torque": found})
    assert "in the band" not in sentence({"torque": found})


def test_what_a_model_leaves_out_is_told():
    wrong = judged(60.0 * np.sin(0.7 * TIME) + 20.0 * np.random.default_rng(4).standard_normal(TIME.size), 20.0)
    assert not wrong.explained
    assert wrong.correlation > 0.7
    assert wrong.independent < 100.0
    assert sentence({"top_drive_speed": wrong}).startswith("the model does not explain top drive speed (residual 2.")


def test_nothing_measured_is_not_judged():
    found = goodness(np.full(50, np.nan), SWING[:50], 1.0, 0.0, 20.0, 2.0)
    assert found.explained
    assert found.samples == 0


def test_a_spread_that_is_predicted_counts():
    assert goodness(SWING + 50.0, SWING, 50.0, 1.0, 1.0, 1.5).explained
    assert not goodness(SWING + 50.0, SWING, 1.0, 1.0, 1.0, 1.5).explained


def test_correlated_errors_count_as_few_samples():
    white = np.random.default_rng(1).standard_normal(4000)
    slow = np.convolve(white, np.ones(40) / 40, "valid")
    assert independent_samples(white) == pytest.approx(4000, rel=0.15)
    assert independent_samples(slow) == pytest.approx(slow.size / 40, rel=0.35)
    assert independent_samples(np.ones(50)) == 50
    assert lag_one(slow) > 0.95
    assert lag_one(np.ones(50)) == 0.0
