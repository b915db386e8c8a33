"""Findings of a bag with the steady whirl that each is near."""

import json

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.dynamics.rotordynamics.steady import whirl_states
from drill_twin.report.near_states import _placed
from drill_twin.scene.set_points.command import Command

FORM = ["--set", "effects.stretch=off", "--set", "effects.torsion=off", "--set", "numerics.elements=12"]


def run(*arguments):
    said = CliRunner().invoke(app, [str(one) for one in arguments])
    assert said.exit_code == 0, said.output
    return said.stdout


def test_a_whirl_is_named_by_the_state_that_it_is_on(tmp_path):
    """At 40 N and 6.5 rev/s the bench settles on its stable forward whirl."""
    run("run", "pa6_bench", "--rpm", "6.5 rev/s", "--duration", "20", "--out", tmp_path / "run", *FORM)
    summary = json.loads(run("analyze", tmp_path / "run" / "bag_0", "--states", "--json"))
    found = summary["whirl_states"]
    assert found["axis_growth_per_s"] > 0.0
    whirl = next(one for one in found["findings"] if one["finding"] == "whirl frequency")
    state = found["states"][whirl["state"]]
    assert state["stable"]
    assert state["frequency_hz"] == pytest.approx(summary["whirl_frequency_hz"], rel=0.03)
    assert "stable: the slowest disturbance decays" in whirl["sentence"]
    assert "whirl_states" not in json.loads(run("analyze", tmp_path / "run" / "bag_0", "--json"))


def test_an_inclined_hole_gives_one_sentence(tmp_path):
    run("run", "pa6_bench", "--set", "hole.inclination=90 deg", "--duration", "0.2", "--out", tmp_path / "run", *FORM)
    (note,) = json.loads(run("analyze", tmp_path / "run" / "bag_0", "--states", "--json"))["whirl_states"]["notes"]
    assert "in which no steady whirl exists" in note


class State:
    """A whirl in numbers."""

    kind, growth_frequency = "forward", 0.5

    def __init__(self, frequency, growth):
        self.frequency, self.growth = frequency, growth
        self.verdict = "not determined" if growth == 0.0 else "stable" if growth < 0.0 else "unstable"


@pytest.mark.parametrize(
    ("frequency", "state", "words"),
    [
        (1.0, 0, "unstable: the fastest disturbance grows at 0.3 1/s, oscillating at 0.50 Hz"),
        (1.5, 1, "stable: the slowest disturbance decays at 2 1/s"),
        (1.2, None, "near no steady whirl; the nearest is at +1.000 Hz"),
        (2.0, None, "at the rotation"),
    ],
)
def test_sentences(frequency, state, words):
    states = (State(1.0, 0.3), State(1.5, -2.0))
    found = _placed("whirl frequency", frequency, Command(40.0, 4.0 * 3.141592653589793), states)
    assert found["state"] == state
    assert words in found["sentence"]


def test_a_state_whose_stability_finer_meshes_change_explains_nothing():
    states = (State(1.0, 0.0), State(1.5, -2.0))
    found = _placed("whirl frequency", 1.0, Command(40.0, 4.0 * 3.141592653589793), states)
    assert "whose stability is not determined" in found["sentence"]


@pytest.mark.parametrize(("limit", "taken"), [(0, []), (2, ["a", "b"])])
def test_a_search_is_cut_short_by_its_work_and_says_so(bench, monkeypatch, limit, taken):
    """No first guess is taken after the limit, which counts evaluations, not seconds."""
    tried = []

    def add(turning, guess, _):
        tried.append(guess)
        turning.equations.evaluations += 1

    monkeypatch.setattr(whirl_states, "_guesses", lambda *_: iter("abc"))
    monkeypatch.setattr(whirl_states, "_add_near", add)
    found = whirl_states.search(whirl_states.EquationsOfMotion(bench), Command(40.0, 12.0), evaluations=limit)
    assert found == ((), False)
    assert tried == taken
    assert whirl_states.search(whirl_states.EquationsOfMotion(bench), Command(40.0, 12.0)).is_whole
