# SPDX-License-Identifier: Apache-2.0
"""The sampler against posteriors in closed form, and R-hat against chains that do not agree."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit.sampler import Chains, sample


def test_a_narrow_correlated_gaussian_is_found():
    # Data 1.0 = z0 + z1 and 0.2 = z0 - z1 with errors 0.05 and 0.5, prior N(0, 1): Gaussian posterior.
    rows, errors, seen = np.array([[1.0, 1.0], [1.0, -1.0]]), np.array([0.05, 0.5]), np.array([1.0, 0.2])
    white = rows / errors[:, None]
    covariance = np.linalg.inv(white.T @ white + np.eye(2))
    mean = covariance @ white.T @ (seen / errors)

    def fits(z):
        return -0.5 * (((seen - z @ rows.T) / errors) ** 2).sum(axis=1)

    chains = sample(fits, 2, groups=3, walkers=40, steps=2000, seed=1, keep_every=2)
    flat = chains.z.reshape(-1, 2)
    assert flat.mean(axis=0) == pytest.approx(mean, abs=0.03)
    assert np.cov(flat.T) == pytest.approx(covariance, abs=0.02)
    assert chains.r_hat().max() < 1.02


def test_groups_that_found_different_places_are_told():
    z = np.random.default_rng(0).standard_normal((2, 50, 10, 1)) + np.array([0.0, 2.0])[:, None, None, None]
    assert Chains(z, np.zeros(z.shape[:3]), 0.2).r_hat()[0] > 1.3
