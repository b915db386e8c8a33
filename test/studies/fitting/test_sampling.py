# SPDX-License-Identifier: Apache-2.0
"""Draws of the fit against posteriors that are known, and the likelihoods against what they count."""

import numpy as np
import pytest
from scipy import special

from drill_twin.studies.fitting import sample
from drill_twin.studies.fitting.likelihood import features, independent_samples, of_features, of_series
from drill_twin.studies.fitting.posterior import predictive_band, weighted_quantile


def sampled(log_density, dimensions, **options):
    """Draws in the space where the prior is standard normal, and the result."""
    calls = []

    def likelihood(cube):
        calls.append(cube)
        return log_density(special.ndtri(np.concatenate(calls)))

    result = sample(likelihood, dimensions, members=64, rounds=20, effective=300, seed=3, **options)
    return special.ndtri(result.cube), result, len(calls)


def test_a_gaussian_posterior_is_found_from_a_likelihood_a_hundred_times_narrower_than_the_range():
    centre = np.array([0.8, -0.5, 0.3])
    covariance = 1e-4 * np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 4.0]])
    inverse = np.linalg.inv(covariance)
    draws, result, rounds = sampled(lambda z: -0.5 * np.einsum("ni,ij,nj->n", z - centre, inverse, z - centre), 3)
    assert result.power == 1.0
    assert rounds < 20
    mean = result.weights @ draws
    spread = ((draws - mean).T * result.weights) @ (draws - mean)
    assert mean == pytest.approx(centre, abs=0.003)
    assert np.sqrt(np.diag(spread)) == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.15)
    assert spread[0, 1] / np.sqrt(spread[0, 0] * spread[1, 1]) == pytest.approx(0.8, abs=0.1)


def test_without_information_the_draws_are_those_of_the_range():
    _, result, rounds = sampled(lambda z: np.zeros(len(z)), 2)
    assert rounds <= 7  # 300 effective draws of 64 a round, some doubled
    assert weighted_quantile(result.cube[:, 0], result.weights, 0.9) == pytest.approx(0.9, abs=0.05)


def test_runs_that_failed_have_no_weight():
    _, result, _ = sampled(lambda z: np.where(z[:, 0] > 0.0, 0.0, -np.inf), 1)
    assert result.weights[result.cube[:, 0] < 0.5].max() == 0.0


def test_correlated_errors_count_as_few_samples():
    white = np.random.default_rng(1).standard_normal(4000)
    slow = np.convolve(white, np.ones(40) / 40, "valid")
    assert independent_samples(white) == pytest.approx(4000, rel=0.15)
    assert independent_samples(slow) == pytest.approx(slow.size / 40, rel=0.35)
    assert independent_samples(np.ones(50)) == 50


def test_a_series_prefers_the_run_with_the_smaller_error_by_its_number_of_samples():
    error = np.random.default_rng(2).standard_normal(1000)
    runs = {"torque": np.array([error, 2.0 * error])}
    found = of_series({"torque": np.zeros(1000)}, runs, 0.1, 1.0)
    assert found[0] - found[1] == pytest.approx(independent_samples(error) * np.log(2.0), rel=1e-9)


def test_features_of_a_sine_do_not_depend_on_its_phase():
    time = np.arange(0.0, 40.0, 0.05)
    values = np.array([np.sin(2.0 * np.pi * 0.5 * time + phase) for phase in (0.0, 1.0)])
    mean, deviation, low, high, rate = features(values, 0.05, 10.0).mean(axis=1)[1]
    assert (mean, deviation, low, high) == pytest.approx((0.0, np.log(np.sqrt(0.5)), -0.988, 0.988), abs=0.02)
    assert rate == pytest.approx(0.5, abs=0.06)
    other = np.array([values[1], 1.5 * values[1]])
    likelihood = of_features({"bit_speed": values[0]}, {"bit_speed": other}, 0.05, 10.0)
    assert likelihood[0] > likelihood[1] + 10.0


def test_a_band_holds_its_share():
    generator = np.random.default_rng(4)
    runs = generator.standard_normal((500, 200))
    low, high = predictive_band(runs, np.full(500, 1 / 500), 1.0, 0.9)
    truth = generator.standard_normal(200) * np.sqrt(2.0)
    assert 0.84 < np.mean((low < truth) & (truth < high)) < 0.96
