# SPDX-License-Identifier: Apache-2.0
"""Hard scenes are followed, no deeper into the wall than its law explains; what goes wrong is told."""

import json
from dataclasses import replace

import day
import numpy as np
import pytest
from one_frame import frames_of
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.dynamics.twin.frame import EnergyBalance
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.monitor import RunTiming
from drill_twin.scene import added_scenes, load_scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence import stress
from drill_twin_evidence.stress import run as stress_run
from drill_twin_evidence.stress.bound import allowed_depth
from drill_twin_evidence.stress.run import RunStatistics, verdict_on

QUICK = (
    "weight_jumps", "wall_1e12", "start_at_rest", "start_in_contact", "start_on_the_opposite_wall", "restitution_0",
    "friction_2", "elements_5", "commands_jump",
)  # fmt: skip
"""Scenes of the same kernels that are done in a second."""
CASES = [case for case in stress.all_hard_cases() if not case.long]


def result_of(name):
    return stress.run_case(next(case for case in stress.all_hard_cases() if case.name == name))


def alone(frame):
    """A frame as those of a run, with its node rows."""
    u = np.column_stack((frame.positions, frame.tangents, frame.spin))
    v = np.column_stack((frame.velocities, 0.0 * frame.tangents, frame.spin_rate))
    return frames_of(frame)._replace(u=u[None], v=v[None])


def test_every_scene_says_why_it_is_hard():
    assert len(added_scenes("hard")) >= 30
    for name in added_scenes("hard"):
        scene = load_scene(name)
        assert f"hard/{scene.name}" == name
        assert scene.description != load_scene("pa6_bench").description


@pytest.mark.parametrize("case", [c for c in CASES if c.name.partition("[")[0] in QUICK], ids=lambda case: case.name)
def test_a_hard_scene_is_in_order(case):
    result = stress.run_case(case)
    assert result.ok, result.verdict
    assert result.reached == pytest.approx(case.seconds)


@pytest.mark.long
@pytest.mark.parametrize("case", [c for c in CASES if c.name.partition("[")[0] not in QUICK], ids=lambda c: c.name)
def test_a_slower_hard_scene_is_in_order(case):
    result = stress.run_case(case)
    assert result.ok, result.verdict


def test_a_case_that_fails_is_reported_and_stops_no_other(monkeypatch):
    """One scene is not there, another cannot be followed."""
    cases = [case for case in CASES if case.name in {"elements_5[spatial]", "elements_5[lateral]"}]
    gone = replace(cases[0], scene_name="hard/not_there")
    late = replace(cases[1], scene_name="hard/late")
    scenes = {late: load_scene("hard/elements_5", overrides={"wob": "20 kN", "duration": "1 s"})}
    scene_of = stress.HardCase.scene
    monkeypatch.setattr(stress.HardCase, "scene", lambda case, **given: scenes.get(case) or scene_of(case, **given))
    monkeypatch.setattr(
        stress_run, "run_jobs", lambda function, jobs, *_, **__: {k: function(*j) for k, j in jobs.items()}
    )
    missing, stopped, result = stress.run_hard([gone, late, cases[0]], workers=1)
    assert "not_there" in missing.verdict
    assert "could not be followed" in stopped.verdict
    assert not missing.ok
    assert not stopped.ok
    assert 0.0 < stopped.reached < 1.0
    assert result.ok


@pytest.mark.long
@pytest.mark.parametrize("name", ["near_critical[spatial]", "near_critical[lateral]", "steady_hour[lateral]"])
def test_a_long_run_is_in_order(name):
    result = result_of(name)
    assert result.ok, result.verdict
    assert result.interventions == 0


def test_a_day_broken_off_and_continued_is_the_same_day(tmp_path, monkeypatch):
    """Three hours of four seconds; the end of the third is lost, after its line was written."""
    expected = day.run(tmp_path / "whole", 3, 4.0)
    assert [hour.verdict for hour in expected] == ["ok"] * 3
    with monkeypatch.context() as patch:
        patch.setattr(day.Checkpoint, "save", once_or_twice(day.Checkpoint.save))
        with pytest.raises(KeyboardInterrupt):
            day.run(tmp_path / "part", 3, 4.0)
    assert day.table(day.run(tmp_path / "part", 3, 4.0)) == day.table(expected)
    assert (tmp_path / "part" / "day.jsonl").read_bytes() == (tmp_path / "whole" / "day.jsonl").read_bytes()


def once_or_twice(save):
    """The method, which is broken off at its third call."""
    calls = []

    def replaced(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise KeyboardInterrupt
        save(*arguments)

    return replaced


def test_steps_taken_loosely_are_counted_and_told():
    """300 N press the string on the wall, where places flicker between stick and slip."""
    scene = load_scene("hard/load_300_n")
    twin, schedule, cost = Twin(scene), Schedule.from_scene(scene), RunTiming()
    frames = [twin.advance(schedule.at(0.01 * (k + 1)), 0.01) for k in range(200)]
    for frame in frames:
        cost.update(0.01, 0.0, frame.stats)
    loose = sum(frame.stats.steps_above_tolerance for frame in frames)
    assert 0 < loose < 0.1 * sum(frame.stats.steps for frame in frames)
    assert cost.values()["steps_above_tolerance"] == str(loose)


def test_what_is_wrong_is_told(make_frame):
    case = next(case for case in CASES if case.name == "load_300_n[spatial]")
    folds = next(case for case in CASES if case.name == "folds[spatial]")
    found = RunStatistics()
    found.add(alone(make_frame()))
    assert verdict_on(case, found, "", 0.0) == "ok"
    found.depth = 2e-3
    assert "2 mm into the wall" in verdict_on(case, found, "", 1e-3)
    assert verdict_on(case, found, "no step", 1.0) == "stopped: no step"
    assert verdict_on(folds, found, "at node 3 folded back on itself", 1.0).startswith("ok, stopped")
    assert verdict_on(folds, found, "no step", 1.0) == "stopped: no step"
    assert "run to its end" in verdict_on(folds, found, "", 1.0)
    broken = make_frame()
    broken.velocities[3, 1] = np.nan
    found.add(alone(broken))
    assert verdict_on(case, found, "", 1.0) == "the state is not finite"


def test_heat_cannot_come_back(make_frame):
    case, found = next(case for case in CASES if case.name == "load_300_n[spatial]"), RunStatistics()
    for heat in (0.5, -0.1):
        books = EnergyBalance({}, {}, {"drag": heat}, residual=-2e-3, scale=1.0, newton=0.0)
        found.add(alone(make_frame()._replace(energy=books)))
        assert verdict_on(case, found, "", 1.0) == (
            "ok" if heat > 0.0 else "drag added energy to the string, expected only dissipation"
        )
    assert found.energy == pytest.approx(2e-3)
    lost = EnergyBalance({}, {}, {}, residual=0.3, scale=1.0, newton=0.0)
    (found := RunStatistics()).add(alone(make_frame()._replace(energy=lost)))
    assert verdict_on(case, found, "", 1.0) == "30% of the energy in motion is an error of the energy balance"


@pytest.mark.long
def test_the_energy_of_a_hard_scene_is_accounted_for():
    case = next(case for case in CASES if case.name == "restitution_1[lateral]")
    assert stress.run_case(case).energy is None
    result = stress.run_case(case, energy=True)
    assert result.ok, result.verdict
    assert 0.0 < result.energy < 0.05


def test_the_depth_allowed_is_that_of_an_impact():
    """Without load and weight, the Hertz depth (5 m v^2 / 4 K)^(2/5)."""
    scene = load_scene("hard/load_300_n", overrides={"wob": "0", "effects.gravity": "off"})
    twin = Twin(scene)
    mass = scene.string.sections[0].mass_per_length
    assert allowed_depth(twin, 2.0) == pytest.approx((5.0 * mass * 4.0 / 4e7) ** 0.4, rel=1e-6)


def test_the_command_tells_and_ends_with_one_where_a_case_is_not_in_order(tmp_path, monkeypatch):
    page = tmp_path / "hard.md"
    said = CliRunner().invoke(app, ["study", "hard", "--only", "start_at_rest[spatial]", "--json", "--page", str(page)])
    assert said.exit_code == 0, said.output
    found = json.loads(page.with_suffix(".json").read_text("utf-8"))
    assert [case["name"] for case in found["cases"]] == ["start_at_rest[spatial]"]
    assert "| start_at_rest | spatial |" in page.read_text("utf-8")
    good = result_of("start_at_rest[spatial]")
    bad = type(good)(**{**good.__dict__, "verdict": "stopped: here"})
    monkeypatch.setattr(stress, "run_hard", lambda *_, **__: [bad])
    said = CliRunner().invoke(app, ["study", "hard", "--only", "start_at_rest[spatial]"])
    assert said.exit_code == 1
    assert "stopped: here" in said.output
    assert CliRunner().invoke(app, ["study", "hard", "--only", "no such"]).exit_code != 0
