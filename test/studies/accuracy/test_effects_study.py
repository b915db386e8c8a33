# SPDX-License-Identifier: Apache-2.0
"""The study that finds which effects a scene calls for."""

import json

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.studies.accuracy.ablation import Change, groups
from drill_twin.studies.accuracy.errors import Trial, differences

SWING = {
    "effects.stretch": "off", "effects.torsion": "off", "effects.gravity": "off", "effects.eccentricity": "off",
    "effects.wall": "off", "effects.wall_friction": "off", "effects.bow": "off", "effects.internal_damping": "off",
    "effects.bit_friction": "off", "effects.drag.linear": "1e-9 N s/m^2", "effects.lateral_kick.velocity": "0.1 m/s",
    "numerics.elements": "8", "rig.weight_on_bit.value": "1 N",
}  # fmt: skip
"""A string that swings free: nothing happens without the kick, and nobody would miss the drag."""
LIVELY = {
    "effects.stretch": "off", "effects.torsion": "off", "effects.gravity": "off", "effects.eccentricity": "off",
    "effects.wall_friction": "off", "effects.bit_friction": "off", "effects.lateral_kick.velocity": "1e-9 m/s",
    "numerics.elements": "8", "rig.weight_on_bit.duration": "1 s",
}  # fmt: skip
"""Whirl that the bow seeds and the damping drives forward; the kick is too small to matter."""


def trial(**figures: float | None) -> Trial:
    return Trial(**({"onset_s": 5.0, "whirl_frequency_hz": 1.0, "mean_radius": 0.5, "contact_fraction": 0.2,
                     "cost": 0.01, "iteration_cost": 1e-6} | figures))  # fmt: skip


def test_what_needs_an_effect_goes_with_it():
    assert groups(("gravity", "wall", "wall_friction")) == [("gravity",), ("wall", "wall_friction"), ("wall_friction",)]
    assert groups(("stretch", "torsion", "bow")) == [("stretch", "torsion"), ("bow",)]


def test_a_difference_counts_beyond_tolerance_and_chance():
    steady = [trial(onset_s=5.0), trial(onset_s=5.0)]
    found = differences(steady, [trial(onset_s=5.2), trial(onset_s=5.2)], tolerance=0.05)
    assert not found["onset_s"].matters  # 4 % of it
    found = differences(steady, [trial(onset_s=5.4), trial(onset_s=5.4)], tolerance=0.05)
    assert found["onset_s"].matters
    assert found["onset_s"].tolerances == pytest.approx(1.6)
    found = differences([trial(onset_s=2.0), trial(onset_s=8.0)], [trial(onset_s=5.4)] * 2, tolerance=0.05)
    assert not found["onset_s"].matters  # 5.0 against 5.4, but give or take 3


@pytest.mark.parametrize(
    ("with_all", "without", "matters", "known"),
    [
        ([5.0] * 5, [None] * 5, True, True),
        ([5.0] * 5, [5.0, *[None] * 4], True, True),  # in 1 of 5 against 5 of 5: Fisher's p is 0.048
        ([5.0] * 5, [*[5.0] * 4, None], False, True),
        ([5.0] * 2, [None] * 2, False, False),  # two of two against none of two come about in every third case
        ([5.0, *[None] * 4], [9.0, *[None] * 4], False, False),  # one survivor each: their spread is not known
        ([5.0, 5.1, 4.9, 5.0, 5.0], [9.0], False, False),
    ],
)
def test_runs_without_whirl_are_counted(with_all, without, matters, known):
    found = differences([trial(onset_s=t) for t in with_all], [trial(onset_s=t) for t in without], tolerance=0.05)
    assert (found["onset_s"].matters, found["onset_s"].known) == (matters, known)


def test_an_effect_of_which_the_runs_do_not_tell_is_kept():
    few = differences([trial(onset_s=5.0)] * 2, [trial(onset_s=None)] * 2, tolerance=0.05)
    change = Change(("bow",), few)
    assert change.unknown
    assert not change.needed


def study(tmp_path, monkeypatch, changes: dict[str, str], duration: str, replicas: str = "2") -> dict:
    monkeypatch.chdir(tmp_path)
    words = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    asked = (f"--duration={duration}", f"--repeats={replicas}", "--out=made", "--json")
    command = ["effects", "pa6_bench", *words, *asked]
    made = CliRunner().invoke(app, command)
    assert made.exit_code == 0, made.output
    found = json.loads(made.stdout)
    assert json.loads((tmp_path / "made" / "effects.json").read_text("utf-8")) == found
    assert (tmp_path / "made" / "effects.png").stat().st_size > 10_000
    kept = {run: run.stat().st_mtime_ns for run in (tmp_path / "made" / "runs").iterdir()}
    assert len(kept) >= int(replicas) * (len(found["changes"]) + 1)
    again = CliRunner().invoke(app, command)
    assert again.stdout == made.stdout
    assert kept == {run: run.stat().st_mtime_ns for run in (tmp_path / "made" / "runs").iterdir()}  # nothing ran anew
    return found


@pytest.mark.long
def test_the_command_finds_what_a_scene_calls_for(tmp_path, monkeypatch):
    found = study(tmp_path, monkeypatch, SWING, "2 s")
    assert found["effects"] == ["drag", "lateral_kick"]
    assert found["kept"] == ["lateral_kick"]
    without_kick = next(change for change in found["changes"] if change["left_out"] == ["lateral_kick"])
    assert without_kick["quantities"]["mean_radius"]["matters"]
    assert found["reduced"]["quantities"]["mean_radius"]["tolerances"] < 1.0


@pytest.mark.long
def test_whirl_calls_for_its_wall_and_its_damping(tmp_path, monkeypatch):
    found = study(tmp_path, monkeypatch, LIVELY, "6 s", "4")
    assert {"internal_damping", "wall"} <= set(found["kept"])
    assert "lateral_kick" not in found["kept"]
    damping = next(change for change in found["changes"] if change["left_out"] == ["internal_damping"])
    onset = damping["quantities"]["onset_s"]
    assert onset["runs_before"] > onset["runs_after"] == 0
