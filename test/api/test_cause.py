# SPDX-License-Identifier: Apache-2.0
"""Cause of whirl, of runs whose cause is known: the effect that is named, and what ends the whirl."""

import json

import pytest
from known_causes import CASES, UNBALANCE
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.api.cause import _Search
from drill_twin.api.repeats import Repeats, Trial
from drill_twin.cli.app import app
from drill_twin.core.severity import DEFAULT
from drill_twin.report.severity import TORSION, WHIRL, Motion
from drill_twin.report.severity import cured as is_cured

SOON = {"wob": 5, "rig.weight_on_bit.duration": 2, "rig.rotation.duration": 2}
QUICK = ("start-up", "unbalance at a critical speed")


def by_change(cause):
    return {trial.change.split(" (")[0]: trial for trial in cause.trials}


def test_a_run_without_whirl_says_so_and_repeats_nothing(tmp_path):
    run = dt.Simulation("pa6_bench", {**SOON, "rpm": 60}).run(duration=5)
    cause = dt.why(run)
    assert str(cause).startswith(
        "The run has no problem: the string does not whirl, at 5 N at 1 rev/s at its end. Small motion"
    )
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
    outcome = "no whirl (none: lateral acceleration 0.1 g rms), 88% of the run's; the slowest mode decays with 0.2 1/s"
    longer = Trial("held for 30 s longer", False, (), "spiral", None)
    trial = Trial("without wall friction", True, (), outcome, -0.2)
    monkeypatch.setattr(Repeats, "trials", lambda _: iter([longer, trial]))
    cause = dt.why(run)
    assert not cause.causes
    assert f"The cause is not known; repeats of the run that were checked: without wall friction: {outcome}" in str(
        cause
    )
    assert "Small motion about the axis of the hole at the onset" in str(cause)
    lighter = Trial("at 0.5 of the weight (5 N)", False, (WHIRL,), "no whirl", -0.2)
    monkeypatch.setattr(Repeats, "trials", lambda _: iter([longer, trial, lighter]))
    monkeypatch.setattr("drill_twin.api.cause.buckling", lambda *_: 1.0)
    assert "Cause: the weight buckles the string; at 0.5 of the weight (5 N): no whirl." in str(dt.why(run))


def search(run, **changes):
    return _Search(run.recording, run.summary | changes, lambda *_: None)


@pytest.mark.long
def test_repeats_with_a_stiff_drive_hold_the_speed_that_the_run_reached(monkeypatch):
    run = dt.Simulation("two_mass", {"duration": "30 s"}).run()
    repeats = search(run)
    late = run.rig.time >= run.summary["settled_s"]
    reached = float(run.rig.top_drive_speed[late].mean())
    assert 0.01 < reached / 100.0 < 0.1  # 23 of 955 rpm
    assert repeats.reached == pytest.approx(reached / 100.0, rel=0.01)
    speeds = {change.split(" (")[0]: speed for _, change, _, _, speed in repeats.plans()}
    assert speeds["with a top drive that holds its speed"] == repeats.reached
    assert speeds["at 0.7 of the speed"] == pytest.approx(0.7 * repeats.reached)
    assert speeds["without internal damping"] == 1.0
    shares = []

    def played(_, scene, weight, speed, more=0.0):
        shares.append(speed)
        return motion(onset=None, stick_slip=(0, 0.01))  # steady at each speed that is held, changed or not

    monkeypatch.setattr(Repeats, "played", played)
    trial = repeats.trial("without internal damping", repeats.scene, of_effects=True)
    assert shares == pytest.approx([1.0, *(2 * [0.98 * repeats.reached, 1.02 * repeats.reached])])
    assert not trial.cures  # the speed alone may have done it
    monkeypatch.setattr(Repeats, "trials", lambda _: iter([trial]))
    assert f"it turns at {repeats.units.text(reached, 'rotation')[:4]}" in str(dt.why(run))


def test_a_whirl_that_has_ended_is_named_by_what_it_was():
    run = dt.Simulation("pa6_bench", SOON).run(duration=3)
    spans = [(0.0, 1.0, "rotation about a fixed axis"), (1.0, 2.0, "synchronous whirl"), (2.0, 3.0, "at rest")]
    told = search(
        run, onset_s=1.0, whirl_end_s=2.0, onset_mark="mark_2", whirl_frequency_hz=0.92, whirl_ratio=0.98,
        lasting_motion="rotation about a fixed axis",
        motion=[{"start_s": start, "end_s": end, "state": state} for start, end, state in spans],
    ).what()  # fmt: skip
    assert told.startswith("Whirl from 1.00 s to 2.00 s at mark_2, with ")
    assert ": synchronous whirl at 0.92 Hz, 0.98 of the rotation; at the end rotation about a fixed axis, at " in told


def test_a_growth_matters_within_the_longest_repeat_only():
    repeats = search(dt.Simulation("pa6_bench", SOON).run(duration=3))
    assert repeats.horizon == pytest.approx(33.0)
    assert [repeats.matters(growth) for growth in (2.6e-6, 0.02, 0.04, -1.0, None)] == [
        False,
        False,
        True,
        False,
        False,
    ]
    assert repeats.slow(2.6e-6) == ", too slowly to matter within 33 s"
    assert repeats.slow(0.04) == repeats.slow(-1.0) == ""


@pytest.mark.long
def test_internal_damping_above_the_critical_speed():
    cause = dt.why(dt.Simulation("pa6_bench", {**SOON, "rpm": 180}).run(duration=12))
    assert cause.causes == ("without internal damping",)
    trials = by_change(cause)
    assert trials["without internal damping"].growth_per_s < 0.0
    assert trials["without wall friction"].outcome.startswith("forward whirl")
    # A start on the axis only delays a growth: unbalance is no cause.
    assert not trials[UNBALANCE].cures
    assert "it comes later" in trials[UNBALANCE].outcome


def judged(name):
    """Causes of a case that are named, and those of them that are wrong."""
    case = CASES[name]
    cause = dt.why(case.run())
    return cause, [one for one in cause.causes if not one.startswith(case.causes)]


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_a_known_cause_is_found(name):
    cause, wrong = judged(name)
    assert cause.causes
    assert not wrong


@pytest.mark.long
def test_most_known_causes_are_found_and_no_other_is_named():
    found = {name: judged(name) for name in CASES}
    assert not {name: wrong for name, (_, wrong) in found.items() if wrong}
    assert sum(bool(cause.causes) for cause, _ in found.values()) >= 9


def motion(onset=1.0, lasting="rolling along the wall", bit="steady rotation", **graded):
    """Motion with a grade and a value by quantity."""
    rows = {key: {"grade": at, "value": value, "place": ""} for key, (at, value) in graded.items()}
    summary = {
        "onset_s": onset, "whirl_end_s": None, "lasting_motion": lasting, "bit": bit, "severity_by_quantity": rows,
        "units": "field", "whirl_frequency_hz": None,
    }  # fmt: skip
    return Motion(summary, DEFAULT)


ROLLS = motion(lateral_rms=(2, 25.0))


@pytest.mark.parametrize(
    ("found", "growth", "less", "cured"),
    [
        (motion(lasting="creeping along the wall", lateral_rms=(0, 0.3)), None, True, True),  # creeps at 0.03 g
        (motion(lasting="creeping along the wall", lateral_rms=(0, 0.3)), None, False, True),
        (motion(lateral_rms=(1, 18.0)), None, True, True),  # a grade less of the same motion: a cure, no cause
        (motion(lateral_rms=(1, 18.0)), None, False, False),
        (motion(lasting="creeping along the wall", lateral_rms=(2, 21.0)), None, True, False),
        (motion(onset=None, lasting="rotation about a fixed axis", lateral_rms=(0, 0.3)), -0.1, False, True),
        (motion(onset=None, lasting="rotation about a fixed axis", lateral_rms=(0, 0.3)), 0.1, True, False),  # later
        (motion(onset=None, lasting="rotation about a fixed axis", lateral_rms=(2, 20.0)), -0.1, False, False),
    ],
)  # fmt: skip
def test_a_cure_is_judged_by_severity_and_kind(found, growth, less, cured):
    assert is_cured(WHIRL, ROLLS, found, growth, less=less) is cured


def test_torsion_that_is_not_known_is_not_cured():
    run = motion(onset=None, stick_slip=(3, 1.1))
    assert is_cured(TORSION, run, motion(onset=None, stick_slip=(0, 0.1)), None, less=False)
    assert not is_cured(TORSION, run, motion(onset=None), None, less=False)
    assert not is_cured(TORSION, run, motion(onset=None, stick_slip=(2, 0.6)), None, less=True)
