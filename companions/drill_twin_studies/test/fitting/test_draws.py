# SPDX-License-Identifier: Apache-2.0
"""Draws of a fit with equal weights: for ArviZ, and against each other."""

import sys

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.errors import ArgumentError
from drill_twin_studies.fitting import Sampling

RANGES = {"wall_friction.coefficient": (0.0, 1.0), "wob": (0.0, 80.0)}


@pytest.fixture(scope="module")
def posterior():
    """Uniform draws, weighted as a Gaussian about friction 0.4, with the weight on bit bound to it."""
    cube = np.random.default_rng(2).uniform(size=(4000, 2))
    off = ((cube[:, 0] - 0.4) / 0.05) ** 2 + ((cube[:, 1] - cube[:, 0]) / 0.02) ** 2
    weights = np.exp(-0.5 * off)
    time = np.linspace(0.0, 2.0, 5)
    sampling = Sampling(cube, weights / weights.sum(), -0.5 * off, 1.0)
    runs = {"bit_speed": np.zeros((4000, 5))}
    record = dt.Record("rig.csv", {})
    return dt.Posterior(dt.load_scene("pa6_bench"), RANGES, cube * [1.0, 80.0], sampling, record, time,
                        {"bit_speed": np.arange(5.0)}, runs, 0)  # fmt: skip


def test_draws_of_equal_weight_have_the_weighted_moments(posterior):
    draws = posterior.draws
    assert draws.shape == (2000, 2)
    assert np.array_equal(draws, posterior.draws)
    assert draws[:, 0].mean() == pytest.approx(posterior.sampling.weights @ posterior.values[:, 0], abs=0.004)
    assert np.corrcoef(draws.T)[0, 1] == pytest.approx(posterior.correlation[0, 1], abs=0.02)


def test_the_corner_has_a_histogram_a_number_and_the_draws_of_each_pair(posterior):
    panels = np.reshape(posterior.plot_corner().axes, (2, 2))
    assert [[panel.get_visible() for panel in row] for row in panels] == [[True, False], [True, True]]
    assert [panel.get_xlabel() for panel in panels[1]] == list(RANGES)
    assert panels[1, 0].get_ylabel() == "wob"
    assert np.array_equal(np.transpose(panels[1, 0].lines[0].get_data()), posterior.draws)
    assert sum(patch.get_height() for patch in panels[1, 1].patches) == 2000


def test_arviz_reads_the_draws_and_the_record(posterior):
    pytest.importorskip("arviz_base", reason="arviz_base is not installed: pip install 'drill_twin[arviz]'")
    data = posterior.to_inferencedata()
    assert np.array_equal(data["posterior"]["wob"][0], posterior.draws[:, 1])
    assert data["observed_data"]["bit_speed"].sel(time=1.5).item() == 3.0


def test_without_arviz_the_extra_is_named(posterior, monkeypatch):
    monkeypatch.setitem(sys.modules, "arviz_base", None)
    with pytest.raises(ArgumentError, match=r"to_inferencedata: .* pip install 'drill_twin\[arviz\]'"):
        posterior.to_inferencedata()
