# SPDX-License-Identifier: Apache-2.0
"""The campaign of random scenes: broken off and continued it ends with the same table; its verdicts."""

import json
import math

import campaign
import pytest

from drill_twin.core.errors import ArgumentError
from drill_twin_evidence.stress.run import RunStatistics
from drill_twin_evidence.verify.scenes import WALLED

AUDITED = frozenset(WALLED) | {"lateral_kick"}
"""The set of the tests of the energy audit, whose kernel these share."""
SCENES = 12


@pytest.fixture
def one_set(monkeypatch):
    monkeypatch.setattr(campaign, "SETS", [AUDITED - {"stretch", "torsion"}])


@pytest.mark.usefixtures("one_set")
def test_broken_off_and_continued_it_ends_with_the_same_table(tmp_path):
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    expected = campaign.run(SCENES, whole)
    assert [result.number for result in expected] == list(range(SCENES))
    assert all(result.outcome in {"ran", "refused", "stopped"} for result in expected), expected
    assert sum(result.outcome == "ran" for result in expected) > SCENES / 2
    campaign.run(5, part)
    part.write_text(part.read_text("utf-8")[:-9], "utf-8")  # killed within a line
    assert campaign.report(campaign.run(SCENES, part)) == campaign.report(expected)
    assert part.read_text("utf-8") == whole.read_text("utf-8")


@pytest.mark.usefixtures("one_set")
def test_results_of_other_physics_are_not_continued(tmp_path):
    path = tmp_path / "results.jsonl"
    path.write_text(json.dumps({"campaign": {"physics": "another", "sets": 1}}) + "\n", "utf-8")
    with pytest.raises(ArgumentError, match="found results of another physics"):
        campaign.run(1, path)


def test_every_scene_of_a_round_runs_once():
    assert sorted(campaign.order(2500)) == list(range(2500))
    assert max(list(campaign.order(2500))[:1000]) == 999


def test_verdicts():
    found = RunStatistics()
    assert campaign.verdict(found, 0.5, "") == ("ran", "")
    assert campaign.verdict(found, 1.1, "") == ("wrong", "deeper in the wall than allowed")
    assert campaign.verdict(found, 0.0, "it leaned 80 degrees from the upright") == ("stopped", "leans")
    assert campaign.verdict(found, 0.0, "the equations had no solution")[0] == "given up"
    found.energy = 0.2
    assert campaign.verdict(found, 0.0, "") == ("wrong", campaign.NOT_BALANCED)
    found.finite = False
    assert campaign.verdict(found, 0.0, "") == ("wrong", "not finite")


def test_more_than_a_hundredth_given_up_is_a_failure(monkeypatch, capsys):
    def results(lost):
        return [
            campaign.Result(n, "given up" if n < lost else "ran", "no solution", 10, 20, 0, 0, math.nan, 0.0)
            for n in range(200)
        ]

    for lost, code in ((2, 0), (3, 1)):
        monkeypatch.setattr(campaign, "run", lambda *_, lost=lost: results(lost))
        assert campaign.main(["--scenes", "200"]) == code
        assert f"| {200 - lost} |" in capsys.readouterr().out


@pytest.mark.long
def test_the_lateral_form_converges_where_a_stabiliser_rubs():
    """Its factors and their rate of convergence were once kept where only the contact at the bit had changed."""
    number = 1750
    assert campaign.SETS[number % len(campaign.SETS)] == {"bit_stabiliser", "bow"}
    result = campaign.result_of(number)
    assert (result.outcome, result.refined) == ("ran", 0)
    assert result.energy < 0.01
