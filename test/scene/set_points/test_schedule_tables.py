# SPDX-License-Identifier: Apache-2.0
"""Records become set-points: units converted, spikes out, gaps bridged, and every bit of it counted and said."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from companion_parts import part
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from drill_twin.core.errors import DrillTwinError, TableError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene
from drill_twin.scene.blocks.rig import Column
from drill_twin.scene.set_points import Schedule, extremes, read_table
from drill_twin.scene.set_points.tables import find_spikes
from drill_twin.scene.well_plan.table import read_table as read_well_table

DRILLBOTICS, SIGNALS = (part(f"drill_twin_rig.gateway.{name}") for name in ("drillbotics", "signals"))

RPM = math.pi / 30.0
Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def text(content: str, name: str = "record.csv") -> Path:
        path = tmp_path / name
        path.write_text(content, encoding="utf-8")
        return path

    return text


def measured(rows: int = 2000, seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two seconds of a noisy rig at 1 kHz: time [s], load [N], speed [rpm]."""
    random = np.random.default_rng(seed)
    time = np.arange(rows) * 1e-3
    load = 500.0 + 50.0 * np.sin(2.0 * np.pi * 2.7 * time) + random.normal(scale=2.0, size=rows)
    speed = 75.0 + 20.0 * np.sin(2.0 * np.pi * 2.7 * time) + random.normal(scale=1.0, size=rows)
    return time, load, speed


def csv(time: np.ndarray, load: np.ndarray, speed: np.ndarray, header: str = "time [s],WOB [N],speed [rpm]") -> str:
    rows = "\n".join(f"{t:.6f},{w:.6f},{v:.6f}" for t, w, v in zip(time, load, speed, strict=True))
    return f"{header}\n{rows}\n"


ROTATION = Column(column="speed [rpm]", unit="rpm")


def test_a_clean_table_is_played_as_it_is(write):
    table = read_table(write("t [s],WOB [kN],RPM\n0,1,60\n1,2,120\n3,4,0\n"), longest_gap=10.0)
    assert table.time.tolist() == [0.0, 1.0, 3.0]
    assert table.weight_on_bit.tolist() == [1e3, 2e3, 4e3]
    assert table.rotation == pytest.approx([60 * RPM, 120 * RPM, 0.0])
    assert table.duration == 3.0
    assert "no spikes, no gaps" in table.report


@pytest.mark.parametrize(
    "content",
    [
        "time [s];WOB [N];RPM\n0,0;10,5;60\n0,5;11,5;60\n",  # decimal comma
        "time [s]\tWOB [N]\tRPM\n0.0\t10.5\t60\n0.5\t11.5\t60\n",
        "time[s] WOB[N] RPM\n0.0 10.5 60\n0.5 11.5 60\n",
        "# a comment\ntime [s], WOB [N], RPM\n\n0.0, 10.5, 60\n0.5, 11.5, 60\n\n",
        'time [s]|WOB [N]|"RPM"\n0.0|10.5|60\n0.5|11.5|60\n',
        "\ufefftime [ms],WOB [kN],RPM\r\n0,0.0105,60\r\n500,0.0115,60\r\n",
        "timestamp (s),weight on bit (N),top drive speed (rev/s)\n0,10.5,1\n0.5,11.5,1\n",
    ],
)
def test_ways_of_writing_a_table_are_understood(write, content):
    table = read_table(write(content))
    assert table.time == pytest.approx([0.0, 0.5])
    assert table.weight_on_bit == pytest.approx([10.5, 11.5])
    assert table.rotation == pytest.approx([60 * RPM, 60 * RPM])


def test_a_mat_file_is_read_by_its_variables(tmp_path: Path):
    time, load, speed = measured()
    savemat(tmp_path / "record.mat", {"T_s": time[:, None], "Load": load[:, None], "Top": speed[None, :], "note": "x"})
    table = read_table(
        tmp_path / "record.mat",
        time=Column(column="T_s", unit="s"),
        weight_on_bit=Column(column="Load", unit="N"),
        rotation=Column(column="Top", unit="rpm"),
    )
    assert table.weight_on_bit == pytest.approx(load)
    assert table.rotation == pytest.approx(speed * RPM)


def test_spikes_are_taken_out_and_counted(write):
    time, load, speed = measured()
    spiked = speed.copy()
    spiked[400:403] = -260.0
    spiked[1200] = 900.0
    spiked[1500:1512] = np.linspace(70.0, -250.0, 12)  # with a flank
    table = read_table(write(csv(time, load, spiked)), rotation=ROTATION)
    assert table.rotation == pytest.approx(speed * RPM, abs=25.0 * RPM)
    assert np.abs(table.rotation - speed * RPM).mean() < 0.1 * RPM
    assert table.cleaning["rotation"].spikes == 3
    assert 13 <= table.cleaning["rotation"].spike_samples <= 25
    assert table.cleaning["weight_on_bit"].spikes == 0
    assert "rotation: 3 spikes (" in table.report
    kept = read_table(write(csv(time, load, spiked)), rotation=ROTATION, spike_window=0.0)
    assert kept.rotation.max() == pytest.approx(900.0 * RPM)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_noise_steps_and_oscillation_are_no_spikes(seed):
    random = np.random.default_rng(seed)
    time = np.arange(3000) * 1e-3
    for values in (
        random.normal(size=3000),
        np.full(3000, random.normal()),
        np.where(time < 1.5, 0.0, 100.0) + random.normal(size=3000),
        random.normal() * 100.0 + 50.0 * np.sin(2.0 * np.pi * random.uniform(0.1, 2.7) * time),
        random.uniform(size=3000).round(1),
    ):
        assert not find_spikes(values, window=100).any()


def test_a_table_too_coarse_for_the_window_keeps_its_values(write):
    table = read_table(write("time [s],WOB [N],RPM\n0,1,0\n1,100,0\n2,1,0\n3,1,0\n"))
    assert table.weight_on_bit.tolist() == [1.0, 100.0, 1.0, 1.0]


def test_missing_values_and_missing_rows_are_bridged_and_counted(write):
    time, load, speed = measured()
    load[100:150] = np.nan
    content = csv(time, load, speed).splitlines()
    del content[1001:1051]  # fifty stamps are missing
    table = read_table(write("\n".join(content).replace("nan", "")), rotation=ROTATION)
    assert table.cleaning["weight_on_bit"].gaps == 2
    assert table.cleaning["weight_on_bit"].gap_samples == 100
    assert table.cleaning["rotation"].gaps == 1
    assert table.cleaning["weight_on_bit"].longest_gap == pytest.approx(0.051)
    expected = np.interp(time[125], [time[99], time[150]], [load[99], load[150]])
    assert table.weight_on_bit[125] == pytest.approx(expected, abs=1e-5)
    assert "2 gaps (100 samples, longest 0.051 s) bridged" in table.report


def test_missing_ends_hold_the_nearest_value(write):
    table = read_table(write("time [s],WOB [N],RPM\n0,,60\n0.5,5,60\n1,5,60\n1.5,NaN,60\n"))
    assert table.weight_on_bit.tolist() == [5.0, 5.0, 5.0, 5.0]
    assert table.cleaning["weight_on_bit"].gaps == 2


def test_repeated_stamps_and_rows_without_a_stamp_are_left_out_and_said(write):
    table = read_table(write("time [s],WOB [N],RPM\n0,1,0\n0.5,2,0\n0.5,3,0\n,4,0\n1,5,0\n"))
    assert table.weight_on_bit.tolist() == [1.0, 2.0, 5.0]
    assert "1 row without a stamp left out; 1 row with a repeated stamp left out" in table.report


def test_a_gap_that_is_too_long_names_its_place(write):
    content = "time [s],WOB [N],RPM\n" + "".join(f"{t / 10},1,1\n" for t in range(100) if not 20 < t < 50)
    with pytest.raises(TableError, match="from 2 s to 5 s; raise `longest_gap`"):
        read_table(write(content))
    assert read_table(write(content), longest_gap=3.0).cleaning["rotation"].gaps == 1


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "found an empty one"),
        ("time [s],WOB [N],RPM\n", "expected a header and rows of numbers"),
        (
            "time [s],WOB [N]\n0,1\n1,2\n",
            'expected one column for rotation, found none; name it, as --channel "rotation=COLUMN:rad/s"',
        ),
        ("time [s],WOB [N],WOB (kN),RPM\n0,1,1,1\n1,2,2,2\n", "expected one column for weight_on_bit, found 2"),
        ("time,WOB [N],RPM\n0,1,1\n1,1,1\n", 'expected a unit in the header, such as "time [s]"'),
        ("time [N],WOB [N],RPM\n0,1,1\n1,1,1\n", 'expected a unit of time such as "s", found "N"'),
        ("time [s],WOB [stone],RPM\n0,1,1\n1,1,1\n", '"stone" is not a known unit'),
        ("0,1,1\n1,1,1\n", "expected a header with column names, found numbers"),
        (
            "time [s],WOB [N],RPM\n0,1,1\n1,one,1\n",
            'expected numbers in column "WOB [N]" for weight_on_bit, found "one" in row 2',
        ),
        ("time [s],WOB [N],RPM\n0,1,1\n1,1\n", ":3: expected 3 values as in the header, found 2"),
        ("time [s],WOB [N],RPM,RPM\n0,1,1,1\n1,1,1,1\n", "expected one column for rotation, found 2"),
        (
            "time [s],WOB [N],RPM\n" + 2 * "".join(f"{k},1,1\n" for k in range(200)),
            "expected time that increases, found 0 s after 199 s",
        ),
        ("time [s],WOB [N],RPM\n1,1,1\n1,1,1\n", "expected at least two time stamps"),
        ("time [s],WOB [N],RPM\n0,,1\n1,,1\n", "expected at least two finite values, found 0"),
        ("time [s],WOB [N],RPM\n0,inf,1\n1,nan,1\n", "expected at least two finite values, found 0"),
        ("a\0b\nc\n", "binary data"),
    ],
)
def test_a_table_that_cannot_be_played_says_why(write, content, words):
    with pytest.raises(TableError) as caught:
        read_table(write(content))
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(write("")))
    assert "\n" not in str(caught.value)


def test_a_wrong_column_lists_what_is_there(write):
    path = write("time [s],WOB [N],RPM\n0,1,1\n1,1,1\n")
    with pytest.raises(TableError) as caught:
        read_table(path, rotation=Column(column="RMP", unit="rpm"))
    assert 'expected a column "RMP" for rotation, found time [s], WOB [N], RPM, did you mean "RPM"?' in str(
        caught.value
    )
    with pytest.raises(TableError, match="expected a unit of speed of rotation"):
        read_table(path, rotation=Column(column="RPM", unit="Hz"))


def test_only_the_columns_that_are_played_are_needed(write):
    path = write("time [s],WOB [N]\n0,1\n1,2\n")
    table = read_table(path, wanted=["weight_on_bit"])
    assert table.rotation is None
    with pytest.raises(TableError, match="expected a column for rotation"):
        table.column("rotation")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing.csv", None, "found nothing there"),
        ("record.mat", b"no MAT file at all, whatever its name", "expected a MAT file"),
        ("record.mat", b"MATLAB 7.3 MAT-file" + b" " * 105 + b"\x00\x02IM" + b"\0" * 400, "version 5 to 7, found 7.3"),
        ("record.mat", b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\x00\x01IM" + b"\xff" * 40, "expected a MAT file"),
        ("record.csv", b"\xff\xfe\x00", "expected a CSV file in UTF-8"),
    ],
)
def test_a_file_that_is_no_table_is_told(tmp_path: Path, name, content, words):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(TableError) as caught:
        read_table(path)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("t.csv", lambda file: tuple(DRILLBOTICS.check_timeseries(file))),
        ("t.csv", lambda file: read_well_table(file, {}, (), "si")),
        ("t.yaml", load_scene),
        ("t.yaml", SIGNALS.read_signals),
    ],
)
def test_a_text_in_another_encoding_is_told(tmp_path: Path, name, read):
    for encoding, words in (("utf-16", "found UTF-16"), ("latin-1", "such as Latin-1")):
        (tmp_path / name).write_text("time,t\N{DEGREE SIGN}\n0,1\n", encoding=encoding)
        with pytest.raises(DrillTwinError, match=f"{words}.*; save it as UTF-8"):
            read(tmp_path / name)


def test_a_folder_is_no_table(tmp_path: Path):
    with pytest.raises(TableError, match="found a folder"):
        read_table(tmp_path)


def test_a_scene_plays_its_table_and_holds_the_ends(write):
    path = write("time [s],RPM\n10,60\n11,60\n12,0\n")  # only what is played need be there
    scene = load_scene(
        "pa6_bench",
        overrides={"rig.rotation": "{shape: table}", "rig.table.file": str(path), "rig.table.start": "0.5 s"},
    )
    schedule = Schedule.from_scene(scene)
    speeds = [schedule.at(time).rotation / RPM for time in (0.0, 0.5, 1.0, 1.5, 60.0)]
    assert speeds == pytest.approx([60.0, 60.0, 30.0, 0.0, 0.0])
    assert schedule.at(4.3).weight_on_bit == pytest.approx(20.0)  # the other set-point keeps its shape
    assert schedule.record.path == path


def test_a_scene_without_its_record_says_how_to_give_it():
    with pytest.raises(TableError) as caught:
        Schedule.from_scene(load_scene("ufrj_rig"))
    assert "scene ufrj_rig: rig.table.file: expected the CSV, MAT, LAS or WITSML file" in str(caught.value)
    assert '"rig.table.file=PATH"' in str(caught.value)


@pytest.mark.parametrize("content", [b"junk", b"junk\n", b"MATLAB 5.0 MAT-file" + b" " * 120])
def test_what_is_no_mat_file_is_one_clear_error(tmp_path, content):
    path = tmp_path / "table.mat"
    path.write_bytes(content)
    with pytest.raises(TableError, match="expected a MAT file"):
        read_table(path)


def played(path: Path, **numerics: object):
    """The paper's rod under a record: one second of it from 0.5 s on."""
    data = load_scene("pa6_bench").model_dump(exclude_none=True)
    data["rig"] |= {
        "weight_on_bit": {"shape": "table"}, "rotation": {"shape": "table"}, "duration": 1.0,
        "table": {"file": str(path), "start": 0.5, "spike_window": 0.0,
                  "weight_on_bit": {"column": "WOB [N]", "unit": "N"}, "rotation": ROTATION.model_dump()},
    }  # fmt: skip
    data["numerics"] |= numerics
    return type(load_scene("pa6_bench")).model_validate(data)


def test_auto_looks_at_the_largest_set_points_of_a_whole_record(write):
    """What comes before the record's part that is played, or after it, does not count; the sign does not either."""
    time = np.arange(0.0, 2.01, 0.01)
    load, speed = np.full(time.size, 10.0), np.full(time.size, 30.0)
    load[[20, 80, 190]], speed[[20, 90, 190]] = (900.0, -120.0, 900.0), (900.0, -240.0, 900.0)
    scene = played(write(csv(time, load, speed)))
    most = extremes(scene)
    assert (most.weight_on_bit, most.rotation) == (pytest.approx(120.0), pytest.approx(240.0 * RPM))
    twin = Twin(scene)
    constant = Twin(load_scene("pa6_bench", overrides={"wob": "120 N", "rig.rotation.value": "240 rpm"}))
    assert (twin.elements, twin.step_size) == (constant.elements, pytest.approx(constant.step_size))
    gentle = Twin(load_scene("pa6_bench", overrides={"wob": "10 N", "rig.rotation.value": "30 rpm"}))
    assert twin.elements > gentle.elements
    assert twin.step_size < gentle.step_size


def test_a_record_that_changes_is_read_again_and_one_that_is_not_there_is_missed_only_where_it_tells(write):
    time = np.arange(0.0, 2.0, 0.01)
    for load in (20.0, 200.0):
        scene = played(write(csv(time, np.full(time.size, load), np.full(time.size, 30.0))))
        assert extremes(scene).weight_on_bit == pytest.approx(load)
    gone = played(write("").with_name("gone.csv"))
    with pytest.raises(TableError, match="nothing there"):
        Twin(gone)
    assert Twin(played(Path("gone.csv"), elements=10, step=1e-3)).elements == 10
    unnamed = load_scene("ufrj_rig")
    assert extremes(unnamed).weight_on_bit == extremes(unnamed).rotation == 0.0
