# SPDX-License-Identifier: Apache-2.0
"""Scores of predictions with known errors, synthetic rigs that the model does not have, and the figure."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit.figure import drawn
from drill_twin_evidence.rotor_kit.forecast import SPEEDS, weights_of
from drill_twin_evidence.rotor_kit.records import PROBES, Records
from drill_twin_evidence.rotor_kit.score import scores, table_of
from drill_twin_evidence.rotor_kit.synthetic import LIKE, Truth

LOADS = {"BASE": (0, 0), "A001": (30, 0), "A002": (0, 30), "A003": (40j, 0), "A004": (0, -50), "A005": (3, 3)}
RESPONSE = np.array([[0.06, 0.05], [0.1, 0.09], [0.19 - 0.05j, 0.22], [0.16, 0.19 + 0.04j]])


def a_record():
    """Six conditions of one session that superpose exactly."""
    loads = np.array(list(LOADS.values()), complex)
    count = len(LOADS)
    vectors = loads @ RESPONSE.T + np.array([3, 5j, 9, -3 + 8j])
    flat = np.ones(count, int)
    return Records(tuple(LOADS), ("S1",) * count, flat, 0 * flat, 1005.0 * flat, loads, vectors)


def predicted(data, *, larger=0.0, later=0.0, half_width=0.05):
    """Predictions with errors of amplitude (a part) and phase [deg], and bands of a part and 3 degrees."""
    rows = []
    for row, name in enumerate(data.condition):
        net = RESPONSE @ data.unbalance[row]
        for i, probe in enumerate(PROBES):
            said = {"condition": name, "probe": probe}
            for suffix, vector in (("", data.vectors[row, i]), ("_net", net[i])):
                size, angle = abs(vector) * (1 + larger), np.angle(vector, deg=True) + later
                said |= {f"amp_um{suffix}": size, f"amp_low{suffix}": size * (1 - half_width) - 1e-9}
                said |= {f"amp_high{suffix}": size * (1 + half_width) + 1e-9, f"phase_deg{suffix}": angle}
                said |= {f"phase_low{suffix}": angle - 3.0, f"phase_high{suffix}": angle + 3.0}
            rows.append({key: str(value) for key, value in said.items()})
    return rows


def test_scores_are_the_errors_that_were_put_in():
    data = a_record()
    exact = scores(data, predicted(data))
    assert exact["vectors"] == 8  # four conditions of 20 g mm or more, not BASE, two probes
    assert exact["amplitude_rms_percent"] == pytest.approx(0.0, abs=0.01)
    assert exact["held_percent"] == 100.0
    wrong = scores(data, predicted(data, larger=0.1, later=357.0 + 8.0))
    assert wrong["amplitude_rms_percent"] == pytest.approx(10.0, abs=0.01)
    assert wrong["phase_rms_deg"] == pytest.approx(5.0, abs=0.01)
    assert wrong["held_percent"] == 0.0
    assert scores(data, predicted(data, larger=0.1))["held_percent"] == 50.0  # phases still hold


def test_weights_come_back_from_their_vectors():
    rng = np.random.default_rng(0)
    true = np.array([30.0 + 10j, -20.0 + 5j])
    response, spread = np.broadcast_to(RESPONSE, (4000, 4, 2)), np.full((4000, 4), 1e-3)
    drawn_weights = weights_of(RESPONSE @ true, response, spread, 45.0, rng)
    assert drawn_weights.mean(axis=0) == pytest.approx(true, abs=0.05)
    wide = weights_of(RESPONSE @ true, response, np.full((4000, 4), 0.5), 45.0, rng)
    assert wide.sum(axis=1).std() < 0.5 * wide[:, 0].std()  # the sum is known better than a disc


def test_a_synthetic_rig_is_like_the_record_and_not_of_the_model():
    truth = Truth.drawn(np.random.default_rng(4))
    size = np.abs(truth.rig.sensitivities([SPEEDS[0]])[0, 0]).mean(axis=1)[1:]
    assert np.all(np.abs(np.log(size / LIKE)) < np.log(1.3))
    assert truth.rotors.discs.mass[0, 0] != truth.rotors.discs.mass[0, 1]
    damping = truth.rotors.bearings.damping[0, 0]
    assert damping[0, 0] != damping[1, 1]


def test_the_figure_shows_the_band(predictions):
    axes = drawn(table_of(predictions / "rk4_run_up.csv")).axes[0]
    rpm, height = axes.lines[0].get_data()
    assert rpm[0] < 1100
    assert rpm[-1] > 4900
    assert 1640 < rpm[np.argmax(np.where(rpm < 3000, height, 0))] < 1950
