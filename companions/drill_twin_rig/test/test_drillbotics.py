# SPDX-License-Identifier: Apache-2.0
"""`drill-twin export --drillbotics`: the two files hold the bag's signals by D-WIS name, and a broken rule is found."""

import csv
import math

import numpy as np
import pytest

from drill_twin.core.errors import TableError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.report.recording import read_recording
from drill_twin_rig.gateway.drillbotics import SUGGESTED, TIMESERIES, check_log, check_timeseries

lasio = pytest.importorskip("lasio")


@pytest.fixture
def files(bench_run, call, tmp_path):
    said = call("export", "--drillbotics", bench_run.bag, "--out", tmp_path / "out", "--well", "Ä 1", "--rate", "5 Hz",
                "--start", "2026-05-14T13:57:00Z")  # fmt: skip
    assert said.code == 0, said.err
    assert "1 row a second or more" in said.out
    assert "Ä 1" in said.out
    return tmp_path / "out"


def test_the_files_hold_the_means_of_the_recorded_signals(bench_run, files):
    header, *rows = csv.reader((files / TIMESERIES).read_text("utf-8").splitlines())
    assert header[: len(SUGGESTED)] == list(SUGGESTED)
    assert "DownholeRPM (rpm)" in header
    rig = read_recording(bench_run.bag).rig
    first = rig.time[0]
    assert rows[0][0] == f"2026-05-14T13:57:{first + 0.2:06.3f}Z"
    inside = (rig.time > first + 0.2 + 1e-9) & (rig.time <= first + 0.4 + 1e-9)
    row = dict(zip(header, rows[1], strict=True))
    assert float(row["rpm"]) == pytest.approx(rig.top_drive_speed[inside].mean() * 30.0 / math.pi, rel=1e-5)
    assert float(row["wob_kN"]) == pytest.approx(rig.bit_force[inside].mean() / 1e3, rel=1e-5)
    assert row["spp_MPa"] == ""
    las = lasio.read(str(files / "_1_logs.las"), encoding="utf-8", mnemonic_case="preserve")
    assert (las.version["VERS"].value, las.well["WELL"].value) == (2.0, "Ä 1")
    assert las["HookLoad"][1] == pytest.approx(rig.hookload[inside].mean(), rel=1e-6)
    assert {curve.mnemonic: curve.unit for curve in las.curves}["SurfaceTorque"] == "N.m"
    assert np.diff(las["TIME"]) == pytest.approx(0.2)
    again = read_recording(files / TIMESERIES)
    assert again.rig.top_drive_speed[1] == pytest.approx(rig.top_drive_speed[inside].mean(), rel=1e-5)


def test_of_a_bag_with_two_runs_the_last_one_counts(bench_run, call, files, tmp_path):
    bag = Bag(bench_run.bag)
    messages = list(bag.messages())
    begin, end = messages[0][1], messages[-1][1]
    with BagWriter(tmp_path / "bag_0", topics=bag.topics.values()) as writer:
        for topic, stamp, raw in messages:
            if stamp < begin + 0.7 * (end - begin):  # broken off, and begun again
                writer.write(topic, stamp, raw)
        for topic, stamp, raw in messages:
            writer.write(topic, stamp + end + 10**9, raw)
    given = ("--well", "Ä 1", "--rate", "5 Hz", "--start", "2026-05-14T13:57:00Z")
    said = call("export", "--drillbotics", tmp_path / "bag_0", "--out", tmp_path / "twice", *given)
    assert said.code == 0, said.err
    once, twice = ((folder / TIMESERIES).read_text("utf-8").splitlines() for folder in (files, tmp_path / "twice"))
    assert twice == once


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        ("wob_kN", "weight_kN", "suggested columns"),
        ("DownholeRPM (rpm)", "DownholeRPM", "a unit in every heading"),
        ("13:57:00.4", "13:57:00.2", "times increase"),
        ("2026-05-14T13:57:00.4", "14 May 13:57:00.4", "times in UTC, ISO 8601, with milliseconds"),
        ("13:57:00.2", "13:56:00.2", "1 row a second or more"),
        (",,,,,", ",,,high,,", "numbers only"),
        (",,,,,", ",,,,,,", "rows as long as the header"),
    ],
)
def test_a_broken_rule_is_found(files, old, new, rule):
    path = files / TIMESERIES
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    assert rule in {rule for rule, kept, _ in check_timeseries(path) if kept is False}


def test_what_is_no_such_file_or_rate_is_refused(bench_run, call, files, tmp_path):
    (files / "x_logs.las").write_text("nothing")
    with pytest.raises(TableError, match="expected LAS"):
        list(check_log(files / "x_logs.las"))
    renamed = (files / TIMESERIES).rename(tmp_path / "series.csv")
    assert not next(check_timeseries(renamed))[1]
    for options, words in ((("--rate", "0.5 Hz"), "expected 1 Hz"), (("--start", "noon"), "expected a time such as")):
        said = call("export", "--drillbotics", bench_run.bag, "--out", tmp_path / "no", *options)
        assert said.code != 0
        assert words in said.err
