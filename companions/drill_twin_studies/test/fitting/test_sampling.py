# SPDX-License-Identifier: Apache-2.0
"""Draws of the fit against posteriors that are known, and the likelihoods against what they count."""

import warnings

import numpy as np
import pytest
from scipy import special
from variants import one_of

from drill_twin.core.errors import ArgumentError
from drill_twin_studies.fitting import sample
from drill_twin_studies.fitting.likelihood import (
    error_variance,
    features,
    features_goodness,
    noise_in,
    of_features,
    of_series,
)
from drill_twin_studies.fitting.posterior import predictive_band
from drill_twin_studies.fitting.sampling import weighted_quantile


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


def test_the_end_of_a_posterior_that_is_long_and_bent_is_reached():
    def bent(z):
        off = z[:, 0] - 0.3 * (1.0 - np.exp(-1.5 * np.maximum(z[:, 1], -1.0)))
        return (
            -0.5 * ((off / 0.01) ** 2 + (z[:, 2] / 0.05) ** 2 + (z[:, 3] / 0.05) ** 2)
            - 50.0 * np.minimum(z[:, 1], 0.0) ** 2
        )

    ends = []
    for seed in range(6):
        calls = []

        def likelihood(cube, calls=calls):
            calls.append(cube)
            return bent(special.ndtri(np.concatenate(calls)))

        result = sample(likelihood, 4, members=32, rounds=40, effective=200, seed=seed)
        ends.append(float(weighted_quantile(result.cube[:, 1], result.weights, 0.95)))
    assert np.mean(ends) > 0.92  # 0.972; proposals of all draws alone end at 0.9


def test_an_interval_reaches_the_end_of_a_range_where_the_draws_do():
    _, result, _ = sampled(lambda z: 30.0 * special.ndtr(z[:, 0]) - 300.0 * (special.ndtr(z[:, 1]) - 0.5) ** 2, 2)
    low, high = result.intervals
    assert high[0] == 1.0
    assert 0.85 < low[0] < 0.95  # 1 - ln(20) / 30 = 0.90
    half = 1.645 / np.sqrt(600.0)
    assert (low[1], high[1]) == (pytest.approx(0.5 - half, abs=0.015), pytest.approx(0.5 + half, abs=0.015))


def test_without_information_the_draws_are_those_of_the_range():
    _, result, rounds = sampled(lambda z: np.zeros(len(z)), 2)
    assert rounds <= 7  # 300 effective draws of 64 a round, some doubled
    assert weighted_quantile(result.cube[:, 0], result.weights, 0.9) == pytest.approx(0.9, abs=0.05)


def test_runs_that_failed_have_no_weight():
    _, result, _ = sampled(lambda z: np.where(z[:, 0] > 0.0, 0.0, -np.inf), 1)
    assert result.weights[result.cube[:, 0] < 0.5].max() == 0.0


def test_a_series_prefers_the_run_with_the_smaller_error_by_the_variance_of_an_error():
    draw = np.random.default_rng(2).standard_normal(1000)
    runs = {"torque": np.array([np.zeros(1000), np.full(1000, 0.3)])}
    found = of_series({"torque": draw}, runs, 4)
    squares = np.mean((runs["torque"] - draw) ** 2, axis=1)
    assert found[0] > found[1]
    noise = noise_in(draw, draw) ** 2
    assert noise == pytest.approx(
        np.mean(np.convolve(draw, [1.0, -3.0, 3.0, -1.0], "valid") ** 2) / 20.0 + (0.01 * draw.std()) ** 2
    )
    wanted = 500.0 * (squares[1] - squares[0]) / error_variance(squares[0], noise, 1000, 4)
    assert found[0] - found[1] == pytest.approx(wanted, rel=1e-9)


def test_samples_that_are_missing_are_left_out():
    draw = np.random.default_rng(3).standard_normal(200)
    runs = {"torque": np.random.default_rng(4).standard_normal((3, 200))}
    gap = np.where(np.arange(200) < 150, draw, np.nan)
    found = of_series({"torque": gap}, runs, 2)
    assert found == pytest.approx(of_series({"torque": draw[:150]}, {"torque": runs["torque"][:, :150]}, 2))


def test_what_the_model_leaves_counts_as_one_sample_a_free_number_and_noise_as_what_it_is():
    assert error_variance(1.0, 1.0, 10**8, 4) == pytest.approx(1.0)  # a model that is right: noise alone
    assert error_variance(0.5, 1.0, 400, 4) == 1.0
    for square in (5.0, 9.0):
        wanted = square * 400 / 396 * (1.0 + (square - 1.0) * 400 / 4)
        assert error_variance(square, 1.0, 400, 4) == pytest.approx(wanted)


def test_noise_is_what_a_run_leaves_where_the_record_is_not_smooth():
    time = np.arange(0.0, 40.0, 0.1)
    saw = 50.0 * (time % 2.0)
    record = saw + np.random.default_rng(1).standard_normal(time.size)
    floor = 0.01 * record.std()
    assert noise_in(record, record) > 5.0
    assert noise_in(record, record - saw) == pytest.approx(np.hypot(1.0, floor), rel=0.15)
    assert noise_in(record, record - 30.0) == noise_in(record, record)


def test_features_of_a_sine_do_not_depend_on_its_phase():
    time = np.arange(0.0, 40.0, 0.05)
    values = np.array([np.sin(2.0 * np.pi * 0.5 * time + phase) for phase in (0.0, 1.0)])
    mean, deviation, low, high, rate = features(values[1], 0.05, 200).mean(axis=0)
    assert (mean, deviation, low, high) == pytest.approx((0.0, np.log(np.sqrt(0.5)), -0.988, 0.988), abs=0.02)
    assert rate == pytest.approx(0.5, abs=0.06)
    other = np.array([values[1], 1.5 * values[1]])
    likelihood = of_features({"bit_speed": values[0]}, {"bit_speed": other}, 0.05, 10.0)
    assert likelihood[0] > likelihood[1] + 10.0


def test_noise_of_a_record_is_no_feature_of_its_motion():
    time = np.arange(0.0, 40.0, 0.05)
    quiet = 0.01 * np.sin(2.0 * np.pi * 0.5 * time)
    record = quiet + 0.05 * np.random.default_rng(2).standard_normal(time.size)
    found = of_features({"torque": record}, {"torque": np.array([quiet, 5.0 * quiet])}, 0.05, 10.0)
    assert found[0] > found[1]
    good = features_goodness({"torque": record}, {"torque": quiet}, 0.05, 10.0)["torque"]
    assert good.explained
    assert good.of == "features"


def test_few_windows_are_refused_and_gaps_count():
    record = np.sin(np.arange(0.0, 12.0, 0.05))
    runs = {"torque": record[None]}
    assert np.isfinite(of_features({"torque": record}, runs, 0.05, 4.0)).all()
    for window, changed in ((5.0, record), (4.0, np.where(np.arange(240) == 100, np.nan, record)), (20.0, record)):
        with pytest.raises(ArgumentError, match=r"fit: expected 3 windows of features or more without a gap, found "):
            of_features({"torque": changed}, runs, 0.05, window)


@pytest.mark.slow
@pytest.mark.parametrize("length", one_of(3, [24.0, 16.0, 48.0]))
def test_features_of_a_motion_of_any_phase_and_noise_hold_their_share(length):
    """Records of a relaxation oscillation, its period and height free: a 90 % interval of each holds nine of ten."""
    generator, time = np.random.default_rng(5), np.arange(0.0, length, 0.05)

    def motion(period, height, phase):
        place = (time / period + phase) % 1.0
        return height * np.where(place < 0.6, np.sin(np.pi * place / 0.6) ** 2, 0.0)

    inside, explained, scaled = [], [], []
    draws = (200 if length < 48.0 else 400, 2)  # a long record leaves a narrow interval, in which some must lie
    for _ in range(40):
        truth, drawn = generator.uniform((3.0, 2.0), (5.0, 4.0)), generator.uniform((3.0, 2.0), (5.0, 4.0), draws)
        record = motion(*truth, generator.uniform()) + 0.1 * generator.standard_normal(time.size)
        runs = np.array([motion(*one, 0.0) for one in drawn])
        likelihood = of_features({"torque": record}, {"torque": runs}, 0.05, 5.0)
        weights = special.softmax(likelihood)
        for k in range(2):
            low, high = (weighted_quantile(drawn[:, k], weights, share) for share in (0.05, 0.95))
            inside.append(low <= truth[k] <= high)
        best = {"torque": runs[np.argmax(likelihood)]}
        explained.append(features_goodness({"torque": record}, best, 0.05, 5.0)["torque"].explained)
        other = {"torque": record + 2.0 * (record > 1.0)}
        scaled.append(features_goodness(other, best, 0.05, 5.0)["torque"].explained)
    assert 0.83 <= np.mean(inside) <= 0.99
    assert np.mean(explained) >= 0.98
    assert np.mean(scaled) <= 0.1


def test_a_band_holds_its_share():
    generator = np.random.default_rng(4)
    runs = generator.standard_normal((500, 200))
    low, high = predictive_band(runs, np.full(500, 1 / 500), 1.0, 0.9)
    truth = generator.standard_normal(200) * np.sqrt(2.0)
    assert 0.84 < np.mean((low < truth) & (truth < high)) < 0.96


def test_draws_without_a_likelihood_have_no_weight_at_any_power():
    """As of numbers that do not fit together; without a warning at the power 0 of a likelihood that few draws share."""

    def log_density(normal):
        return np.where(normal[:, 0] > 0.0, -1e9 * (normal[:, 0] - 1.0) ** 2, -np.inf)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sample(lambda cube: log_density(special.ndtri(cube)), 1, members=8, rounds=1, effective=8.0, seed=1)
    assert found.power < 1e-6
    assert not found.weights[found.cube[:, 0] < 0.5].any()
    assert found.weights.sum() == pytest.approx(1.0)
