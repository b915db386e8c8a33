# SPDX-License-Identifier: Apache-2.0
"""The estimator on a twin with hidden numbers; numbers that change in the middle of a run."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin_studies.estimation.doubts import Jumps, told_of_jumps
from drill_twin_studies.estimation.innovations import widening, widening_of_numbers
from drill_twin_studies.goodness import Goodness

OVER = {"wob": 55e3, "numerics.step": "20 ms", "numerics.frame_rate": 10.0}
HIDDEN = {"bit_torque_stribeck.sticking": 0.71, "internal_damping.torsion_time": 0.15}
FREE = {
    "bit_torque_stribeck.sticking": "0.55..0.95",
    "internal_damping.torsion_time": "50 ms..400 ms",
    "load_factor": "0.9..1.1",
}
FEW = dt.EstimatorOptions(members=16, horizon=0.0, window=2.0)


def hidden(seconds, load=55e3, **changes):
    """Channels of the hidden twin, with noise; set-points 4 % below the load that it has."""
    numbers = {key: [value] for key, value in (HIDDEN | changes).items()}
    found = dt.Ensemble("two_mass", numbers, overrides=OVER | {"wob": load}).run(
        seconds, outputs=("channels",), mark_rate=10.0
    )
    draw = np.random.default_rng(1)
    return {
        name: found[name][0] * (1.0 + 0.005 * draw.standard_normal(found["time"].size))
        for name in ("torque", "hookload", "bit_speed")
    } | {"time": found["time"]}


def feed(estimator, record, shift=0.0):
    estimates = []
    for row, time in enumerate(record["time"]):
        values = {name: record[name][row] for name in ("torque", "hookload")}
        estimator.take(shift + time, values | {"weight_on_bit": 53e3, "rotation": 100.0})
        while (found := estimator.step()) is not None:
            estimates.append(found)
    return estimates


@pytest.fixture(scope="module")
def record():
    return hidden(41.0)


@pytest.fixture(scope="module")
def followed(record):
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=FEW)
    return feed(estimator, record, shift=1e9)


def test_hidden_numbers_and_the_unmeasured_bit_are_found(record, followed):
    last = followed[-1]
    wanted = HIDDEN | {"load_factor": 55.0 / 53.0}
    for key, value in wanted.items():
        assert last.numbers[key].mean == pytest.approx(value, rel=0.1), key
        assert last.numbers[key].low < value < last.numbers[key].high, key
    assert last.sensors["weight_on_bit"].mean == pytest.approx(55e3, rel=0.01)
    places = [round(each.time * 10.0) - 1 for each in followed]
    error = [
        each.sensors["bit_speed"].mean - record["bit_speed"][place]
        for each, place in zip(followed, places, strict=True)
    ]
    assert np.sqrt(np.mean(np.square(error[5:]))) < 0.2 * record["bit_speed"].std()
    assert last.alarm == ""


def test_a_number_that_the_record_does_not_tell_keeps_its_prior_and_is_named(record):
    free = FREE | {"internal_damping.bending_time": "5 ms..20 ms"}  # nothing bends
    part = {name: values[:130] for name, values in record.items()}
    last = feed(dt.Estimator("two_mass", free, overrides=OVER, options=FEW), part)[-1]
    assert "internal_damping.bending_time" in last.untold
    assert "load_factor" not in last.untold
    band = last.numbers["internal_damping.bending_time"]
    assert band.mean == pytest.approx(12.5e-3, rel=0.1)
    assert band.low < 6.2e-3
    assert band.high > 18.8e-3
    assert last.untold["internal_damping.bending_time"] > 0.85


def test_samples_that_err_alike_widen_the_bands_of_numbers():
    alike = Goodness(100, 2.0, 1.0, 0.8, 10.0, 0.5, 0.95, np.nan)
    assert widening({"torque": alike}) == 1.0
    assert widening_of_numbers({"torque": alike}) == pytest.approx(np.sqrt(5.0))
    assert widening_of_numbers({"torque": replace(alike, independent=100.0)}) == 1.0
    assert widening_of_numbers({"torque": replace(alike, samples=0)}) == 1.0


def test_bad_samples_are_survived_and_told(record):
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=FEW)
    bad = {name: values.copy() for name, values in record.items()}
    bad["torque"][[105, 122]] = [1e12, np.nan]
    bad["time"][200:] += 3600.0  # the clock is set
    bad["hookload"][300:310] = np.inf
    found = feed(estimator, bad)[-1]
    assert estimator.intake.troubles["absurd"] >= 1
    assert estimator.intake.troubles["clock jump"] == 1
    assert found.numbers["load_factor"].mean == pytest.approx(55.0 / 53.0, rel=0.01)
    assert found.alarm == ""


def test_alarm_when_the_rig_does_what_the_model_cannot(record):
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=FEW)
    other = {name: values.copy() for name, values in record.items()}
    other["hookload"][300:] *= 0.5  # half of the load has gone elsewhere
    found = feed(estimator, other)
    assert not any(each.alarm for each in found[:15])
    assert any("the model does not explain hookload since 30.0 s" in each.alarm for each in found)
    assert all(np.isnan(each.sensors["bit_speed"].low) == bool(each.unexplained) for each in found)
    assert sum(span.windows for span in found[-1].spans) == sum(bool(each.alarm) for each in found)
    assert found[-1].remembered.startswith("an alarm stood from 3")


def test_numbers_changed_at_the_start_are_those_of_another_twin():
    first, other = (
        dt.load_scene("two_mass", OVER | {f"effects.{key}": value for key, value in HIDDEN.items()}) for _ in "ab"
    )
    plain = Twin(dt.load_scene("two_mass", OVER))
    plain.change_numbers(first)
    wanted = Twin(other)
    commands = np.tile([53e3, 100.0, 0.0], (50, 1))
    rows = [twin.record(50, nodes=False) for twin in (plain, wanted)]
    for twin, row in zip((plain, wanted), rows, strict=True):
        twin.advance_frames(commands, 0.1, row)
    np.testing.assert_array_equal(rows[0].frames.rig, rows[1].frames.rig)
    plain.change_numbers(dt.load_scene("two_mass", OVER))  # and back, in the middle of the run
    plain.advance_frames(commands, 0.1, rows[0])
    wanted.advance_frames(commands, 0.1, rows[1])
    assert not np.array_equal(rows[0].frames.rig, rows[1].frames.rig)


def test_members_of_overlapping_ranges_have_numbers_that_fit_together(record):
    """The scene takes no sticking torque below the sliding torque; its own are 0.8 and 0.5."""
    free = {"bit_torque_stribeck.sticking": "0.45..0.95", "bit_torque_stribeck.sliding": "0.3..0.9"}
    estimator = dt.Estimator("two_mass", free, overrides=OVER, options=FEW)
    members = estimator.filter.members
    assert estimator.filter.members.ranges["bit_torque_stribeck.sliding"] == (0.3, 0.9)
    assert np.all(members.values[:, 0] >= members.values[:, 1])
    far = np.tile([[-1.5, 1.5], [1.5, -1.5]], (8, 1))
    members.set_numbers(far)
    assert np.all(members.values[:, 0] >= members.values[:, 1])
    np.testing.assert_array_equal(members.normal[1::2], far[1::2])
    found = feed(estimator, {name: values[:200] for name, values in record.items()})[-1]
    low = found.numbers["bit_torque_stribeck.sliding"]
    assert low.low < low.mean < low.high < 0.9
    never = {"bit_torque_stribeck.sticking": "0.2..0.3", "bit_torque_stribeck.sliding": "0.5..0.9"}
    with pytest.raises(SceneError, match="expected `sticking` not below `sliding`"):
        dt.Estimator("two_mass", never, overrides=OVER)


@pytest.mark.parametrize(
    ("free", "words"),
    [
        ({"hole.radius": "0.1..0.2"}, "shapes the mesh"),
        ({"load_factor": "1.2..0.8"}, "a range of a factor"),
        ({"load_factor": 3}, "a range of a factor"),
        ({}, "at least one number"),
        ({"load_facto": "0.8..1.2"}, 'did you mean "load_factor"\\?$'),
        ({"bit_torque_stribek.stiking": "0.5..0.9"}, 'did you mean "bit_torque_stribeck.sticking"'),
        ({"xyz": "0.5..0.9"}, "expected load_factor, or a number of an effect"),
        ("load_factor=0.8..1.2", "ranges by key"),
    ],
)
def test_what_cannot_be_followed_is_refused_in_a_line(free, words):
    with pytest.raises(ArgumentError, match=words):
        dt.Estimator("two_mass", free, overrides=OVER)


@pytest.mark.parametrize(
    ("channels", "words"),
    [
        ("torque", "a list of channels"), (["torque", "torque"], "each once, .* found torque"), ([], "found 0"),
        (["hook_load"], 'found hook_load, did you mean "hookload"'),
    ],
)  # fmt: skip
def test_channels_that_cannot_be_are_refused(channels, words):
    with pytest.raises(ArgumentError, match=words):
        dt.Estimator("two_mass", FREE, channels=channels, overrides=OVER)


@pytest.mark.parametrize(
    ("option", "words"),
    [({"members": 0}, "whole number of 4"), ({"members": 4.5}, "found 4.5"), ({"rate": -1.0}, "rate: expected"),
     ({"horizon": "4 s"}, "horizon: expected a number of 0")],
)  # fmt: skip
def test_options_that_cannot_be_are_refused(option, words):
    with pytest.raises(ArgumentError, match=words):
        dt.EstimatorOptions(**option)


def test_samples_that_cannot_be_are_refused():
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=dt.EstimatorOptions(members=4))
    with pytest.raises(ArgumentError, match="found torqe"):
        estimator.take(0.0, {"torqe": 1.0})
    for sample in [("a",), (0.0, {"torque": "1 kN m"}), (0.0, 3.0), (None, {})]:
        with pytest.raises(ArgumentError, match="expected a time"):
            estimator.take(*sample)


def test_numbers_of_the_channel_that_jumps_may_explain_it_and_the_others_are_held():
    draw, jumps = np.random.default_rng(2), Jumps(["torque", "hookload"], ["friction", "load"])
    numbers = draw.standard_normal((32, 2))
    found = []
    for window in range(40):
        load = numbers[:, 1, None] + 0.1 * draw.standard_normal((32, 10))
        predicted = np.stack((numbers[:, :1] * np.sin(np.arange(10.0)), load), axis=1)
        normalised = np.array([np.nan, 6.0 if 20 <= window < 30 else 0.8])
        found.append(jumps.take(predicted, numbers, np.ones(2), normalised).tolist())
        if any(found[-1]):
            jumps.explain(20.0, np.array(found[-1]))
            assert np.array_equal(jumps.free, [False, True])
    assert [k for k, told in enumerate(found) if any(told)] == [21]
    assert found[21] == [False, True]
    assert told_of_jumps({"load": 20.0}) == "looked for anew after a jump: load since 20.0 s"
    jumps.explain(50.0, None)
    assert not np.any(jumps.free)
    assert "50.0 s that none of the numbers explains" in told_of_jumps(jumps.since)
    jumps.explain(60.0, np.zeros(2, dtype=bool))  # the motion was lost
    assert jumps.free is True
    assert told_of_jumps(jumps.since) == ""


def test_command_follows_a_record(record, tmp_path):
    shown = np.full(record["time"].size, 53.0)  # weight on bit as the rig indicates it; the scene has another
    rows = [record["time"] - 0.05, record["torque"] / 1e3, record["hookload"] / 1e3, shown, 100.0 + 0.0 * shown]
    heading = "time_s,torque [kN m],hookload [kN],WOB [kN],speed [rad/s]"
    np.savetxt(tmp_path / "rig.csv", np.column_stack(rows), delimiter=",", header=heading, comments="")
    lines = (tmp_path / "rig.csv").read_text("utf-8").splitlines()
    for row, column, null in ((40, 1, "-999.25"), (41, 1, "#N/A"), (50, 2, "-5555"), (60, 1, "-17000")):
        cells = lines[row].split(",")
        cells[column] = null
        lines[row] = ",".join(cells)
    (tmp_path / "rig.csv").write_text("\n".join(lines), "utf-8")
    options = [f"--free={key}={span}" for key, span in FREE.items()]
    options += [
        "--channel=null_value=-5555",
        "--channel=block_weight=1 N",
        "--set=wob=40 kN",
        "--set=numerics.step=20 ms",
        "--set=numerics.frame_rate=10 Hz",
    ]
    options += ["--channel=torque=torque [kN m]", "--channel=hookload=hookload [kN]", "--members=16", "--window=2"]
    options += ["--channel=weight_on_bit", "--channel=rotation=speed [rad/s]"]
    options.append(f"--out={tmp_path / 'out'}")
    done = CliRunner().invoke(
        app, ["estimate", str(tmp_path / "rig.csv"), "--scene=two_mass", *options, "--horizon=0", "--json"]
    )
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["numbers"]["load_factor"]["mean"] == pytest.approx(55.0 / 53.0, rel=0.01)
    assert [said.partition(":")[0] for said in found["of_law"]] == ["bit_torque_stribeck.sticking"]
    assert found["whirls"] == 0.0
    assert found["notes"] == [
        (
            "torque [kN m]: left out 1 without a number (row 41), 1 of -999.25 (row 40), 1 beyond any torque of the "
            "top drive on the string (row 60)"
        ),
        "hookload [kN]: left out 1 of -5555 (row 50)",
    ]
    assert (found["alarm"], found["remembered"], found["spans"]) == ("", "", [])
    written = json.loads((tmp_path / "out" / "estimate.json").read_text("utf-8"))["estimates"]
    assert [one["time"] for one in written] == pytest.approx(2.0 * np.arange(1, len(written) + 1), abs=0.1)
    assert written[-1]["numbers"] == found["numbers"]
    assert {"torque", "hookload"} <= written[-1]["misfit"].keys()
    assert (tmp_path / "out" / "estimate.png").stat().st_size > 20_000
    alone = CliRunner().invoke(app, ["estimate", "rig.csv", "--scene=two_mass", options[0], "--channel=rotation"])
    assert "expected a measured channel, torque, " in str(alone.exception)
    assert "found rotation alone; set-points are only played" in str(alone.exception)
    twice = CliRunner().invoke(app, ["estimate", str(tmp_path / "rig.csv"), "--scene=two_mass", *options, options[0]])
    assert "expected each key once" in str(twice.exception)
