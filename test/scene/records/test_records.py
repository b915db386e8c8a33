# SPDX-License-Identifier: Apache-2.0
"""LAS and WITSML time logs are read as CSV tables are, with their units and gaps; what is no such log is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from summaries import summarise

import drill_twin as dt
from drill_twin.cli.analyze import analyze, export
from drill_twin.core.errors import TableError
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.report import build_report
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection
from drill_twin.scene.records import CHANNELS, Columns, read_columns
from drill_twin.scene.set_points import read_table

RPM = math.pi / 30.0
LAS = """~Version
VERS. 2.0 : CWLS LOG ASCII STANDARD - VERSION 2.0
WRAP.  NO : ONE LINE PER STEP
~Well
STRT.S      0 : START
STOP.S      3 : STOP
STEP.S      1 : STEP
NULL.   -9999 : NULL
~Curve
TIME.S        : time
WOB .KLBF     : weight on bit
RPM .RPM      : rotary speed
TQA .KFT.LBF  : torque
NOTE.         : remark
~Ascii
0 10.0   60 1.0 drilling
1 -999.25 60 1.0 drilling
2 -9999  120 1.0 connection
3 13.0   120 1.0 drilling
"""
WITSML = """<?xml version="1.0" encoding="UTF-8"?>
<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">
<log uidWell="w" uidWellbore="b" uid="l"><nameWell>Well</nameWell><name>GenTime</name>
<indexType>date time</indexType><indexCurve>Time</indexCurve><nullValue>-999.25</nullValue>
<logCurveInfo uid="Time"><mnemonic>Time</mnemonic><typeLogData>date time</typeLogData></logCurveInfo>
<logData><mnemonicList>Time,WOB_AVG,SURF_RPM,HKLD_AVG,ACTIVITY</mnemonicList>
<unitList>unitless,N,c/s,klbf,unitless</unitList>
<data>2016-09-30T10:04:01.000Z,44482.216,1,-999.25,on bottom</data>
<data>2016-09-30T10:04:02.000Z,,1,200,"on, bottom"</data>
<data>2016-09-30T10:04:03.500+00:00,57826.881,2,,on bottom</data>
</logData></log></logs>
"""


def written(folder: Path, text: str, name: str = "") -> Path:
    path = folder / (name or ("log.las" if text.startswith("~") else "log.xml"))
    path.write_text(text, encoding="utf-8")
    return path


def test_a_las_file_is_played_in_si_and_its_nulls_are_gaps(tmp_path):
    table = read_table(written(tmp_path, LAS), longest_gap=5.0, spike_window=0.0)
    assert table.weight_on_bit == pytest.approx(np.array([10.0, 11.0, 12.0, 13.0]) * 4448.2216152605)
    assert table.rotation == pytest.approx(np.array([60.0, 60.0, 120.0, 120.0]) * RPM)
    assert "read: TIME [S], WOB [KLBF], RPM [RPM]" in table.report
    assert "1 gap (2 samples, longest 3 s) bridged" in table.report
    record = dt.read_record(tmp_path / "log.las", ["torque", "bit_force=WOB"])
    assert record.series["torque"][1] == pytest.approx(1355.8179483)
    assert record.series["bit_force"][0].tolist() == [0.0, 3.0]


def test_a_witsml_log_is_played_from_its_first_date(tmp_path):
    table = read_table(written(tmp_path, WITSML), longest_gap=5.0, spike_window=0.0)
    assert table.time.tolist() == [0.0, 1.0, 2.5]
    assert table.weight_on_bit[[0, 2]] == pytest.approx(np.array([10.0, 13.0]) * 4448.2216)
    assert table.rotation == pytest.approx([2.0 * math.pi, 2.0 * math.pi, 4.0 * math.pi])
    assert "read: Time [s], WOB_AVG [N], SURF_RPM [c/s]" in table.report
    columns = read_columns(tmp_path / "log.xml")
    assert "ACTIVITY" not in columns
    assert np.isnan(columns["HKLD_AVG"]).tolist() == [True, False, True]
    elapsed = WITSML.replace("date time</indexType>", "elapsed time</indexType>").replace(">unitless,N", ">min,N")
    for k, stamp in enumerate(("10:04:01.000Z", "10:04:02.000Z", "10:04:03.500+00:00")):
        elapsed = elapsed.replace(f"2016-09-30T{stamp}", str(k))
    assert read_table(written(tmp_path, elapsed), longest_gap=500.0).time.tolist() == [0.0, 60.0, 120.0]


def test_a_csv_file_with_dates_and_nulls_is_read(tmp_path):
    rows = ("timestamp_utc_iso,wob_kN,rpm", "2026-05-14T13:57:00.100Z,1,60", "2026-05-14T13:57:00.600Z,-999.25,60")
    text = "\n".join((*rows, "2026-05-14T13:57:01.100Z,3,60"))
    table = read_table(written(tmp_path, text, "drilling_timeseries.csv"), spike_window=0.0)
    assert table.time.tolist() == [0.0, 0.5, 1.0]
    assert table.weight_on_bit.tolist() == [1e3, 2e3, 3e3]


def test_a_record_is_analysed_and_exported_as_a_bag_is(tmp_path, capsys):
    time = np.arange(0.0, 20.0, 0.05)
    speed = np.maximum(60.0 + 90.0 * np.sin(2.0 * math.pi * 0.3 * time), 0.0)
    rows = "".join(f"<data>{t:g},60,{v:g}</data>" for t, v in zip(time, speed, strict=True))
    head = WITSML[: WITSML.index("<logData>")].replace("date time</indexType>", "elapsed time</indexType>")
    path = written(
        tmp_path,
        f"{head}<logData><mnemonicList>ETIM,RPM,BRPM</mnemonicList><unitList>s,rpm,rpm</unitList>{rows}</logData></log></logs>",
    )
    recording = read_recording(path)
    assert recording.rig.bit_speed == pytest.approx(speed * RPM, rel=1e-4)
    assert np.isnan(recording.rig.hookload).all()
    (period,) = summarise(recording)["stick_slip"]
    assert period["frequency_hz"] == pytest.approx(0.3, rel=0.02)
    analyze(path)
    told = capsys.readouterr()
    assert "rotation from RPM [rpm], bit_speed from BRPM [rpm]; converted to SI" in told.err
    assert "not observable" in told.out
    assert "largest radius" not in told.out  # no marks, so no table of them, and none of the string's motion
    assert "motion of the string" not in told.out
    export(path, csv=True, out=tmp_path / "again")
    assert read_recording(tmp_path / "again" / "rig.csv").rig.bit_speed == pytest.approx(
        recording.rig.bit_speed, rel=1e-9
    )


@pytest.mark.parametrize(
    ("heading", "clocks", "step"),
    [
        ("Time [MM:SS]", [f"{95 + k // 60}:{k % 60:02}" for k in range(600)], 1.0),  # 100:00 is 100 minutes
        ("Time", [f"{k // 60}:{k % 60:02}" if k < 3600 else f"1:00:{k - 3600:02}" for k in range(3550, 3650)], 1.0),
        ("Time [HH:MM]", [f"0:{k:02}" for k in range(50)], 60.0),
        ("Time [MM:SS]", [f"0:{k:02}" for k in range(50)], 1.0),
        ("Time", [f"1:{k:02} pm" for k in range(50)], 60.0),
    ],
)
def test_a_clock_of_two_numbers_is_read_as_its_cells_or_its_heading_tell(tmp_path, heading, clocks, step):
    file = written(tmp_path, f"{heading},RPM [rpm]\n" + "".join(f"{clock},100\n" for clock in clocks), "rig.csv")
    assert np.diff(read_recording(file).rig.time) == pytest.approx(np.full(len(clocks) - 1, step))


def test_a_clock_of_two_numbers_that_nothing_tells_is_asked_for(tmp_path):
    rows = "".join(f"{k // 60}:{k % 60:02},100\n" for k in range(1600))  # an elapsed time may have more than 25 hours
    file = written(tmp_path, f"Time,RPM [rpm]\n{rows}", "rig.csv")
    with pytest.raises(TableError, match=r'rig\.csv: .* two numbers in "Time", .* as --channel "time=Time:MM:SS"'):
        read_recording(file)
    for form, step in (("MM:SS", 1.0), ("HH:MM", 60.0)):
        rig = read_recording(file, selection=Selection(choices=(f"time=Time:{form}",))).rig
        assert np.diff(rig.time) == pytest.approx(np.full(1599, step))


def test_a_table_without_a_speed_or_time_is_no_record_to_analyse(tmp_path):
    for text in ("time [s],WOB [kN]\n0,1\n1,1\n", "RPM\n1\n2\n"):
        with pytest.raises(TableError, match="expected columns of time and of the speed"):
            read_recording(written(tmp_path, text, "rig.csv"))


HEAVY = 'expected numbers in column "WOB_AVG" for weight_on_bit, found "heavy" in row 3'
DATA = WITSML[: WITSML.index("<data>")] + "</logData></log></logs>"
BAD = [
    (LAS.replace("RPM .RPM", "RPM .FURLONG"), 'column "RPM" for rotation: '),
    (LAS.replace("TIME.S", "DEPT.M"), "expected a log over time, found one over DEPT; export the log over time"),
    (LAS.replace("NULL.   -9999", "NULL.   none"), "expected a number as null value"),
    (
        LAS.replace("2 -9999  120", "2 -9999  12O"),
        'expected numbers in column "RPM" for rotation, found "12O" in row 3',
    ),
    (LAS[: LAS.index("~Ascii")], "with ~V and ~A sections, found none"),
    (LAS.replace("3 13.0   120 1.0", "3 " + "1" * 200_000), "expected a line of at most 100000 characters"),
    (WITSML.replace("1.4.1.1", "1.3.1.1"), 'expected <logs version="1.4.1.1"> of WITSML, found <logs> of version 1.3'),
    (WITSML.replace("date time</indexType>", "measured depth</indexType>"), "expected a log over time"),
    (WITSML.replace(",1,200,", ",200,"), "row 2: expected 5 values as in the header, found 4"),
    (WITSML.replace("10:04:02.000Z", "noon"), 'expected a time in row 2, found "2016-09-30Tnoon"'),
    (WITSML.replace("57826.881", "heavy"), HEAVY),
    (WITSML.replace("WOB_AVG,", "Time,"), "expected one column for time, found 2 (Time:1, Time:2)"),
    (DATA, "expected <data> in the log, found none"),
    (WITSML.replace("</logs>", ""), "expected a WITSML log, found no element found"),
    (WITSML.replace("</log>", "</log><log/>"), "expected one log, found more"),
    (WITSML.replace("<logs", '<!DOCTYPE x [<!ENTITY a "b">]><logs', 1), "expected no document type"),
    (WITSML.replace("<logs", '<!DOCTYPE x SYSTEM "file:///etc/passwd"><logs', 1), "expected no document type"),
    (WITSML.replace("UTF-8", "UUF-8"), "expected a WITSML log, found unknown encoding: UUF-8; export it again"),
    (WITSML.replace("<nameWell>", "<a>" * 50), "expected elements at most 20 deep"),
    (WITSML.replace("GenTime", "x" * 1_100_000), "expected texts of at most 1000000 characters"),
]


@pytest.mark.parametrize(("text", "words"), BAD, ids=[words[:40] for _, words in BAD])
def test_a_log_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, words):
    path = written(tmp_path, text)
    with pytest.raises(TableError) as caught:
        read_table(path, longest_gap=5.0)
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_numbers_beyond_any_record_are_missing_or_refused(tmp_path):
    rows = "time (s),rpm,WOB (kN)\n0,60,1\n1,60,1e306\n2,60,3\n"
    path = written(tmp_path, rows, "huge.csv")
    assert read_table(path, longest_gap=5.0, spike_window=0.0).weight_on_bit == pytest.approx([1000.0, 2000.0, 3000.0])
    path.write_text(rows.replace("\n2,", "\n1e300,"), "utf-8")
    with pytest.raises(TableError, match=r"expected times of at most 2.14748e\+09 s, found 1e\+300 s"):
        RecordBag(path)


def test_a_block_of_nulls_is_no_set_point_and_a_file_beside_the_record_names_its_columns(tmp_path, capsys):
    rows = "".join(
        f"{k},{-9999 if 20 <= k < 31 else 9 + k % 3},{110 + k % 2},{-555 if k == 4 else 70}\n" for k in range(60)
    )
    path = written(tmp_path, f"Time,Load cell,RPM [rpm],Hook\n{rows}", "well.csv")
    with pytest.raises(TableError, match="Time: no unit: give it, as --channel"):
        read_recording(path)
    written(
        tmp_path,
        "time: Time:s\nweight_on_bit: Load cell:klbs\nhookload: Hook:tonne\nnull_value: -555\n",
        "well.csv.yaml",
    )
    played = read_table(path, longest_gap=20.0, spike_window=0.0)
    assert played.weight_on_bit.min() == pytest.approx(9.0 * 4448.2216152605)
    assert "1 gap (11 samples, longest 12 s) bridged" in played.report
    summary = summarise(read_recording(path))
    assert summary["loads"]["hookload_n"]["min"] == pytest.approx(70.0 * 9806.65)
    assert [one["left_out"] for one in summary["columns"]] == [
        [], ["11 of -9999 (rows 21 to 31)"], [], ["1 of -555 (row 5)"],
    ]  # fmt: skip
    analyze(path, channel=["rotation=RPM [rpm]"], everything=True)
    told = capsys.readouterr()
    assert "taken as weight_on_bit in klbs; no measurement: 11 of" in " ".join(told.out.split())
    assert "write well.csv.yaml beside it, a line each: rotation: 'RPM [rpm]'" in " ".join(told.err.split())
    (series,) = dt.read_record(path, ["hookload"]).series.values()
    assert series[0].size == 59


ODD = {
    "gaps.csv": ("time [s],RPM [rpm],WOB [klbf],TQ [kft-lb]\n0,0,0,0\n0.1,10,,1\n0.2,,-999.25,1.5\n0.3,30,3,\n", "kN"),
    "two_rows.csv": ("time [s],BRPM [rpm]\n3,120\n4,120\n", "no weight and no speed"),
    "only_speed.csv": (
        "DTIM,RPM [rpm],HKLD [kN]\n" + "".join(f"2024-05-01T12:00:{k:02d}Z,{60 + k},-999.25\n" for k in range(30)),
        "top drive at 82 rpm on average",
    ),
}


@pytest.mark.parametrize("name", ODD)
def test_a_report_of_a_record_draws_what_it_holds_and_says_what_it_leaves_out(tmp_path, name):
    text, said = ODD[name]
    files = build_report(written(tmp_path, text, name), tmp_path / "out")
    page = files.page.read_text("utf-8")
    assert list(files.figures) == ["set_points"]
    assert files.figures["set_points"].stat().st_size > 5000
    assert "not drawn: " not in page  # a record of a rig has one figure
    assert said in page
    assert f"<h1>{name}</h1>" in page


@pytest.mark.parametrize("names", ["time_s wob_kN rpm", "Time_s WOB_kN RPM_rpm", "time_min SWOB_klbf rpma_rpm"])
def test_variables_of_a_mat_file_by_plain_names_that_end_in_their_unit(tmp_path, names):
    time, wob, rpm = names.split()
    path = tmp_path / "well.mat"
    savemat(path, {time: np.arange(50.0), wob: np.full(50, 100.0), rpm: np.full((1, 50), 120.0), "note": "none"})
    found = read_columns(path)
    assert [found.named(channel) for channel in ("time", "weight_on_bit", "rotation")] == [[time], [wob], [rpm]]
    assert found.unit(time, CHANNELS["time"].dimension) == time.rpartition("_")[2]
    assert found.unit(rpm, CHANNELS["rotation"].dimension).lower() == "rpm"
    export = Columns(path, {"WOB": np.arange(2.0), "wob_kN": np.arange(2.0)})
    assert export.named("weight_on_bit") == ["WOB"]  # the name itself before one with an ending


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Time [s];WOB [N];RPM [rpm]\n0;50.125;8.500\n1;50.250;9.500\n", "a point that is of thousands or of decimals"),
        (
            "Well,A\nTime [s],RPM,WOB [N]\n0,1,2\n1,2,3\nWell,B\nTime [s],RPM,WOB [N]\n2,3,4\n3,4,5\n",
            "a second header below rows",
        ),
    ],
)
def test_what_may_mean_two_things_is_refused(tmp_path, text, words):
    with pytest.raises(TableError, match=words):
        read_columns(written(tmp_path, text, "log.csv"))


def test_a_clock_that_stood_for_half_a_day_did_not_pass_midnight_backwards(tmp_path):
    text = "Time,WOB [kN]\n08:00:00,1\n08:00:01,2\n21:30:00,3\n21:30:01,4\n00:00:01,5\n"
    assert read_columns(written(tmp_path, text, "log.csv")).channel("time").values.tolist() == [
        0.0,
        1.0,
        48600.0,
        48601.0,
        57601.0,
    ]
