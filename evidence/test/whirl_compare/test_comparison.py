"""Kinds of motion, and the comparison of states with simulations on a grid."""

import json
import math
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.shape_search import (
    SOFT_CREEP,
    ShapeSearch,
    damped,
    helix,
    set_creep,
    stiffen_friction,
)
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations, deflation
from drill_twin.dynamics.rotordynamics.steady.whirl_state import state_of
from drill_twin.dynamics.rotordynamics.steady.whirl_states import whirl_states
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.whirl_compare import comparison, points
from drill_twin_evidence.whirl_compare.motion import Motion, motion_of

TIMES = 0.02 * np.arange(1000)
FAST = Command(40.0, 6.5 * math.tau)


def turning(speed, radius=1.0):
    return radius * np.exp(1j * speed * TIMES)


@pytest.mark.parametrize(
    ("marks", "kind", "speeds"),
    [
        ([0.2 * turning(3.0), 0.1 * turning(-5.0)], "on the axis", (3.0,)),
        ([turning(3.0), 0.5 * turning(3.0)], "steady whirl", (3.0,)),
        ([turning(3.0) + turning(8.0, 0.1), 0.5 * turning(3.0)], "two frequencies", (3.0, 8.0)),
        ([turning(3.0), 0.8 * turning(0.4) + turning(3.0, 0.2)], "two frequencies", (3.0, 0.4)),
        ([turning(3.0), 0.8 * turning(0.4) + turning(4.7, 0.2)], "irregular", (3.0,)),
    ],
)
def test_a_motion_is_told_by_its_speeds(marks, kind, speeds):
    found = motion_of(np.stack(marks, axis=1), 0.02, 1.0)
    assert found.kind == kind
    assert found.speed == pytest.approx(speeds[0], abs=0.05 if kind == "irregular" else 0.01)
    if kind == "two frequencies":
        around = {round(abs(found.second - found.speed), 2), round(2 * found.speed - found.second, 2)}
        assert round(abs(speeds[1] - speeds[0]), 2) in around


@pytest.fixture(scope="module")
def slow(bench):
    """A creeping helix at 90 N and 1 rev/s, on its soft friction, and its equations."""
    equations = TurningEquations(EquationsOfMotion(bench))
    set_creep(equations, SOFT_CREEP)
    search = ShapeSearch(equations, Command(90.0, math.tau))
    return equations, equations.newton(damped(search, helix(search, -1.0)))


def test_a_helix_settles_into_a_slow_whirl(bench, slow):
    equations, soft = slow
    state = state_of(equations, stiffen_friction(equations, soft, 1e-4))
    set_creep(equations, SOFT_CREEP)
    assert state.is_stable
    assert 0.0 < state.ratio < 0.05
    angle = np.unwrap(np.angle(soft.u[:, 0] + 1j * soft.u[:, 1]))
    assert abs(angle[0] - angle[-2]) > math.pi


def test_a_deflated_search_does_not_come_back(slow):
    equations, known = slow
    near = known.__class__(known.command, known.u * 1.001, known.omega * 1.01)
    assert equations.newton(near).omega == pytest.approx(known.omega, rel=1e-6)
    other = equations.newton(near, partial(deflation, equations, [known]))
    assert other is None or abs(other.omega - known.omega) > 1e-3 * known.omega


def test_a_point_of_the_comparison_and_its_record(bench, tmp_path, monkeypatch):
    """One load and speed at which a stable whirl is reached; the second call reads it."""
    record, weights, speeds = tmp_path / "points.jsonl", [FAST.weight_on_bit], [FAST.rotation]
    (point,) = comparison.compare(bench, weights, speeds, duration=30.0, record=record, workers=1)
    assert point.motion == "steady whirl"
    assert point.verdict == "a stable state"
    assert min(abs(point.ratio / ratio - 1.0) for ratio in point.stable) < 2e-3
    monkeypatch.setattr(comparison, "Ensemble", None)
    assert comparison.compare(bench, weights, speeds, duration=30.0, record=record) == [point]
    with pytest.raises(ArgumentError, match="found results of another duration"):
        comparison.compare(bench, weights, speeds, duration=20.0, record=record)


def test_a_record_that_was_broken_off_goes_on(bench, tmp_path):
    """Lines that were cut off or damaged are computed again; another study, or another file, is refused."""
    record, setup = tmp_path / "points.jsonl", points.setup_of(bench, 30.0)
    one = points.Point(40.0, 6.0, "steady whirl", 0.8, None, 0.01, ((0.8, -1.0, 2.0),), (0.8,), "a stable state",
                       two=points.TwoFrequencies(0.8, 0.4, -1.0, 1e-9), held=((0.5, True),))  # fmt: skip
    file = points.points_file(record, setup)
    assert file.results == []
    file.add(one)
    whole = record.read_bytes()
    record.write_bytes(whole + b'{"motion": 1}\n' + whole.splitlines()[1][:40])
    assert points.points_file(record, setup).results == [one]
    with pytest.raises(ArgumentError, match="found results of another duration"):
        points.points_file(record, points.setup_of(bench, 20.0))
    record.write_bytes(b"[]\n")
    with pytest.raises(ArgumentError, match="expected results of `whirl comparison`, found another file"):
        points.points_file(record, setup)


def test_a_motion_that_is_no_state_found_is_missed(bench):
    """The verdicts, on a motion of another speed than that of the states."""
    equations = EquationsOfMotion(bench)
    states = whirl_states(equations, FAST, random_starts=0)
    stable = next(state for state in states if state.is_stable)
    radius = np.ones(comparison.places(equations).size)
    steady = Motion("steady whirl", stable.whirl.omega * 1.01, math.nan, 0.0, math.nan, radius)

    def verdict(motion):
        return comparison.judge(equations, states, 1.0, FAST, motion).verdict

    assert verdict(steady) == "a stable state"
    assert verdict(steady._replace(speed=stable.whirl.omega * 0.5)) == "no such state found"
    assert verdict(steady._replace(kind="irregular", change=0.7)) == "beside a stable state"
    assert comparison.judge(equations, (), 1.0, FAST, steady._replace(kind="irregular")).agrees


@pytest.mark.long
def test_the_comparison_on_the_command_line(tmp_path):
    """Two loads at 1 rev/s: a whirl at 0.79 of the rotation, and a creeping helix."""
    form = ["--set", "effects.stretch=off", "--set", "effects.torsion=off", "--set", "numerics.elements=16"]
    grid = ["--wob", "10..50:2 N", "--rpm", "60..60:1", "--record", str(tmp_path / "points.jsonl"), "--workers", "1"]
    said = CliRunner().invoke(app, ["study", "whirl-compare", "pa6_calibrated", *grid, *form, "--json"])
    assert said.exit_code == 0, said.output
    first, second = json.loads(said.stdout)
    assert first["ratio"] == pytest.approx(0.79, abs=0.01)
    assert second["ratio"] == pytest.approx(0.0098, abs=0.0003)
    assert first["verdict"] == second["verdict"] == "a stable state"
    wrong = CliRunner().invoke(app, ["study", "whirl-compare", "pa6_calibrated", "--wob", "10", "--rpm", "60..60:1"])
    assert wrong.exit_code != 0
