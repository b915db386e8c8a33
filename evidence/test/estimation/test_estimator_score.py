# SPDX-License-Identifier: Apache-2.0
"""The score of the estimator, by members."""

import json
import math

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin_evidence.cli.output import chosen
from drill_twin_evidence.estimation.cases import CASES, JUMP
from drill_twin_evidence.estimation.hidden_truth import follow
from drill_twin_evidence.estimation.score import _warnings, lines, rate_interval, score

SMALL = ["study", "estimator-score", "--only=stick_slip", "--truths=1", "--first=1", "--duration=16", "--members=4"]


def test_score_tells_numbers_bands_and_virtual_sensors():
    done = CliRunner().invoke(app, [*SMALL[:-1], "--members=16", "--json"])  # four are too few for bands
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)["stick_slip"]
    assert found["withheld"] == 0.0
    assert found["numbers"]["load_factor"]["median_error"] < 0.02
    assert 0.0 <= found["numbers_held"] <= 1.0
    assert found["sensors"]["weight_on_bit"]["error_over_open_loop"] < 0.5


def test_several_members_give_error_against_members_and_processor_time():
    done = CliRunner().invoke(app, [*SMALL, "--members=8"])
    assert done.exit_code == 0, done.output
    rows = [line.split("|")[1:-1] for line in done.stdout.splitlines() if line.startswith("|")]
    assert [row[0].strip() for row in rows[2:]] == ["4", "8"]
    assert all(float(row[4]) >= 0.0 for row in rows[2:])
    assert all(float(row[1].strip().rstrip("%")) >= 0.0 for row in rows[2:])


@pytest.mark.parametrize("option", ["--members=0", "--only=no_such_case"])
def test_what_cannot_be_scored_is_refused(option):
    assert CliRunner().invoke(app, ["study", "estimator-score", option]).exit_code != 0


def test_a_case_of_this_name_is_meant_alone():
    assert chosen("load_jump", CASES) == ["load_jump"]
    assert chosen("load_j", CASES) == ["load_jump", "pa6_load_jump"]


def followed(onset: float, *warnings: float) -> dict:
    return {"onset": onset, "warnings": list(warnings), "seconds": 60.0}


def test_a_warning_long_before_the_onset_is_a_false_alarm():
    runs = [followed(30.0, 27.0, 29.5), followed(30.0, 5.0), followed(30.0, 29.0), followed(math.nan, 8.0)]
    told = _warnings(runs)
    assert (told["onsets"], told["warned_ahead"], told["median_lead_s"]) == (3, 1, 3.0)
    assert told["false_alarms"] == 2
    assert rate_interval(0) == (0.0, pytest.approx(3.689, abs=1e-3))
    assert rate_interval(3) == (pytest.approx(0.619, abs=1e-3), pytest.approx(8.767, abs=1e-3))
    assert told["calm_hours"] == pytest.approx((3 * 30.0 + 60.0) / 3600.0)


def test_a_jump_of_the_load_is_told_and_followed_and_friction_stays():
    row = follow(CASES["load_jump"], 7, 42.0, 16).row("load_jump", 16, 7)
    assert row["followed"]["load_factor"] <= 10.0
    assert [time - JUMP for time in row["alarms"]] == [pytest.approx(2.0)]
    assert all(most < 0.02 for most, _ in row["dragged"].values())
    found = score([row])
    assert found["jumps"]["told"] == 1
    assert any("load_factor | " in line and " s" in line for line in lines("load_jump", found))


@pytest.mark.long
def test_a_jump_is_followed_in_the_number_that_explains_it_alone():
    """Friction, as the load above."""
    case = CASES["friction_jump"]
    found = follow(case, 101, 45.0, 16)
    assert all(found.dragged(key)[0] < 0.03 for key in found.hidden if key != case.jump)
    assert found.found_after(case.jump, 0.05) < 10.0


def test_a_jump_that_no_free_number_can_explain_is_told_to_the_end_and_nothing_is_shown_of_the_bit():
    found = follow(CASES["stiffness_jump"], 100, 45.0, 16)
    late = [each for each in found.estimates if each.time > JUMP + 2.0]
    assert all("does not explain torque since 30.0 s" in each.alarm for each in late)
    assert all(math.isnan(each.sensors["bit_speed"].high) for each in late)
    assert all(found.held.values())
    assert "from 31.0 to 45.0 s" in found.estimates[-1].remembered


def test_a_campaign_that_was_broken_off_goes_on_with_the_same_truths(tmp_path):
    options = [*SMALL, f"--journal={tmp_path / 'rows.jsonl'}"]
    done = CliRunner().invoke(app, options)
    assert done.exit_code == 0, done.output
    written = (tmp_path / "rows.jsonl").read_text("utf-8")
    again = CliRunner().invoke(app, options)
    assert again.exit_code == 0, again.output
    assert (tmp_path / "rows.jsonl").read_text("utf-8") == written
    assert again.stdout == done.stdout
