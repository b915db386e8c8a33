# SPDX-License-Identifier: Apache-2.0
"""The analyzer on orbits of the measured vectors, and on run-ups of rigs of the posterior."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit import records
from drill_twin_evidence.rotor_kit.fit import loaded
from drill_twin_evidence.rotor_kit.orbits import CLEARANCE, analysed, backward_share, orbit, run_ups, with_whirl

SPREAD = ("BASE", "A024", "B012", "B036", "BLND01", "A027")


@pytest.fixture(scope="module")
def data(kit_file):
    return records.read(kit_file)


def test_backward_share_of_known_orbits():
    # Lag: forward has y a quarter turn later than x.
    assert backward_share(1 + 0j, np.exp(0.5j * np.pi)) == pytest.approx(0.0, abs=1e-12)
    assert 1 / backward_share(1 + 0j, np.exp(-0.5j * np.pi)) == pytest.approx(0.0, abs=1e-12)
    assert backward_share(1 + 0j, 1 + 0j) == pytest.approx(1.0)


@pytest.mark.parametrize("condition", SPREAD)
@pytest.mark.parametrize("first", [0, 2])
def test_unbalance_is_no_whirl_and_its_precession_is_that_of_the_vectors(data, condition, first):
    row = data.rows(condition)[0]
    x, y = data.vectors[row, first], data.vectors[row, first + 1]
    found = analysed(*orbit(x, y, data.rpm[row], np.random.default_rng(row)), data.rpm[row] * np.pi / 30)
    assert found.onset is None
    assert {line["state"] for line in found.motion} == {"rotation about a fixed axis"}
    sense = 1 if backward_share(x, y) < 1 else -1
    assert np.nanmedian(found.precession) == pytest.approx(sense * data.rpm[row] / 60, rel=0.05)


@pytest.mark.parametrize("ratio", [0.47, -0.6])
def test_a_whirl_beside_the_measured_unbalance_is_found_with_its_sense(data, ratio):
    row = data.rows("A024")[0]
    rpm = data.rpm[row]
    time, position = orbit(data.vectors[row, 2], data.vectors[row, 3], rpm, np.random.default_rng(1))
    whirling = with_whirl(position, time, ratio=ratio, radius=0.12 * CLEARANCE, rpm=rpm, start=3.0)
    found = analysed(time, whirling, rpm * np.pi / 30)
    assert 3.0 < found.onset_s < 4.0
    assert found.frequency_hz == pytest.approx(ratio * rpm / 60, rel=0.02)
    assert found.motion[-1]["state"] == ("forward whirl" if ratio > 0 else "backward whirl")


def test_a_run_up_through_a_critical_speed_is_told_as_synchronous(predictions):
    found = run_ups(loaded(predictions / "rk4_fit.json")[1][:8], np.random.default_rng(2))
    assert len(found) >= 6
    assert max(largest for largest, _ in found) > 0.25  # large enough for a synchronous onset
    assert not any(criterion.startswith("asynchronous") for _, criterion in found)
