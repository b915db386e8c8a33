# SPDX-License-Identifier: Apache-2.0
"""One odd message on any topic of a bag: it is skipped and named, and the findings are those of the rest."""

import json
import math

import numpy as np
import pytest
from companion_parts import part
from summaries import summarise
from variants import one_of

import drill_twin as dt
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topic_row import DIAGNOSTIC_ARRAY, JOINT_STATE, POSE_ARRAY
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    TOPICS,
    TWIN_SCENE,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.report import build_report

PAGE, PLAYER = (part(f"drill_twin_dashboard.live.{name}") for name in ("page_state", "player"))

AT = 5_000_000_000
FUTURE = 1_900_000_000_000_000_000
READ = {MARKS_STATE, RIG_STATE, RIG_COMMAND, STRING_POSES, TWIN_SCENE, WHIRL_ONSET, DIAGNOSTICS}
"""Topics that the analysis reads and whose odd messages it names."""


def joints(stamp=AT, names=("bit",), value=40.0, **parts):
    return JointStateTemplate(names, **parts).fill(stamp, *[[value] * len(names)] * 3)


def poses(stamp=AT, nodes=3, value=0.0):
    return PoseArrayTemplate(nodes).fill(stamp, np.full((nodes, 3), value), np.full((nodes, 4), value))


def diagnostics(name="simulator", **values):
    return encode_diagnostics(AT, [Status(name, Level.OK, "odd", values)])


BY_TYPE = {
    JOINT_STATE: {
        "other names": joints(),
        "no names": joints(names=()),
        "infinite": joints(names=("top_drive", "bit", "block", "bit_axial"), value=math.inf),
        "huge": joints(names=("top_drive", "bit", "block", "bit_axial"), value=1e300),
        "no effort": joints(effort=False),
        "from the future": joints(FUTURE),
        "without a stamp": joints(0),
    },
    POSE_ARRAY: {
        "few": poses(),
        "none": poses(nodes=0),
        "not a number": poses(nodes=11, value=math.nan),
        "infinite": poses(nodes=11, value=math.inf),
        "from the future": poses(FUTURE, 11),
        "without a stamp": poses(0, 11),
    },
    DIAGNOSTIC_ARRAY: {
        "of a stranger": diagnostics("stranger"),
        "empty": encode_diagnostics(AT, []),
        "long counts": diagnostics(realtime_factor="9" * 5000, steps="9" * 5000, guard_interventions="9" * 5000),
        "odd onset": diagnostics("whirl: onset", time="soon", mark="m", confidence="9" * 5000),
    },
}
ANY = {
    "no bytes": b"",
    "short": b"\x00\x01\x00\x00\x01",
    "another type": encode_string("odd"),
    "noise": np.random.default_rng(15).bytes(400),
    "text": encode_string("run: {effects: 3, seed: 2024-99-99}\nx: " + "[" * 5000),
    "digits": encode_string("run: {seed: " + "9" * 5000 + "}"),
}
CASES = [
    (topic, kind, first)
    for topic, row in TOPICS.items()
    for kind in (*ANY, *BY_TYPE.get(row.type_name, ()))
    for first in (
        (False, True) if topic in READ and kind in {"other names", "few", "from the future", "text"} else (False,)
    )
    if topic in READ or kind == "noise"
]


@pytest.fixture(scope="module")
def good(messages):
    """Six seconds, every second sample."""
    return [row for row in messages[:1801] if row[1] % 20_000_000 == 0]


@pytest.fixture(scope="module")
def expected(good, tmp_path_factory):
    return summarise(record(tmp_path_factory.mktemp("good") / "run_0", good))


def record(folder, rows):
    with BagWriter(folder) as bag:
        for row in rows:
            bag.write(*row)
    return folder


def odd_bag(folder, good, topic, kind, first):
    raw = (ANY | BY_TYPE.get(TOPICS[topic].type_name, {}))[kind]
    place = 1 if first else next(k for k, row in enumerate(good) if row[1] >= AT)
    return record(folder, [*good[:place], (topic, good[place][1], raw), *good[place:]])


@pytest.mark.parametrize(("topic", "kind", "first"), one_of(3, CASES))
def test_one_odd_message(topic, kind, first, good, expected, tmp_path):
    folder = odd_bag(tmp_path / "run_0", good, topic, kind, first)
    found = dt.read_bag(folder).summary
    json.dumps(found, allow_nan=False)
    for key in ("onset_s", "onset_mark", "whirl_ratio", "max_radius_m", "duration_s", "elements", "version"):
        assert found[key] == expected[key], (key, found["notes"])
    assert found["samples"] >= expected["samples"] - 1
    if topic in READ and kind in {"no bytes", "short", "noise"}:
        assert any(topic in note for note in found["notes"]), found["notes"]
    assert all(len(note) < 1000 and note.isprintable() for note in found["notes"])


@pytest.mark.slow
@pytest.mark.parametrize("topic", one_of(3, sorted(set(PAGE.INPUTS if PAGE else ()) & set(TOPICS))))
def test_the_page_plays_on(topic, good, tmp_path):
    good = [row for row in good if row[1] % 100_000_000 == 0]  # a page draws ten a second
    for kind in (*ANY, *BY_TYPE.get(TOPICS[topic].type_name, ())):
        bag = Bag(odd_bag(tmp_path / kind, good, topic, kind, first=False))
        messages, page = list(PLAYER.in_simulated_time(bag.messages(PAGE.INPUTS))), PAGE.PageState()
        for name, _, raw in messages:
            page.update(name, raw)
        json.dumps(page.snapshot(), allow_nan=False)
        assert messages[-1][1] <= good[-1][1], kind
        assert kind not in {"no bytes", "short", "noise"} or topic in page.skipped, kind


def test_report_of_many_odd_messages(good, tmp_path):
    rows = list(good)
    for topic in TOPICS:
        for raw in (ANY | BY_TYPE.get(TOPICS[topic].type_name, {})).values():
            rows.insert(len(rows) // 2, (topic, AT, raw))
    files = build_report(record(tmp_path / "run_0", rows), tmp_path / "report")
    summary = json.loads(files.summary.read_text("utf-8"))
    assert {topic for topic in READ if any(topic in note for note in summary["notes"])} == READ
    assert summary["onset_s"] is not None


def test_a_topic_of_another_type_is_left_out(good, expected, tmp_path):
    from dataclasses import replace

    from drill_twin.io.bag.metadata import contract_topic

    topics = [contract_topic(name) for name in TOPICS if name != WHIRL_STATE]
    topics.append(replace(contract_topic(TWIN_SCENE), name=WHIRL_STATE))
    with BagWriter(tmp_path / "run_0", topics=topics) as bag:
        for row in [*good, (WHIRL_STATE, AT, encode_string("odd"))]:
            bag.write(*row)
    found = summarise(tmp_path / "run_0")
    assert found["onset_s"] == expected["onset_s"]
    assert "expected /whirl/state as sensor_msgs/msg/JointState, found std_msgs/msg/String" in found["damage"][0]
