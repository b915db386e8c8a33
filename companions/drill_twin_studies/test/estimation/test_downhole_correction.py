# SPDX-License-Identifier: Apache-2.0
"""A downhole sub corrects the estimator: a hidden whirl is followed in phase, from Python and from a bag."""

import json
from collections import Counter

import numpy as np
import pytest
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin_studies.estimation.estimate import WindowTiming
from drill_twin_studies.estimation.members import EstimatorMembers
from drill_twin_studies.estimation.phase import turns
from drill_twin_studies.estimation.square_root_filter import correction
from drill_twin_studies.estimation.subs import VALUES, LateralMotion, SubIntake, lateral_velocity, replace_outliers

SUB = (
    "{name: near_bit, distance_from_bit: 1 m, radius: 6 mm, rate: 50 Hz, accelerometer: {noise: 5 mm/s^2, "
    "bias: 0.05 m/s^2}, gyroscope: {noise: 0.06 deg/s, bias: 0.3 deg/s}}"
)
OVER = {
    "numerics.elements": 8,
    "numerics.step": "10 ms",
    "numerics.frame_rate": "50 Hz",
    "rig.rotation.duration": "1 s",
    "rig.weight_on_bit.duration": "2 s",
    "string.marks.mark_1.on": "centre",
    "sensors.subs": f"[{SUB}]",
}
"""Kernel of the paper's rod."""
HIDDEN = {"effects.wall_friction.coefficient": 0.15, "numerics.seed": 5}
FREE = {"wall_friction.coefficient": "0.1..0.4", "load_factor": "0.9..1.1"}
FEW = dt.EstimatorOptions(members=16, horizon=0.0)
SECONDS = 14


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hidden") / "bag"
    changes = [f"--set={key}={value}" for key, value in {**OVER, **HIDDEN}.items()]
    done = CliRunner().invoke(app, ["run", "pa6_bench", *changes, f"--duration={SECONDS}", f"--out={folder}"])
    assert done.exit_code == 0, done.output
    return folder


def test_the_place_of_a_mark_far_from_the_sub_is_followed(bag):
    estimator = dt.Estimator("pa6_bench", FREE, subs=["near_bit"], overrides=OVER, options=FEW)
    record = dt.read_record(bag, ["torque", "hookload"], subs=["near_bit"])
    found = list(estimator.follow(record))
    marks = dt.read_bag(bag).marks
    rows = np.searchsorted(marks.time, [each.time - 1e-6 for each in found])
    truth = marks.position[rows, 0, 0] + 1j * marks.position[rows, 0, 1]
    means = np.array([each.sensors["mark_1/x"].mean + 1j * each.sensors["mark_1/y"].mean for each in found])
    late = slice(8, None)
    error, size = (np.sqrt(np.mean(np.abs(values[late]) ** 2)) for values in (means - truth, truth))
    assert size > 0.01  # it whirls
    assert error < size / 3.0
    assert not estimator.intake.troubles
    assert {"near_bit/speed"} < found[-1].misfit.keys()


@pytest.mark.slow
def test_command_takes_the_sub_of_a_bag(bag):
    options = ["--scene=pa6_bench", "--channel=torque", "--channel=hookload", "--horizon=0", "--members=4"]
    options += [f"--free={key}={span}" for key, span in FREE.items()] + [f"--set={k}={v}" for k, v in OVER.items()]
    done = CliRunner().invoke(app, ["estimate", str(bag), *options, "--sub=near_bit", "--json"])
    assert done.exit_code == 0, done.output
    assert "mark_1/x" in json.loads(done.stdout)["sensors"]
    for sub, words in (("near_bt", "that scene pa6_bench lists"), ("measured/near_bit", "found readings of near_bit")):
        refused = CliRunner().invoke(app, ["estimate", str(bag), *options, f"--sub={sub}"])
        assert words in str(refused.exception)


def test_a_file_has_no_subs(tmp_path):
    (tmp_path / "rig.csv").write_text("time_s,torque [N m]\n0,1\n1,2\n", encoding="utf-8")
    with pytest.raises(ArgumentError, match="expected a bag"):
        dt.read_record(tmp_path / "rig.csv", ["torque"], subs=["near_bit"])


@pytest.mark.parametrize(
    "reading", [(0.0, "far_bit", [0.0] * 6), (0.0, "near_bit", [0.0] * 5), ("a", "near_bit", [0.0] * 6)]
)
def test_readings_that_cannot_be_are_refused(reading):
    estimator = dt.Estimator(
        "pa6_bench", FREE, subs=["measured/near_bit"], overrides=OVER, options=dt.EstimatorOptions(members=4)
    )
    with pytest.raises(ArgumentError, match="a sub of measured/near_bit"):
        estimator.take_readings(*reading)


@pytest.fixture
def intake():
    scene, troubles = dt.load_scene("pa6_bench", OVER), Counter()
    return SubIntake(WindowTiming(0.02, 50, 10), scene.sensors.subs[0], troubles), troubles


def fill(intake, start=0.0, skip=(), change=1.0):
    for k in range(50):
        if k not in skip:
            time = start + 0.02 * k + 0.01
            intake.take(time, np.full(VALUES, change * time))


def test_bad_readings_are_told_and_survived(intake):
    sub, troubles = intake
    fill(sub, skip={20, 21})
    sub.take(0.41, [np.nan] * VALUES)
    sub.take(0.41, [1e12] * VALUES)
    sub.take(0.01, [3.0] * VALUES)
    found = sub.close(0.0)
    np.testing.assert_allclose(found[:, 5], 0.02 * np.arange(50) + 0.01, atol=1e-9)
    assert troubles == {"impossible reading": 2, "repeated reading": 1}
    fill(sub, start=1.0, skip=range(10, 20))
    assert np.isnan(sub.close(1.0)).all()
    fill(sub, start=2.0, change=0.0)
    assert np.isnan(sub.close(2.0)).all()
    assert troubles["window without readings"] == troubles["frozen readings"] == 1


def test_a_force_that_no_member_has_is_left_out():
    draw = np.random.default_rng(1)
    members, measured = draw.standard_normal((4, 50, 1, VALUES)), draw.standard_normal((1, 50, VALUES))
    odd = measured.copy()
    odd[0, 20, 1] = 500.0
    kept = replace_outliers(odd, members)
    np.testing.assert_array_equal(kept[0, 20], measured[0, 19])
    np.testing.assert_array_equal(np.delete(kept, 20, axis=1), np.delete(measured, 20, axis=1))
    np.testing.assert_array_equal(
        replace_outliers(100.0 * measured, members), 100.0 * measured
    )  # all of it: a motion, no error


def test_members_are_turned_to_the_measured_phase():
    time = 0.02 * (np.arange(50) + 0.5)
    force = np.exp(-9j * time)  # whirl in the frame of the sub
    rows = np.zeros((3, 50, VALUES))
    for row, turn in zip(rows, (1.0, 1j, np.exp(2.5j)), strict=True):
        row[:, 0], row[:, 1], row[:, 5] = (turn * force).real, (turn * force).imag, 12.0
    velocity = lateral_velocity(rows, 0.02, 10)[:, None]
    np.testing.assert_allclose(turns(velocity, velocity[0]), [1.0, -1j, np.exp(-2.5j)], atol=1e-12)
    np.testing.assert_array_equal(turns(velocity, np.full((1, 10), np.nan + 0j)), 1.0)


def test_another_lateral_motion_keeps_stretch_and_hole():
    scene = dt.load_scene("pa6_bench", OVER)
    twins = [Twin(scene) for _ in "ab"]
    commands = np.tile([40.0, 12.0, 0.0], (200, 1))
    for twin in twins:
        twin.advance_frames(commands, 0.02, twin.record(200, nodes=False))
    lateral = LateralMotion(scene, twins[0])

    def lengths(twin):
        u = twin.unknowns[0]
        ends = np.stack([u[:-1, 0:3], u[:-1, 3:6], u[1:, 0:3], u[1:, 3:6]], 1)
        slope = np.einsum("npk,nkx->npx", twin.rod.shape[:, :, 1], ends)
        return twin.rod.length * np.linalg.norm(slope, axis=-1).mean(axis=1)

    before = lengths(twins[0])
    motion = lateral.read(twins)
    assert np.abs(motion[0, 0, :, 0]).max() > 0.03
    changed = np.stack([0.8j * motion[0], 3.0 * motion[1]])
    lateral.write(twins, changed.copy())
    np.testing.assert_allclose(lengths(twins[0]), before, rtol=2e-5)
    np.testing.assert_array_equal(lateral.read(twins)[0], changed[0])
    assert np.abs(lateral.read(twins)[1, 0, :, 0]).max() == pytest.approx(scene.clearance_at(2.5))
    assert twins[0].unknowns[0][-1, 2] == pytest.approx(twins[1].unknowns[0][-1, 2])  # the top is held


def test_a_window_in_which_the_motion_is_lost_corrects_no_number():
    pace = WindowTiming(0.1, 10, 10)
    members = EstimatorMembers(dt.load_scene("two_mass"), {"load_factor": (0.9, 1.1)}, 8, pace, 1)
    before = members.normal.copy()
    predicted = before + 0.1 * np.arange(8.0)[:, None] / 8.0
    found = [correction(predicted, np.array([1.0]), np.array([1e-4]))]
    members.correct(found, [False])
    np.testing.assert_array_equal(members.normal, before)
    members.correct(found)
    assert members.normal.std() < 0.5 * before.std()
