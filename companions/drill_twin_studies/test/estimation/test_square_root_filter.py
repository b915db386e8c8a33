# SPDX-License-Identifier: Apache-2.0
"""Ensemble square-root filter against the Kalman filter of another library."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from drill_twin_studies.estimation.square_root_filter import applied, correction, corrections


def oscillator(step):
    """Two damped masses on springs, by the exact exponential: states x1, x2, v1, v2 and an unknown constant load."""
    rates = np.zeros((5, 5))
    rates[:2, 2:4] = np.eye(2)
    rates[2] = [-5.0, 3.0, -0.3, 0.1, 1.0]
    rates[3] = [3.0, -4.0, 0.1, -0.2, 0.0]
    values, vectors = np.linalg.eig(rates * step)
    return (vectors * np.exp(values) @ np.linalg.inv(vectors)).real


@pytest.mark.parametrize("members", [6, 40])
def test_linear_gaussian_case_is_that_of_a_kalman_filter(members):
    draw = np.random.default_rng(3)
    forward, sees = oscillator(0.1), np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]])
    variance = np.array([0.04, 0.09])
    ensemble = draw.standard_normal((members, 5)) * [1.0, 2.0, 0.5, 0.7, 3.0] + [0.0, 1.0, 0.0, 0.0, 2.0]
    exact = KalmanFilter(dim_x=5, dim_z=2)
    exact.x, exact.P = ensemble.mean(axis=0)[:, None], np.cov(ensemble.T)
    exact.F, exact.H, exact.R, exact.Q = forward, sees, np.diag(variance), np.zeros((5, 5))
    truth = draw.standard_normal(5)
    for number in range(200):
        truth, ensemble = forward @ truth, ensemble @ forward.T
        exact.predict()
        measured = sees @ truth + np.sqrt(variance) * draw.standard_normal(2)
        if number % 7 == 3:
            measured[1] = np.nan  # a missing value
        found = correction(ensemble @ sees.T, measured, variance)
        ensemble = found.apply(ensemble)
        known = np.isfinite(measured)
        exact.update(measured[known][:, None], R=np.diag(variance[known]), H=sees[known])
        innovation = exact.y.ravel() @ exact.SI @ exact.y.ravel()
        np.testing.assert_allclose(ensemble.mean(axis=0), exact.x[:, 0], rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(np.cov(ensemble.T), exact.P, rtol=0.0, atol=1e-10)
        assert found.surprise == pytest.approx(innovation, abs=1e-9)


def test_nothing_measured_changes_nothing():
    ensemble = np.random.default_rng(1).standard_normal((8, 3))
    found = correction(ensemble[:, :1], np.array([np.nan]), np.array([1.0]))
    np.testing.assert_array_equal(found.apply(ensemble), ensemble.mean(axis=0) + (ensemble - ensemble.mean(axis=0)))
    assert found.surprise == 0.0


def test_values_of_any_shape_are_corrected_alike():
    draw = np.random.default_rng(2)
    ensemble = draw.standard_normal((12, 2, 3))
    found = correction(ensemble[:, 0, :1], np.array([0.4]), np.array([0.1]))
    flat = found.apply(ensemble.reshape(12, 6))
    np.testing.assert_allclose(found.apply(ensemble).reshape(12, 6), flat, atol=1e-14)
    assert np.var(flat[:, 0], ddof=1) < np.var(ensemble[:, 0, 0], ddof=1)


def test_numbers_keep_their_spread_where_nothing_acts_on_what_is_measured():
    draw = np.random.default_rng(5)
    kept = plain = draw.standard_normal((64, 3))
    for _ in range(20):  # windows of chaotic motion, which the numbers do not determine
        found = correction(draw.standard_normal((64, 10)), draw.standard_normal(10), np.full(10, 0.01))
        kept, plain = found.apply_to_numbers(kept), found.apply(plain)
    assert kept.std(axis=0).min() > 0.4
    assert plain.std(axis=0).max() < 0.3
    assert np.all(np.abs(kept.mean(axis=0)) < 1.0)


def test_what_is_measured_moves_numbers_as_the_filter_says():
    draw = np.random.default_rng(6)
    numbers = draw.standard_normal((400, 2))
    predicted = numbers @ np.array([[1.0], [0.2]]) + 0.1 * draw.standard_normal((400, 1))
    found = correction(predicted, np.array([1.3]), np.array([0.01]))
    np.testing.assert_allclose(found.apply_to_numbers(numbers), found.apply(numbers), atol=0.08)
    assert found.apply_to_numbers(numbers)[:, 0].std() < 0.3
    assert found.directions == pytest.approx(1.0, abs=0.02)


def test_where_a_number_acts_less_its_band_is_wider():
    draw = np.random.default_rng(8)
    numbers = draw.standard_normal((400, 1))
    predicted = np.exp(1.5 * numbers) + 0.05 * draw.standard_normal((400, 1))
    low, high = (correction(predicted, np.array([value]), np.array([0.01])) for value in (0.1, 4.0))
    assert low.near.sum() == pytest.approx(133, abs=2)
    assert low.apply_to_numbers(numbers).std() > 1.2 * low.apply(numbers).std()
    assert high.apply_to_numbers(numbers).std() < low.apply_to_numbers(numbers).std()


def test_corrections_by_means_and_by_what_varies_are_together_that_by_all_samples():
    draw = np.random.default_rng(7)
    state = draw.standard_normal((12, 5))
    predicted = np.tensordot(state, draw.standard_normal((5, 2, 6)), axes=1)
    measured, deviation = draw.standard_normal((2, 6)), np.array([0.3, 2.0])
    measured[0, 2] = np.nan
    once = correction(predicted.reshape(12, -1), measured.ravel(), np.repeat(deviation**2, 6)).apply(state)
    twice = applied(corrections(predicted, measured, deviation), state)
    np.testing.assert_allclose(twice.mean(axis=0), once.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(np.cov(twice.T), np.cov(once.T), atol=1e-12)
    assert corrections(predicted, np.full((2, 6), np.nan), deviation) == []
