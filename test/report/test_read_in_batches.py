# SPDX-License-Identifier: Apache-2.0
"""Messages that are read many at once give what they give one by one; odd ones among them are told as before."""

import numpy as np
import pytest
from summaries import summarise

from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.virtual_bags import MemoryBag
from drill_twin.io.messages import topics
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.rig_messages import read_rig_state
from drill_twin.report import selection
from drill_twin.report.recording import Recording

ODD = {
    "nothing": None,
    "a cut pose": (topics.STRING_POSES, 150, lambda raw: raw[:-9]),
    "no number in a pose": (topics.STRING_POSES, 150, lambda raw: raw[:-8] + np.array([np.nan]).tobytes()),
    "marks that are missing": (topics.MARKS_STATE, 150, lambda _: None),
    "marks out of order": (topics.MARKS_STATE, 150, lambda raw: raw[:8] + bytes(4) + raw[12:]),
    "a huge number": (topics.RIG_STATE, 150, lambda raw: raw[:-8] + np.array([1e16]).tobytes()),
    "a large speed": (topics.RIG_COMMAND, 150, lambda raw: raw[:-40]),
}
MARKLESS = {
    "nothing": None,
    "a huge number": ODD["a huge number"],
    "a state that is cut": (topics.RIG_STATE, 150, lambda raw: raw[:-8]),
    "a state out of order": (topics.RIG_STATE, 150, lambda raw: raw[:8] + bytes(4) + raw[12:]),
    "a speed beyond all reason": (topics.RIG_STATE, 150, lambda raw: swapped(raw, "top_drive_speed", 1e6)),
    "a speed that is none": (topics.RIG_STATE, 150, lambda raw: swapped(raw, "top_drive_speed", np.nan)),
}


def swapped(raw, field, value):
    """A `/rig/state` with another number in one field."""
    number = np.float64(getattr(read_rig_state(read_joint_state(raw)), field)).tobytes()
    assert raw.count(number) >= 1
    return raw.replace(number, np.float64(value).tobytes())


def without_marks(bag: Bag) -> MemoryBag:
    copy = MemoryBag()
    copy.write_all(one for one in bag.messages() if one[0] != topics.MARKS_STATE)
    return copy


def spoiled(bag: Bag, odd) -> MemoryBag:
    copy, seen = MemoryBag(), dict.fromkeys(bag.topics, 0)
    for topic, stamp, raw in bag.messages():
        seen[topic] += 1
        found = raw
        if odd is not None and (topic, seen[topic]) == odd[:2]:
            found = odd[2](raw)
        if found is not None:
            copy.write(topic, stamp, found)
    return copy


def content(bag: MemoryBag):
    read = Recording(bag)
    series = (read.marks, read.rig, read.commands, read.poses, read.whirl)
    columns = [(one.names, one.stamp.tobytes(), one.values.tobytes(), list(one.other_layouts())) for one in series]
    return columns, summarise(read), read.skipped.sentences(), read.unpaired


@pytest.mark.parametrize(
    ("marked", "odd"),
    [*((True, odd) for odd in ODD.values()), *((False, odd) for odd in MARKLESS.values())],
    ids=[*ODD, *(f"no marks, {name}" for name in MARKLESS)],
)
def test_batches_change_nothing(bench_run, monkeypatch, marked, odd):
    bag = Bag(bench_run.bag)
    bag = spoiled(bag if marked else without_marks(bag), odd)
    found = content(bag)
    monkeypatch.setattr(selection, "_FIRST_BATCH", 10**9)
    monkeypatch.setattr(Recording, "_read_batch", lambda *_: ())
    assert found == content(bag)
    for size in (7, 300):
        monkeypatch.undo()
        monkeypatch.setattr(selection, "_BATCH", size)
        assert found == content(bag)


def test_most_messages_are_taken_in_batches(bench_run, monkeypatch):
    one_by_one, take = [], Recording._read_message
    monkeypatch.setattr(Recording, "_read_message", lambda self, *one: (one_by_one.append(one[0]), take(self, *one)))
    Recording(Bag(bench_run.bag))
    assert one_by_one.count(topics.MARKS_STATE) < 30
    Recording(without_marks(Bag(bench_run.bag)))
    assert one_by_one.count(topics.RIG_STATE) < 300
