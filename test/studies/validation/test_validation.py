# SPDX-License-Identifier: Apache-2.0
"""Measured beside computed: against records of rigs, where they are at hand, and against made-up ones."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.errors import ArgumentError
from drill_twin.studies.validation import Comparison, data_folder, ufrj, well_b
from drill_twin.studies.validation.comparison import VARIABLE, Trace, Validation, cycle_length
from drill_twin.studies.validation.page import cells, to_page

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
def test_the_start_up_of_well_b_sticks_and_slips_with_the_recorded_period():
    error, _, period, _ = well_b.validate(FOLDER / "well_b", refit=False).comparisons
    assert error.computed < 0.8
    assert period.computed == pytest.approx(period.measured, rel=0.08)  # 0.05 where the friction is fitted anew


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
    assert [row[-1] for row in cells(found)] == ["met", "missed", "missed", ""]
    assert "| period [s] | fit | 4 | 5 | 25.0% | 5% | missed |" in to_page([found], "validation")


def test_records_that_are_not_there_are_asked_for(tmp_path):
    with pytest.raises(ArgumentError, match=f"expected a folder with ufrj_rig/ or well_b/, found none.*{VARIABLE}"):
        data_folder(None, {})
    assert data_folder(None, {VARIABLE: str(tmp_path)}) == tmp_path
    done = CliRunner().invoke(app, ["validate", "--data", str(tmp_path)])
    assert "expected a folder ufrj_rig or well_b, found none" in str(done.exception)
