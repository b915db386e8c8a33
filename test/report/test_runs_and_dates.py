# SPDX-License-Identifier: Apache-2.0
"""A bag with several runs, each of which can be chosen; and stamps that are dates, told as times from the first."""

import re

import pytest
from summaries import summarise

import drill_twin
from drill_twin.core.errors import BagError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.stamps import NANOSECONDS, pack_stamp, raw_header_stamp
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES, TWIN_SCENE
from drill_twin.report import build_report
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection

EPOCH = 1_700_000_000 * NANOSECONDS


@pytest.fixture(scope="module")
def thin(messages):
    """Every second sample."""
    return [row for row in messages if row[1] % 20_000_000 == 0]


@pytest.fixture
def three(messages, thin, write):
    """The whole run in few samples, its first 4 s, and its first 3 s where only stamps tell that a run has begun."""
    runs = [(number, [row for row in messages if row[1] <= end]) for number, end in ((1, 4 * 10**9), (2, 3 * 10**9))]
    again = {1: lambda raw: encode_string(f"{read_string(raw)}# again\n"), 2: lambda raw: raw}
    later = [
        (topic, stamp, again[number](raw) if topic == TWIN_SCENE else raw)
        for number, rows in runs
        for topic, stamp, raw in rows
        if not (number == 2 and topic == TWIN_SCENE)
    ]
    return write([*thin, *later], "three_0")


def test_each_run_of_a_bag_can_be_chosen(three, thin, write):
    alone, samples = summarise(write(thin, "alone_0")), {1: 600, 2: 400, 3: 300}
    each = {}
    for run, count in samples.items():
        recording = read_recording(three, None, Selection(run=run))
        found = each[run] = summarise(recording)
        assert (found["run"], found["runs"], found["samples"]) == (run, 3, count)
        assert len(recording.all_poses()) == len(recording.marks) == len(recording.rig) == len(recording.whirl) == count
    assert (alone["run"], alone["runs"]) == (1, 1)
    first = each[1]
    told = {
        "runs",
        "notes",
        "started",
        "wall",
        "severity_by_quantity",
        "bending_cycles_per_second",
    }  # of another length
    assert {key: first[key] for key in first.keys() - told} == {key: alone[key] for key in alone.keys() - told}
    assert summarise(three)["run"] == 3
    assert drill_twin.read_bag(three, run=2).time[-1] == 4.0
    with pytest.raises(BagError, match=r"--run: expected a run of .*three_0, 1 to 3, found 4"):
        read_recording(three, None, Selection(run=4))


def test_the_run_is_told_first(three, call):
    told = call("analyze", str(three)).out
    assert told.startswith("Run 3 of 3. ")
    assert "3 of 3 in the bag, the last; --run N chooses" in " ".join(told.split())
    assert "2 of 3 in the bag; --run N chooses" in " ".join(call("analyze", str(three), "--run", "2").out.split())


@pytest.fixture
def dated(messages, write):
    rows = []
    for topic, stamp, raw in messages:
        if topic in {MARKS_STATE, RIG_STATE, STRING_POSES}:
            raw = bytearray(raw)  # noqa: PLW2901
            pack_stamp(raw, 4, raw_header_stamp(bytes(raw)) + EPOCH)
        rows.append((topic, stamp + EPOCH, bytes(raw)))
    return write(rows, "dated_0")


def test_times_of_a_bag_with_dates_are_from_its_first_stamp(dated, known_bag, call, tmp_path):
    told = call("analyze", str(dated)).out
    assert "\ntimes " in told
    assert "in seconds from 2023-11-14 22:13:20.010 UTC" in " ".join(told.split())
    assert "17000" not in told
    found, known = summarise(dated), summarise(known_bag)
    assert found["onset_s"] == pytest.approx(known["onset_s"] - 0.01)
    assert found["start_utc"] == "2023-11-14 22:13:20.010"
    assert known["start_utc"] is None
    page = build_report(dated, tmp_path / "report").page.read_text("utf-8")
    assert not re.search(r"17000000\d\d(\.\d+)? s", page)
    # A part is chosen by time from the first stamp, or by date.
    parts = [(2.0, 5.0), (2.0 + (EPOCH + 10_000_000) / NANOSECONDS, 5.0 + (EPOCH + 10_000_000) / NANOSECONDS)]
    for begin, end in parts:
        marks = read_recording(dated, None, Selection(begin=begin, end=end)).marks
        assert marks.time[[0, -1]] == pytest.approx([2.0, 5.0], abs=0.011)
    copy = drill_twin.read_bag(dated).to_bag(tmp_path / "copy_0")
    assert list(Bag(copy).messages()) == list(Bag(dated).messages())
