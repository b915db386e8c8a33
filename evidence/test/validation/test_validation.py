# SPDX-License-Identifier: Apache-2.0
"""Measured beside computed: against records of rigs, where they are at hand, and against made-up ones."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid
from typer.testing import CliRunner

from drill_twin.api import load_scene
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError
from drill_twin.scene.schema import number_at
from drill_twin_evidence.validation import Comparison, blind_test, data_folder, two_depths, ufrj, well_b
from drill_twin_evidence.validation.comparison import VARIABLE, Trace, Validation, cycle_length
from drill_twin_evidence.validation.page import table, to_page

FOLDER = Path(os.environ.get(VARIABLE, "no such folder"))
NO_RECORD = f"the record is not part of the package; {VARIABLE} names the folder that has it"


@pytest.mark.skipif(not (FOLDER / "ufrj_rig").is_dir(), reason=NO_RECORD)
def test_the_bit_of_the_laboratory_rig_is_predicted_within_the_aims():
    found = ufrj.validate(FOLDER / "ufrj_rig", refit=False)
    fit, prediction, naive, *features = found.comparisons
    assert fit.kind == "fit"
    assert {row.kind for row in found.comparisons[1:]} == {"prediction"}
    assert fit.met
    assert prediction.met
    assert prediction.computed < 0.2 * naive.computed
    assert [row.what for row in features if not row.met] == []


@pytest.mark.long
@pytest.mark.skipif(not (FOLDER / "well_b").is_dir(), reason=NO_RECORD)
def test_the_start_up_of_well_b_sticks_and_slips_as_recorded():
    found = well_b.validate(FOLDER / "well_b", refit=False).comparisons
    assert {row.kind for row in found} == {"fit"}
    assert [row.what for row in found if not row.met] == []


@pytest.mark.long
@pytest.mark.skipif(not (FOLDER / "well_b").is_dir(), reason=NO_RECORD)
def test_the_search_is_never_worse_than_the_numbers_it_begins_with(monkeypatch, tmp_path):
    monkeypatch.setattr(well_b, "GENERATIONS", 0)
    monkeypatch.setattr(well_b, "POPULATION", len(well_b.FREE))
    played = well_b.set_point(FOLDER / "well_b", tmp_path)
    scene = load_scene("well_b", played | {"effects.wall_friction.decay": 30.0})
    before = {key: [number_at(scene, key)] for key in well_b.FREE}
    found = well_b.search(FOLDER / "well_b", [scene])
    after = {key: [value] for key, value in found.items()}
    old, new = (
        well_b.misfit(FOLDER / "well_b", well_b.runs_of(FOLDER / "well_b", scene, vary)[0]) for vary in (before, after)
    )
    assert new <= old


@pytest.mark.skipif(not (FOLDER / "well_b").is_dir(), reason=NO_RECORD)
def test_the_blind_prediction_is_judged_as_it_was_written_down():
    share, *rows = blind_test.verdict(FOLDER / "well_b", two_depths.PREDICTION)
    assert share.computed == pytest.approx(0.9, abs=0.01)
    twin, published = rows[0], rows[4]
    assert (twin.computed, published.computed) == (pytest.approx(0.56, abs=0.005), pytest.approx(0.61, abs=0.005))
    assert [row.met for row in rows] == [False] * 8


@pytest.mark.long
@pytest.mark.skipif(not (FOLDER / "well_b").is_dir(), reason=NO_RECORD)
def test_the_joint_fit_holds_periods_and_break_offs_of_both_start_ups_at_its_elements():
    fit = two_depths.FITS["fit to both, 40 elements"]
    for depth in fit.depths:
        run = two_depths.run_of(FOLDER / "well_b", depth, fit)
        _, torque, period, _ = well_b.comparisons(FOLDER / "well_b", run)
        assert torque.met
        assert period.met


def test_a_line_drawn_by_its_corners_has_no_gaps(tmp_path):
    (tmp_path / "B2235_torque_rec.csv").write_text("0,0\n3,0\n3.01,1\n3.02,2\n3.03,3\n4,3\n")
    found = well_b.torque_record(tmp_path, 2235.0).at("motor_torque", np.array([1.0, 2.0, 3.0, 4.0]))
    assert found[:3] == pytest.approx([0.0, 0.0, 0.0], abs=1.0)
    assert found[3] == pytest.approx(2970.0, rel=0.01)


def test_half_of_the_turn_that_locks_torsion_is_taken_back_before_the_start_up(tmp_path):
    (tmp_path / "B2235_top_rec.csv").write_text("0,0\n5,0\n10,60\n60,60\n")
    overrides = well_b.set_point(tmp_path, tmp_path, 2235.0, wound=8.0)
    time, speed = np.loadtxt(str(overrides["rig.table.file"]), delimiter=",", skiprows=1).T
    before = time < well_b.LEAD
    assert trapezoid(speed[before], time[before]) == pytest.approx(4.0, rel=0.02)
    assert np.interp(well_b.LEAD + 20.0, time, speed) == pytest.approx(60.0 * well_b.RPM)


def test_the_length_of_a_cycle_is_found_between_two_lags():
    time = np.arange(0.0, 40.0, 0.05)
    values = 3.0 + np.sin(2.0 * np.pi * time / 3.95) + 0.1 * np.sin(2.0 * np.pi * time / 0.7)
    assert cycle_length(values, 0.05, 2.5, 6.0) == pytest.approx(3.95, rel=0.01)


def test_a_missed_aim_is_told_and_a_number_without_an_aim_is_not_judged():
    rows = [
        Comparison("peak [N m]", "prediction", 10.0, 10.4, 0.05),
        Comparison("period [s]", "fit", 4.0, 5.0, 0.05),
        Comparison("rms error", "fit", None, 0.6, 0.5),
        Comparison("naive", "prediction", None, 0.9, math.inf),
    ]
    line = np.arange(3.0)
    found = Validation("made_up", "a_scene", "About.", rows, [Trace("torque", line, line, line)], 1.0)
    assert [row[-1] for row in table(found).rows] == ["met", "missed", "missed", ""]
    assert "| period [s] | fit | 4 | 5 | 25.0% | 5% | missed |" in to_page([found], "validation")


def test_a_record_of_another_name_is_told():
    with pytest.raises(ArgumentError, match='--only: expected a part of ufrj_rig, well_b, found "nope"'):
        CliRunner().invoke(app, ["study", "validate", "--only", "nope"], catch_exceptions=False)


def test_records_that_are_not_there_are_asked_for(tmp_path):
    with pytest.raises(ArgumentError, match=f"expected a folder with ufrj_rig/ or well_b/, found none.*{VARIABLE}"):
        data_folder(None, {})
    assert data_folder(None, {VARIABLE: str(tmp_path)}) == tmp_path
    done = CliRunner().invoke(app, ["study", "validate", "--data", str(tmp_path)])
    assert "expected a folder ufrj_rig or well_b, found none" in str(done.exception)
