# SPDX-License-Identifier: Apache-2.0
"""The study of what accuracy costs in time."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.scene import load_scene
from drill_twin.studies.accuracy.convergence import (
    JOINED,
    LATERAL,
    SPATIAL,
    Resolution,
    choose_resolutions,
    converged,
    forms,
    on_meshes,
)
from drill_twin.studies.accuracy.errors import compare, path_error, spread
from drill_twin.studies.accuracy.motion_run import Motion

SWING = {
    "effects.stretch": "off", "effects.torsion": "off", "effects.gravity": "off", "effects.eccentricity": "off",
    "effects.wall": "off", "effects.wall_friction": "off", "effects.bow": "off", "effects.internal_damping": "off",
    "effects.bit_friction": "off", "effects.lateral_kick.velocity": "0.1 m/s", "effects.lateral_kick.shape": "hump",
    "rig.weight_on_bit.value": "1 N",
}  # fmt: skip
"""A string that swings free: the same compiled effects as in the study of effects."""


def motion(**changes) -> Motion:
    time = np.linspace(0.01, 10.0, 1000)
    centre = np.stack([np.cos(time), np.sin(time)], -1)[:, None, :] * 0.05
    whole = Motion(
        time=time, centre=centre, contact=np.zeros(1000), hookload=np.full(1000, 2e5), torque=np.zeros(1000),
        clearance=np.array([0.08]), onset=5.0, frequency=1.0, stick_slip_period=3.0,
        cost=0.01, frame_p95=1e-4, iterations=np.ones(1000), compile_seconds=1.0,
        elements=16, step=1e-3, tolerance=1e-5,
    )  # fmt: skip
    return replace(whole, **changes)


def test_the_path_counts_before_the_onset_only():
    reference = motion()
    off = reference.centre.copy()
    off[reference.time > 5.0] += 1.0
    assert path_error(motion(centre=off), reference) == 0.0
    off[100] += 0.001
    assert path_error(motion(centre=off), reference) == pytest.approx(0.001 * np.sqrt(2.0) / 0.05)
    assert path_error(motion(centre=off), motion(onset=np.nan)) == pytest.approx(np.sqrt(2.0) / 0.05)


def test_errors_are_relative_and_a_missing_onset_is_a_whole_one():
    errors = compare(motion(onset=5.1, frequency=0.9), motion())
    assert errors.onset == pytest.approx(0.02)
    assert errors.frequency == pytest.approx(0.1)
    assert errors.controlled == pytest.approx(0.02)
    assert compare(motion(onset=np.nan), motion()).onset == 1.0
    assert compare(motion(onset=np.nan), motion(onset=np.nan)).onset is None
    assert spread([motion(onset=5.1), motion(onset=4.9)], motion()).onset == pytest.approx(0.02)


def test_a_motion_is_kept_as_it_was(tmp_path):
    motion(onset=np.nan).save(tmp_path / "one.npz")
    again = Motion.load(tmp_path / "one.npz")
    assert np.isnan(again.onset)
    assert again.elements == 16
    np.testing.assert_array_equal(again.centre, motion().centre)


def test_a_scene_that_needs_torsion_has_no_lateral_resolution():
    assert forms(load_scene("pa6_bench")) == [SPATIAL, LATERAL]
    assert forms(load_scene("two_mass")) == [SPATIAL]
    assert forms(load_scene("pa6_bench", overrides=SWING)) == [LATERAL]
    resolutions = choose_resolutions(load_scene("pa6_bench", overrides=SWING))
    assert all(resolution.form == LATERAL and resolution.step <= 0.01 for resolution in resolutions)
    exact = converged(resolutions)
    assert exact.elements > max(resolution.elements for resolution in resolutions)
    assert exact.step < min(resolution.step for resolution in resolutions)
    assert Resolution(LATERAL, 8, 1e-3).overrides()["effects.torsion"] == "off"


def test_lateral_motion_from_a_depth_down_is_priced_by_a_run_of_the_whole_string():
    well = load_scene("wells/s_shaped")
    assert forms(well) == [JOINED]
    own, whole = on_meshes(well, [134])
    assert own == Resolution(JOINED, 134, whole.step)
    assert whole.form == SPATIAL
    assert whole.elements > 2 * own.elements
    assert whole.overrides()["numerics.lateral_from"] == "0 m"
    assert "numerics.lateral_from" not in own.overrides()
    assert converged([own, whole]) == Resolution(JOINED, 268, 0.5 * own.step)
    assert on_meshes(load_scene("wells/s_shaped", overrides={"numerics.lateral_from": "0 m"}), [134]) == [
        Resolution(SPATIAL, 134, whole.step)
    ]


@pytest.mark.long
def test_the_table_of_meshes_ends_with_the_whole_string(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    made = CliRunner().invoke(
        app, ["cost", "wells/s_shaped", "--duration", "2 s", "--repeats", "0", "--elements", "120", "--out", "made"]
    )
    assert made.exit_code == 0, made.output
    rows = [line.split() for line in made.stdout.splitlines() if "e-" in line or "whole" in line.split()]
    assert [row[0] for row in rows][-2:] == ["120", "323"]
    runs = {one["resolution"]["form"]: one for one in json.loads((tmp_path / "made/cost.json").read_text())["runs"]}
    assert runs[JOINED]["on_front"]
    assert not runs[SPATIAL]["on_front"]
    assert runs[SPATIAL]["cost"] > runs[JOINED]["cost"]


@pytest.mark.long
def test_the_command_measures_resumes_and_finds_the_order_of_the_scheme(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = [word for key, value in SWING.items() for word in ("--set", f"{key}={value}")]
    command = ["cost", "pa6_bench", *words, "--duration=1 s", "--coarse", "--repeats=1", "--out=made", "--json"]
    made = CliRunner().invoke(app, command)
    assert made.exit_code == 0, made.output
    found = json.loads(made.stdout)
    folder = tmp_path / "made"
    assert json.loads((folder / "cost.json").read_text("utf-8")) == found
    assert (folder / "cost.png").stat().st_size > 10_000
    rows = list(csv.DictReader((folder / "cost.csv").read_text("utf-8").splitlines()))
    assert len(rows) == len(found["runs"]) > 3
    assert found["failures"] == []
    finest = max(resolution["resolution"]["elements"] for resolution in found["runs"])
    by_step = {
        one["resolution"]["step"]: one["errors"]["path"]
        for one in found["runs"]
        if one["resolution"]["elements"] == finest
    }
    steps = sorted(by_step)
    order = np.log(by_step[steps[-1]] / by_step[steps[0]]) / np.log(steps[-1] / steps[0])
    assert 1.7 < order < 2.5  # against a run of half the step
    assert any(one["on_front"] for one in found["runs"])
    kept = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    cut_short = min(kept)
    cut_short.write_bytes(cut_short.read_bytes()[:30])  # as by a power cut: it is made again
    again = CliRunner().invoke(app, command)
    assert again.exit_code == 0, again.output
    assert cut_short.stat().st_size > 1000
    changed = {path for path in (folder / "runs").iterdir() if kept.get(path) != path.stat().st_mtime_ns}
    assert changed == {cut_short}
    errors = [[one["errors"] for one in result["runs"]] for result in (found, json.loads(again.stdout))]
    assert sorted(map(str, errors[0])) == sorted(map(str, errors[1]))


@pytest.mark.long
def test_given_meshes_are_compared_at_the_rig_too(tmp_path, monkeypatch):
    """Of a string that turns free: its weight on bit and nothing else at the top, no onset and no stick-slip."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    words = [word for key, value in SWING.items() for word in ("--set", f"{key}={value}")]
    command = ["cost", "pa6_bench", *words, "--duration", "0.5 s", "--repeats", "0", "--elements"]
    made = CliRunner().invoke(app, [*command, "8,12"])
    assert made.exit_code == 0, made.output
    assert "against 24 elements and" in made.stdout
    assert [line.split()[0] for line in made.stdout.splitlines()[-4:] if line.strip()][-3:] == ["8", "12", "spread"]
    found = CliRunner().invoke(app, [*command, "8,twelve"])
    assert str(found.exception) == '--elements: expected numbers such as "125,250,500", found "8,twelve"'


def test_a_scene_without_marks_is_refused_before_anything_is_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = CliRunner().invoke(app, ["cost", "pa6_bench", "--set", "string.marks=[]"])
    assert "pa6_bench: expected marks in `string.marks`, whose paths are compared, found none" in str(found.exception)
    assert not list(tmp_path.iterdir())


def test_hookload_torque_and_stick_slip_are_compared_as_means_of_the_second_half():
    early = np.linspace(0.01, 10.0, 1000) < 5.0
    reference = motion(torque=np.full(1000, 4.0))
    errors = compare(motion(hookload=np.where(early, 0.0, 1.98e5), torque=np.full(1000, 4.4)), reference)
    assert errors.hookload == pytest.approx(0.01)
    assert errors.torque == pytest.approx(0.1)
    assert compare(motion(stick_slip_period=3.3), motion()).stick_slip == pytest.approx(0.1)
    assert compare(motion(stick_slip_period=np.nan), motion()).stick_slip == 1.0
    assert compare(motion(), motion()).torque is None, "no torque to compare with"
