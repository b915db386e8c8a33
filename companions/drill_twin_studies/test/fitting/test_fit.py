# SPDX-License-Identifier: Apache-2.0
"""Numbers of a scene found again from records that the twin made with hidden ones."""

import json

import numpy as np
import pytest
from scipy import stats
from scipy.io import savemat
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, SceneError, TableError
from drill_twin.io.bag.series import CommandSeries
from drill_twin.scene.records.channels import channel_column
from drill_twin.scene.set_points import Schedule

HIDDEN = {"bit_torque_stribeck.sticking": 0.71, "bit_torque_stribeck.decay": 1.3}
FREE = {"bit_torque_stribeck.sticking": "0.55..0.95", "bit_torque_stribeck.decay": "0.2 s/rad..6 s/rad"}
OVER = {"wob": 55e3, "numerics.step": "20 ms", "numerics.frame_rate": 10.0}


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """Bit speed of a hidden twin over 30 s, with noise."""
    return measured(HIDDEN, 1, tmp_path_factory.mktemp("record") / "rig.csv")


def measured(hidden, seed, path):
    """File of the bit speed of a twin with hidden numbers over 30 s, with noise."""
    found = dt.Ensemble("two_mass", {key: [value] for key, value in hidden.items()}, overrides=OVER).run(
        30.0, outputs=("channels",), mark_rate=10.0
    )
    noise = 0.05 * np.random.default_rng(seed).standard_normal(found["time"].size)
    rows = np.column_stack((found["time"], (found["bit_speed"][0] + noise) * 30.0 / np.pi))
    np.savetxt(path, rows, delimiter=",", header="time_s,bit speed [rpm]", comments="")
    return path


@pytest.mark.long
def test_hidden_numbers_of_drawn_twins_lie_in_their_intervals(tmp_path):
    """At the rate that is printed; 300 twins: `make fit-coverage`."""
    held = 0
    for seed in range(400, 403):
        draw = np.random.default_rng(seed)
        hidden = dict(zip(FREE, (draw.uniform(0.55, 0.95), draw.uniform(0.2, 6.0)), strict=True))
        path = measured(hidden, seed, tmp_path / f"{seed}.csv")
        found = dt.fit(
            path, "two_mass", FREE, channels=["bit_speed=bit speed [rpm]"], overrides=OVER, end=30.0, rate=10.0,
            members=32, seed=seed,
        )  # fmt: skip
        held += sum(low <= hidden[key] <= high for key, (low, high) in found.intervals.items())
    assert stats.binom.cdf(held, 6, 0.85) > 1e-2


def test_the_fitted_scene_has_the_best_numbers(record, tmp_path):
    options = [f"--free={key}={span}" for key, span in FREE.items()]
    options += [
        f"--set={key}={value}" for key, value in (OVER | {"wob": "55 kN", "numerics.frame_rate": "10 Hz"}).items()
    ]
    command = [
        "fit", record, "--scene", "two_mass", *options, "--channel", "bit_speed=bit speed [rpm]", "--to", "30 s",
        "--rate", "10 Hz", "--members", "16", "--rounds", "24", "--out", tmp_path / "fit", "--json",
    ]  # fmt: skip
    done = CliRunner().invoke(app, list(map(str, command)))
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["likelihood_power"] == 1.0
    assert found["undetermined"] == []
    assert [said.partition(":")[0] for said in found["of_law"]] == [*HIDDEN]
    for key, hidden in HIDDEN.items():
        assert found["numbers"][key]["high"] - found["numbers"][key]["low"] < 0.2 * hidden
    fitted = dt.load_scene(tmp_path / "fit" / "fitted.yaml")
    assert fitted.effects.bit_torque_stribeck.sticking == found["numbers"]["bit_torque_stribeck.sticking"]["best"]
    assert (tmp_path / "fit" / "fit.png").stat().st_size > 10_000


def test_a_number_that_leaves_no_trace_is_told_as_undetermined(record):
    found = dt.fit(
        record, "two_mass", {"internal_damping.bending_time": (0.001, 0.02)}, channels=["bit_speed=bit speed [rpm]"],
        overrides=OVER, end=10.0, rate=10.0, members=16, rounds=2,
    )  # fmt: skip
    assert found.undetermined[0].startswith("internal_damping.bending_time: the 90 % interval covers")
    assert found.of_law == []


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"free": {}}, ArgumentError, "expected a range of at least one number"),
        ({"free": {"wall_friction.coefficient": "0.1..0.3"}}, SceneError, "wall_friction"),
        ({"free": {"bit_torque_stribeck.sticking": "0.9..0.6"}}, ArgumentError, "with LO below HI"),
        ({"likelihood": "guess"}, ArgumentError, "a likelihood of series, features"),
        ({"channels": ["bit_speed=no such column:rpm"]}, TableError, 'expected a column "no such column"'),
        ({"channels": ["bit_speed=bit speed [rpm]:N"]}, TableError, "bit_speed: expected a unit of"),
        ({"end": 60.0}, ArgumentError, "expected bit_speed from"),
        ({"begin": 10.0}, ArgumentError, "expected 10 samples or more to compare, found samples from 10 s to 10 s at"),
        ({"begin": 40.0}, ArgumentError, "expected 10 samples or more to compare"),
        ({"likelihood": "features"}, ArgumentError, "expected 3 windows of features or more without a gap, found 2"),
    ],
)
def test_what_cannot_be_fitted_is_refused(record, change, error, said):
    arguments = {"free": {"bit_torque_stribeck.sticking": "0.6..0.9"}, "channels": ["bit_speed=bit speed [rpm]"]}
    with pytest.raises(error, match=said.replace("(", r"\(")):
        dt.fit(
            record, "two_mass", overrides=OVER, members=2, rounds=1, rate=10.0, **{"end": 10.0, **arguments, **change}
        )


def test_a_bag_and_a_mat_file_are_records_too(tmp_path, monkeypatch):
    result = dt.Simulation(dt.load_scene("two_mass", OVER)).run(duration=2.0)
    found = dt.read_record(result.to_bag(tmp_path / "bag_0"), ["torque", "bit_speed"])
    time = np.arange(0.5, 1.9, 0.1)
    rate = np.interp(time - 0.05, result.rig.time, result.rig.bit_speed)
    assert found.at("bit_speed", time) == pytest.approx(rate, abs=1e-9)
    assert found.series["torque"][0] == pytest.approx(result.time - 0.05)
    savemat(tmp_path / "rig.mat", {"Time": np.arange(4.0)[:, None], "Torque": np.array([[1.0, np.nan, 2.0, 4.0]]).T})
    stamps, torque = dt.read_record(tmp_path / "rig.mat", ["torque=Torque:kN m"]).series["torque"]
    assert stamps.tolist() == [0.0, 2.0, 3.0]
    assert torque.tolist() == [1e3, 2e3, 4e3]
    told = dt.read_record(tmp_path / "bag_0", ["weight_on_bit", "rotation"]).series
    assert told["weight_on_bit"][1] == pytest.approx(np.full(20, OVER["wob"]))
    assert told["rotation"][1] == pytest.approx(np.full(20, 100.0))
    monkeypatch.setattr(CommandSeries, "__len__", lambda _: 0)  # a bag without commands: what the rig did
    told = dt.read_record(tmp_path / "bag_0", ["weight_on_bit", "rotation"]).series
    assert told["weight_on_bit"][1] == pytest.approx(result.rig.bit_force)
    assert told["rotation"][1] == pytest.approx(result.rig.top_drive_speed)
    with pytest.raises(ArgumentError, match="expected of a bag one of torque, top_drive_speed"):
        dt.read_record(tmp_path / "bag_0", ["motor_torque"])
    with pytest.raises(ArgumentError, match='expected of a bag the name alone, as "torque", found "torque=T:kN m"'):
        dt.read_record(tmp_path / "bag_0", ["bit_speed", "torque=T:kN m"])


def test_a_record_that_is_dense_is_averaged_over_the_spacing():
    stamps = np.arange(0.0, 2.0, 0.001)
    record = dt.Record("made up", {"torque": (stamps, stamps**2)})
    time = np.array([0.5, 1.0, 1.5])
    assert record.at("torque", time) == pytest.approx((time**3 - (time - 0.5) ** 3) / 1.5, rel=1e-5)


def test_a_mean_in_a_file_is_that_of_the_time_before_its_stamp(tmp_path):
    result = dt.Simulation(dt.load_scene("two_mass", OVER)).run(duration=2.0)
    table = result.to_pandas()[["torque [N m]"]]
    table.to_csv(tmp_path / "rig.csv")
    record = dt.read_record(tmp_path / "rig.csv", ["torque=torque [N m]:N m"])
    own = result.time[4:]
    assert record.at("torque", own) == pytest.approx(table["torque [N m]"].to_numpy()[4:], rel=1e-9)
    bag = dt.read_record(result.to_bag(tmp_path / "bag_0"), ["torque"])
    coarse = own[4::4]
    assert record.at("torque", coarse) == pytest.approx(bag.at("torque", coarse), rel=1e-9)


def test_what_a_record_lacks_is_missing_and_not_a_straight_line():
    stamps = np.concatenate((np.arange(0.0, 3.0, 0.1), np.arange(6.0, 9.0, 0.1)))
    record = dt.Record("made up", {"torque": (stamps, np.sin(stamps))})
    time = np.arange(0.5, 8.5, 0.1)
    found = record.at("torque", time)
    middle = time - 0.05
    assert np.isnan(found).tolist() == ((middle > 2.9) & (middle < 6.0)).tolist()
    assert found[np.isfinite(found)] == pytest.approx(np.sin(middle[np.isfinite(found)]), abs=2e-3)


def test_samples_may_be_values_at_their_times(tmp_path):
    stamps = np.arange(0.1, 4.05, 0.1)
    record = dt.Record("made up", {"torque": (stamps, np.sin(stamps))}, instant=frozenset({"torque"}))
    time = np.arange(0.5, 3.5, 0.1)
    assert record.at("torque", time) == pytest.approx(np.sin(time), abs=1e-9)
    over = OVER | {"numerics.frame_rate": 50.0}
    ensemble = dt.Ensemble("two_mass", {"wob": [55e3]}, overrides=over)
    run = ensemble.run(4.0, outputs=("channels", "instants"), mark_rate=10.0)
    fine = ensemble.run(4.0, outputs=("instants",), mark_rate=50.0)
    for name in ("bit_speed", "torque", "top_drive_speed"):
        assert run[f"{name}@instant"][0] == pytest.approx(fine[f"{name}@instant"][0][4::5])
    assert run["torque"][0] == pytest.approx(fine["torque@instant"][0].reshape(-1, 5).mean(axis=1))
    rows = np.column_stack((run["time"], run["torque@instant"][0] / 1e3))
    np.savetxt(tmp_path / "rig.csv", rows, delimiter=",", header="time [s],TQ", comments="")
    read = dt.read_record(tmp_path / "rig.csv", ["torque@instant=TQ:kN m"])
    assert read.instant == {"torque"}
    free = {"rig.top_drive.damping": (400.0, 450.0)}
    told = {}
    for name, of in (("instant", read), ("mean", dt.Record("mean", read.series))):
        told[name] = dt.fit(of, "two_mass", free, overrides=over, begin=0.5, end=3.8, rate=10.0, members=16, rounds=2)
    assert told["instant"].goodness["torque"].residual < 0.1 * told["mean"].goodness["torque"].residual


def test_a_fit_says_what_the_model_does_not_explain(record):
    read = dt.read_record(record, ["bit_speed=bit speed [rpm]"])
    time, speed = read.series["bit_speed"]
    free = {"bit_torque_stribeck.sticking": (0.69, 0.73)}
    told = {}
    for name, scale in (("own", 1.0), ("scaled", 1.3)):
        other = dt.Record(name, {"bit_speed": (time, scale * speed)}, ends=read.ends)
        over = OVER | {"effects.bit_torque_stribeck.decay": 1.3}
        told[name] = dt.fit(
            other, "two_mass", free, overrides=over, begin=1.0, end=20.0, rate=10.0, members=16, rounds=3
        )
    assert told["own"].unexplained == ""
    assert told["own"].goodness["bit_speed"].ratio < 1.2
    assert told["scaled"].unexplained.startswith("the model does not explain bit speed (residual ")
    assert told["scaled"].to_dict()["goodness"]["bit_speed"]["explained"] is False


def test_a_fit_of_features_does_not_ask_for_the_phase():
    """A twin that sticks and slips, whose record begins 3.3 s later than the runs."""
    over = {"numerics.step": "20 ms", "numerics.frame_rate": 10.0}
    key = "bit_torque_stribeck.sticking"
    found = dt.Ensemble("two_mass", {key: [0.88]}, overrides=over).run(50.0, outputs=("channels",), mark_rate=10.0)
    time, speed = found["time"], found["bit_speed"][0]
    speed = speed + 0.05 * np.random.default_rng(1).standard_normal(time.size)
    told = {}
    for name, scale in (("own", 1.0), ("scaled", 1.5)):
        later = dt.Record(name, {"bit_speed": (time - 3.3, scale * speed)})
        told[name] = dt.fit(
            later, "two_mass", {key: (0.8, 0.97)}, overrides=over, likelihood="features", begin=20.0, end=40.0,
            rate=10.0, members=16, rounds=3,
        )  # fmt: skip
    low, high = told["own"].intervals[key]
    assert low <= 0.88 <= high
    assert high - low < 0.1
    assert told["own"].unexplained == ""
    assert told["own"].goodness["bit_speed"].of == "features"
    assert told["scaled"].unexplained.startswith("the model does not explain bit speed (residual ")
    assert "of the features in the band" in told["scaled"].unexplained


def test_what_is_no_measurement_is_left_out_of_a_fit_and_told(record, tmp_path):
    lines = record.read_text("utf-8").splitlines()
    for row, null in ((20, "-999.25"), (21, ""), (22, "No Data"), (40, "-999"), (41, "77777"), (42, "1e6")):
        lines[row] = lines[row].partition(",")[0] + "," + null
    holed = tmp_path / "holed.csv"
    holed.write_text("\n".join(lines), "utf-8")
    told = [
        (
            "bit speed [rpm]: left out 2 without a number (rows 21 to 22), 1 of -999.25 (row 20), 1 of 77777 (row 41), "
            "1 beyond any speed of the bit (row 42), 1 of -999 (row 40)"
        )
    ]
    channels = ["bit_speed=bit speed [rpm]", "null_value=77777", "null_value=-5555", "block_weight=32 klbf"]
    read, whole = dt.read_record(holed, channels), dt.read_record(record, channels[:1])
    assert read.notes == told
    for found, all_of_it in zip(read.series["bit_speed"], whole.series["bit_speed"], strict=True):
        assert found == pytest.approx(np.delete(all_of_it, [19, 20, 21, 39, 40, 41]))
    found = dt.fit(
        holed, "two_mass", {"bit_torque_stribeck.sticking": (0.6, 0.9)}, channels=channels, overrides=OVER, end=10.0,
        rate=10.0, members=8, rounds=1,
    )  # fmt: skip
    assert found.to_dict()["notes"] == told


def test_set_points_of_a_record_are_played(tmp_path):
    """As `estimate` plays them: a scene with constant set-points follows a rig whose weight and speed change."""
    over = OVER | {"numerics.frame_rate": 50.0}
    ramps = {
        "rig.weight_on_bit.shape": "ramp", "rig.weight_on_bit.initial": 20e3, "rig.weight_on_bit.duration": 6.0,
        "rig.rotation.shape": "ramp", "rig.rotation.initial": 6.0, "rig.rotation.duration": 8.0,
    }  # fmt: skip
    key, hidden = "bit_torque_stribeck.sticking", 0.71
    rig = dt.Ensemble("two_mass", {key: [hidden]}, overrides=over | ramps)
    found = rig.run(9.0, outputs=("channels",), mark_rate=10.0)
    at = Schedule.from_scene(dt.load_scene("two_mass", over | ramps)).over(np.arange(0.0, 10.0, 0.5))
    rows = np.column_stack((np.arange(0.0, 10.0, 0.5), at[:, :2]))
    torque = np.column_stack((found["time"], found["torque"][0]))
    played = {name: (rows[:, 0], rows[:, number]) for number, name in ((1, "weight_on_bit"), (2, "rotation"))}
    again = dt.Ensemble("two_mass", {key: [hidden]}, overrides=over).run(
        9.0, outputs=("channels",), mark_rate=10.0, played=played
    )
    np.testing.assert_allclose(again["torque"], found["torque"], rtol=1e-6)  # its start has another load
    record = dt.Record("rig", {"torque": tuple(torque.T), **played}, ends=frozenset({"torque"}))
    told = dt.fit(record, "two_mass", {key: (0.6, 0.8)}, overrides=over, end=9.0, rate=10.0, members=16, rounds=4)
    assert set(told.record.series) == {"torque"}
    assert told.best[key] == pytest.approx(hidden, abs=2e-3)
    assert told.record.notes == [
        "rotation, weight_on_bit: played, not compared; fitted.yaml has the set-points of the scene"
    ]
    with pytest.raises(ArgumentError, match=r"that the run takes, found rig\.weight_on_bit.*: the record is played"):
        dt.fit(record, "two_mass", {"wob": "50 kN..58 kN"}, overrides=over, end=9.0)


OVERLAPPING = {"bit_torque_stribeck.sticking": "0.45..0.95", "bit_torque_stribeck.sliding": "0.3..0.9"}
"""The scene takes no sticking torque below the sliding torque, and has 0.5 and 0.8."""


def test_overlapping_ranges_lose_the_draws_that_do_not_fit(record):
    told = dt.fit(
        record, "two_mass", OVERLAPPING, channels=["bit_speed=bit speed [rpm]"], overrides=OVER, end=10.0, rate=10.0,
        members=16, rounds=2,
    )  # fmt: skip
    assert [*told.ranges.values()] == [(0.45, 0.95), (0.3, 0.9)]
    below = told.values[:, 0] < told.values[:, 1]
    assert below.any()
    assert not told.sampling.weights[below].any()
    assert told.record.notes == [f"{below.sum()} of 32 draws left out: the scene does not take their numbers together"]
    never = {"bit_torque_stribeck.sticking": "0.2..0.3", "bit_torque_stribeck.sliding": "0.5..0.9"}
    with pytest.raises(SceneError, match="expected `sticking` not below `sliding`"):
        dt.fit(record, "two_mass", never, channels=["bit_speed=bit speed [rpm]"], overrides=OVER)


def test_a_channel_needs_a_name_of_the_contract_and_a_unit(tmp_path):
    assert channel_column("torque=T:kN m") == ("torque", "T", "kN m")
    with pytest.raises(ArgumentError, match=r'channel: expected NAME=COLUMN:UNIT .* did you mean "bit_torque"'):
        channel_column("bit_torqe=x:N m")
    record = tmp_path / "rig.csv"
    record.write_text("time [s],T,TQA [kft-lb]\n0,1,1\n1,2,2\n")
    with pytest.raises(TableError, match='found "T"; or give it, as --channel "torque=T:UNIT"'):
        dt.read_record(record, ["torque=T"])
    with pytest.raises(ArgumentError, match="expected one or more, as bit_speed=COLUMN:rpm, found time"):
        dt.read_record(record, ["time=T:s"])
    with pytest.raises(ArgumentError, match="expected each one once, found torque again"):
        dt.read_record(record, ["torque", "torque=T:N m"])
    with pytest.raises(ArgumentError, match=r"fit: expected a channel of a run, .* found none"):
        dt.fit(record, "two_mass", {"wob": "50 kN..58 kN"}, channels=["weight_on_bit=T:kN"])
    assert dt.read_record(record, ["torque"]).series["torque"][1] == pytest.approx([1355.818, 2711.636], rel=1e-6)


@pytest.mark.parametrize(
    ("key", "given", "message"),
    [
        ("wob", "58 kN..50 kN", "wob: expected LO..HI"),
        ("string.sections.spring.length", "1 m..2 m", "spring"),
    ],
)
def test_a_short_name_is_a_key_and_a_name_in_a_list_is_none(record, key, given, message):
    with pytest.raises(ArgumentError, match=message):
        dt.fit(record, "two_mass", {key: given}, channels=["bit_speed=bit speed [rpm]"])
