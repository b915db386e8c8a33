# SPDX-License-Identifier: Apache-2.0
"""The hanging rod: elements against closed forms, and what its spectra show."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit import hanging_rod
from drill_twin_evidence.rotor_kit.hanging_rod import (
    ALL_MODES,
    DENSITY,
    DIAMETER,
    MEASURED,
    ROD,
    SECOND_MODES,
    STUB,
    TAIL,
    YOUNG,
    Rod,
    drift,
    errors,
    free_lines,
    locked_lines,
    root_fitted_on,
    root_of,
)

AREA, SECOND = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64


def test_clamped_rod_without_bodies_and_weight(monkeypatch):
    monkeypatch.setattr(Rod, "bodies", lambda _: [])
    length = STUB + ROD + TAIL
    exact = 1.8751**2 / (2 * np.pi * length**2) * np.sqrt(YOUNG * SECOND / (DENSITY * AREA))
    assert Rod(False, 1e9, gravity=0.0).frequencies()[0] == pytest.approx(exact, rel=1e-3)


def test_a_limp_root_swings_as_a_pendulum(monkeypatch):
    monkeypatch.setattr(Rod, "bodies", lambda _: [])
    length = STUB + ROD + TAIL
    exact = np.sqrt(1.5 * 9.81 / length) / (2 * np.pi)  # rigid rod on a hinge
    assert Rod(False, 1e-6).frequencies()[0] == pytest.approx(exact, rel=2e-3)


def test_finer_elements_change_nothing(monkeypatch):
    coarse = Rod(True, 330.0, 3e4).frequencies()
    monkeypatch.setattr(hanging_rod, "ELEMENTS", (4, 28, 4))
    assert Rod(True, 330.0, 3e4).frequencies() == pytest.approx(coarse, rel=1e-4)


@pytest.mark.parametrize(("rig", "mode"), [("LD", 0), ("LD", 1), ("ROD", 0), ("ROD", 1)])
def test_a_root_gives_the_frequency_it_was_fitted_on(rig, mode):
    root = root_of(MEASURED[rig][mode], mode, with_disc=rig == "LD")
    assert Rod(rig == "LD", root).frequencies()[mode] == pytest.approx(MEASURED[rig][mode], rel=1e-5)


def test_one_number_is_not_enough_and_a_root_that_gives_way_meets_three_of_four():
    for rig in MEASURED:
        for mode in (0, 1):
            root = root_of(MEASURED[rig][mode], mode, with_disc=rig == "LD")
            assert np.abs(errors(root, np.inf)).max() > 5.0
    found = np.abs(errors(*root_fitted_on(SECOND_MODES)))
    assert found[[0, 1, 3]].max() < 5.0
    assert found[2] > 5.0
    assert np.abs(errors(*root_fitted_on(ALL_MODES))).max() < 5.0


def test_half_the_rotation_is_locked_where_it_meets_the_mode(rod_folder):
    # A whirl at a frequency of its own would not sit at exactly half of three different rotations.
    locked = {
        (rig, run): [line.nominal_rpm for line in locked_lines(rod_folder, run, rig, 0.5) if line.above > 5.0]
        for run, rig in (("CCWUP", "LD"), ("CCWDOWN", "LD"), ("CCWUP", "ROD"))
    }
    assert locked == {("LD", "CCWUP"): [150], ("LD", "CCWDOWN"): [125], ("ROD", "CCWUP"): [200]}
    beside = {line.nominal_rpm: line.above for line in locked_lines(rod_folder, "CCWUP", "LD", 1.5)}
    assert beside[150] > 5.0
    assert beside[125] < 5.0


def test_the_free_line_stays_where_it_is_while_the_rotation_grows_eightfold(rod_folder):
    lines = free_lines(rod_folder, "CCWUP", "LD", (1.0, 1.45))
    assert len(lines) == 8
    slope, error = drift(lines)
    assert abs(slope) < 0.1 + 2 * error
    assert 1.05 < np.median([line.frequency for line in lines]) < 1.3
