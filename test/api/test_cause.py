# SPDX-License-Identifier: Apache-2.0
"""Cause of whirl, of runs whose cause is known: the effect that is named, and what ends the whirl."""

import json

import pytest
from rod_scenes import ROLLING, WALLED, quiet_scene
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.api.repeats import Repeats, Trial
from drill_twin.cli.app import app

SOON = {"wob": 5, "rig.weight_on_bit.duration": 2, "rig.rotation.duration": 2}
UNBALANCE = "with 0.1 of bow and eccentricity"


def by_change(cause):
    return {trial.change.split(" (")[0]: trial for trial in cause.trials}


def test_a_run_without_whirl_says_so_and_repeats_nothing(tmp_path):
    run = dt.Simulation("pa6_bench", {**SOON, "rpm": 60}).run(duration=5)
    cause = dt.why(run)
    assert str(cause).startswith("The run does not whirl, at 5 N at 1 rev/s at its end. Small motion about the axis")
    assert "decays" in str(cause)
    assert cause.causes == ()
    assert cause.trials == ()
    run.to_bag(tmp_path / "bag")
    told = CliRunner().invoke(app, ["analyze", str(tmp_path / "bag"), "--why", "--json"])
    assert json.loads(told.stdout)["cause"] == {"sentences": list(cause.sentences), "causes": [], "trials": []}


def test_the_record_of_a_rig_cannot_be_repeated(tmp_path):
    record = tmp_path / "rig.csv"
    record.write_text("time [s],wob [N],rpm [rpm]\n" + "".join(f"{k * 0.1},100,120\n" for k in range(50)))
    with pytest.raises(dt.BagError, match="expected the bag of a run with its scene"):
        dt.why(dt.read_bag(record))


def test_weight_and_speed_at_the_onset_are_those_of_the_ramp(monkeypatch):
    run = dt.Simulation("pa6_bench", {"wob": 10, "rpm": 390, "effects.bow.amplitude": "2 mm"}).run(duration=8)
    repeats = Repeats(run.recording, run.summary, lambda *_: None)
    before = (run.rig.time > repeats.onset - 1.0) & (run.rig.time <= repeats.onset)
    turns = float(run.rig.top_drive_speed[before].mean())
    assert repeats.at_onset.endswith(f"at {repeats.units.text(turns, 'rotation')}")
    assert turns < 0.9 * repeats.command.rotation
    assert repeats.steady.rotation == pytest.approx(turns, rel=0.02)  # modes are those at the onset
    plans = [plan.split(" (")[0] for _, plan, *_ in repeats.plans()]
    assert plans[:2] == ["without internal damping", "without wall friction"]
    assert plans[-1] == "at 0.5 of the wall friction"
    outcome = "no whirl, 88% of the lateral motion; the slowest mode decays with 0.2 1/s"
    trial = Trial("without wall friction", True, False, outcome, "", None, -0.2, moves=True)
    by_chance = Trial("without bow", True, False, "no whirl, 0% of the lateral motion (1 of 2 beside)", "", None, -0.2)
    monkeypatch.setattr(Repeats, "trials", lambda _: iter([trial, by_chance]))
    cause = dt.why(run)
    assert not cause.causes
    assert "The cause is not known; without wall friction it is no whirl, but more than half of the" in str(cause)
    assert f"without wall friction: {outcome}" in str(cause)
    monkeypatch.setattr("drill_twin.api.cause.buckling", lambda *_: " The weight buckles the string.")
    assert "Buckling takes it off the axis; what then makes it whirl is not known; without wall" in str(dt.why(run))
    assert "Small motion about the axis of the hole at the onset" in str(cause)


@pytest.mark.long
def test_internal_damping_above_the_critical_speed():
    cause = dt.why(dt.Simulation("pa6_bench", {**SOON, "rpm": 180}).run(duration=12))
    assert cause.causes == ("without internal damping",)
    trials = by_change(cause)
    assert trials["without internal damping"].growth_per_s < 0.0
    assert trials["without wall friction"].outcome.startswith("still whirls")
    # Less unbalance only delays a growth: it is no cause.
    assert not trials[UNBALANCE].ends_whirl
    assert "it comes later" in trials[UNBALANCE].outcome
    assert "The growth about the axis ends" in str(cause)


@pytest.mark.long
def test_resonance_of_the_unbalance():
    near_critical = {**SOON, "rpm": 52.2, "effects.eccentricity.offset": "4 mm"}
    cause = dt.why(dt.Simulation("pa6_bench", near_critical).run(duration=20))
    assert cause.causes == (UNBALANCE,)
    assert "Cause (forced, at the speed of rotation)" in str(cause)
    assert by_change(cause)["at 0.7 of the speed"].ends_whirl


@pytest.mark.long
def test_rolling_on_wall_friction():
    # A buckled rod without any damping that a kick throws at the wall: only friction makes it roll.
    kicked = {
        **ROLLING,
        "internal_damping": {"bending_time": 0.0},
        "lateral_kick": {"velocity": 0.3, "shape": "hump"},
        "bow": {"amplitude": 1e-4},
    }
    scene = quiet_scene(kicked, of=WALLED, radius=0.04, step=2e-3, weight_on_bit=20.0)
    run = dt.Simulation(scene, {"rpm": 180, "rig.duration": 8}).run()
    assert run.summary["lasting_motion"] == "rolling along the wall"
    cause = dt.why(run)
    assert cause.causes == ("without wall friction",)
    assert "The weight buckles the string" in str(cause)
