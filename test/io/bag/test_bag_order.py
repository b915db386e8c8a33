# SPDX-License-Identifier: Apache-2.0
"""MCAP files whose messages are not in order of time: read as other readers do, in order, within bounded memory."""

from itertools import pairwise

import numpy as np
import pytest
from mcap.writer import IndexType
from mcap.writer import Writer as McapWriter
from summaries import summarise

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.reading import mcap_file, mcap_records
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TOPICS, TWIN_SCENE
from drill_twin.report.recording import read_recording

FOUR = (0.0, 0.0, 0.0, 0.0)
COUNT = 2000
SORTED = "is not in order of the time of recording: its messages are sorted"


def write(file, rows, chunk_size=4096, **options):
    """A file of these messages, in this order."""
    with file.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=chunk_size, **options)
        writer.start("ros2")
        kinds = {
            name: writer.register_schema(TOPICS[name].type_name, "ros2msg", b"")
            for name in sorted({r[0] for r in rows})
        }
        channels = {name: writer.register_channel(name, "cdr", kind) for name, kind in kinds.items()}
        for topic, stamp, raw in rows:
            writer.add_message(channels[topic], stamp, raw, stamp)
        writer.finish()
    return file


@pytest.fixture(scope="module")
def rows():
    """20 s of rig states and marks with the same stamps."""
    template, random = JointStateTemplate(RIG_JOINTS), np.random.default_rng(1)
    return [
        (topic, k * 10_000_000, bytes(template.fill(k * 10_000_000, random.random(4), FOUR, FOUR)))
        for k in range(COUNT // 2)
        for topic in (RIG_STATE, MARKS_STATE)
    ]


def stamp(row):
    return row[1]


def swapped(rows):
    half = len(rows) // 2
    return rows[half:] + rows[:half]


def backwards_in_chunks(rows):
    return [row for k in range(0, len(rows), 8) for row in rows[k : k + 8][::-1]]


def woven(rows):
    """Chunks of the first half and of the second in turns, two at a time."""
    half = len(rows) // 2
    return [row for k in range(0, half, 40) for row in rows[k : k + 40] + rows[half + k : half + k + 40]]


def topic_by_topic(rows):
    return [row for name in (MARKS_STATE, RIG_STATE) for row in rows if row[0] == name]


def shuffled(rows):
    return [rows[k] for k in np.random.default_rng(2).permutation(len(rows))]


ORDERS = (swapped, backwards_in_chunks, woven, topic_by_topic, shuffled)
KINDS = {
    "chunks": {},
    "large chunks": {"chunk_size": 1 << 20},
    "no chunks": {"use_chunking": False},
    "no index": {"index_types": IndexType.NONE, "use_summary_offsets": False, "use_statistics": False},
}


@pytest.mark.parametrize("options", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("order", ORDERS)
def test_messages_come_in_order_of_time_and_messages_of_one_time_in_the_order_of_the_file(
    tmp_path, rows, order, options, monkeypatch
):
    monkeypatch.setattr(mcap_file, "_GROUP", 1 << 13)
    told = order(rows)
    bag = Bag(write(tmp_path / "run.mcap", told, **options))
    assert list(bag.messages()) == sorted(told, key=stamp)
    assert list(bag.messages((RIG_STATE,))) == sorted((row for row in told if row[0] == RIG_STATE), key=stamp)
    assert (bag.start, bag.end, bag.message_count) == (rows[0][1], rows[-1][1], len(rows))
    assert not bag.truncated
    assert bag.notes == ([] if order is backwards_in_chunks else [f"run.mcap {SORTED}"])


@pytest.mark.parametrize("options", [{}, {"use_chunking": False}], ids=["chunks", "no chunks"])
def test_a_file_in_order_is_read_as_it_stands(tmp_path, rows, options, monkeypatch):
    monkeypatch.setattr(mcap_file, "merge", None)
    bag = Bag(write(tmp_path / "run.mcap", rows, **options))
    assert list(bag.messages()) == rows
    assert not bag.notes


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("options", [{}, {"use_chunking": False}], ids=["chunks", "no chunks"])
def test_what_a_torn_file_has_comes_in_order(tmp_path, rows, order, options):
    told = order(rows)
    whole = write(tmp_path / "whole.mcap", told, **options).read_bytes()
    file = tmp_path / "torn.mcap"
    for share in (0.3, 0.7):
        file.write_bytes(whole[: int(share * len(whole))])
        bag = Bag(file)
        found = list(bag.messages())
        assert found == sorted(told[: len(found)], key=stamp)
        assert 0.1 * len(rows) < len(found) == bag.message_count < 0.9 * len(rows)
        assert bag.truncated


def test_a_damaged_chunk_leaves_the_order(tmp_path, rows):
    file = write(tmp_path / "run.mcap", woven(rows))
    data = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        place, end = mcap_records.read_index(stream).chunks[40][2]
    data[(place + end) // 2] ^= 1
    file.write_bytes(data)
    bag = Bag(file)
    found = list(bag.messages())
    assert len(found) < len(rows)
    assert set(found) < set(rows)
    assert all(a[1] <= b[1] for a, b in pairwise(found))
    assert len(bag.damage) == 1
    assert "damaged chunk" in bag.damage[0]


def test_a_chunk_is_read_when_its_first_message_is_due(tmp_path, rows, monkeypatch):
    """Of chunks that do not overlap one is in memory at a time."""
    monkeypatch.setattr(mcap_file, "_GROUP", 1 << 12)
    bag = Bag(write(tmp_path / "run.mcap", swapped(rows)))
    sizes, real = [], mcap_records.decompressed

    def counted(*arguments):
        sizes.append(arguments[2])
        return real(*arguments)

    monkeypatch.setattr(mcap_records, "decompressed", counted)
    for k, _ in enumerate(bag.messages()):
        if k == 100:
            assert sum(sizes) < 0.2 * sum(len(raw) for *_, raw in rows)
    assert sum(sizes) < 1.2 * sum(len(raw) + 31 for *_, raw in rows)


def test_where_too_many_chunks_overlap_the_order_is_that_of_the_file_and_this_is_told(tmp_path, rows, monkeypatch):
    told = shuffled(rows)
    file = write(tmp_path / "run.mcap", told)
    monkeypatch.setattr(mcap_file, "LARGEST_CHUNK", 400_000)
    monkeypatch.setattr(mcap_file, "_GROUP", 1 << 12)
    bag = Bag(file)
    assert list(bag.messages()) == told
    assert "read as they lie: there are several runs, or too many overlap in time" in bag.notes[0]
    assert list(Bag(write(file, swapped(rows))).messages()) == rows  # of which few overlap


@pytest.mark.parametrize("order", [swapped, woven, topic_by_topic])
def test_a_window_of_such_a_file_has_the_same_messages(tmp_path, rows, order):
    file = write(tmp_path / "run.mcap", order(rows))
    bag = Bag(file, window=(3.0, 4.0))
    found = list(bag.messages())
    assert all(a[1] <= b[1] for a, b in pairwise(found))
    assert {row for row in rows if 3.0 <= row[1] * 1e-9 <= 4.0} <= set(found)
    assert (bag.message_count, bag.end) == (len(rows), rows[-1][1])
    if order is swapped:
        assert len(found) < 0.5 * len(rows)


def test_findings_are_those_of_the_file_in_order(tmp_path, bench_run):
    told = list(Bag(bench_run.bag).messages())
    half = len(told) // 2
    unsorted = [*told[:20], *told[half:], *told[20:half]]
    assert unsorted[0][0] == TWIN_SCENE
    a, b = (
        summarise(read_recording(write(tmp_path / name, part, chunk_size=100_000)))
        for name, part in (("sorted.mcap", told), ("unsorted.mcap", unsorted))
    )
    assert b.pop("notes") == [f"unsorted.mcap {SORTED}", *a.pop("notes")]
    assert a["onset_s"] is not None
    assert a == b


def test_several_runs_that_begin_at_the_same_time_are_not_woven(tmp_path, messages):
    """Times of a recording by simulated time begin again; each run has a scene."""
    run = [(topic, 100 * stamp, raw) for topic, stamp, raw in messages]
    told = [*run, *run]
    bag = Bag(write(tmp_path / "run.mcap", told))
    assert list(bag.messages()) == told
    assert "read as they lie: there are several runs" in bag.notes[0]
