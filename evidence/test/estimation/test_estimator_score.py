# SPDX-License-Identifier: Apache-2.0
"""The score of the estimator, by members."""

import json
import math
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin_evidence.estimation.score import _warnings

SMALL = ["estimator-score", "--only=stick_slip", "--truths=1", "--seconds=16", "--members=4"]


def test_score_tells_numbers_bands_and_virtual_sensors():
    done = CliRunner().invoke(app, [*SMALL, "--json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)["stick_slip"]
    assert found["numbers"]["load_factor"]["median_error"] < 0.02
    assert 0.0 <= found["numbers_held"] <= 1.0
    assert found["sensors"]["weight_on_bit"]["error_over_open_loop"] < 0.5


def test_several_members_give_error_against_members_and_processor_time():
    done = CliRunner().invoke(app, [*SMALL, "--members=8"])
    assert done.exit_code == 0, done.output
    rows = [line.split("|")[1:-1] for line in done.stdout.splitlines() if line.startswith("|")]
    assert [row[0].strip() for row in rows[2:]] == ["4", "8"]
    few, more = (float(row[4]) for row in rows[2:])
    assert 0.0 <= few <= more
    assert all(float(row[1].strip().rstrip("%")) >= 0.0 for row in rows[2:])


@pytest.mark.parametrize("option", ["--members=0", "--only=no_such_case"])
def test_what_cannot_be_scored_is_refused(option):
    assert CliRunner().invoke(app, ["estimator-score", option]).exit_code != 0


def followed(onset: float, *warnings: float) -> SimpleNamespace:
    band = SimpleNamespace(chance=0.0, time=60.0)
    return SimpleNamespace(onset=onset, warnings=list(warnings), estimates=[band])


def test_a_warning_long_before_the_onset_is_a_false_alarm():
    runs = [followed(30.0, 27.0, 29.5), followed(30.0, 5.0), followed(30.0, 29.0), followed(math.nan, 8.0)]
    told = _warnings(runs)
    assert (told["onsets"], told["warned_ahead"], told["median_lead_s"]) == (3, 1, 3.0)
    assert told["false_alarms"] == 2
    assert told["calm_hours"] == pytest.approx((3 * 30.0 + 60.0) / 3600.0)
