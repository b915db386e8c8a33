# SPDX-License-Identifier: Apache-2.0
"""Parts of a bag, bags of other recorders, and bags without marks are analysed, or refused with a reason."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from summaries import summarise

from drill_twin.core.errors import BagError
from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TWIN_SCENE, WHIRL_STATE
from drill_twin.report import build_report
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection

RPM = 2.0 * math.pi / 60.0


def chosen(path, **how):
    return summarise(read_recording(path, selection=Selection(**how)))


def rig_rows(time, top, bit):
    """`/rig/state` of a record, speeds in [rad/s]."""
    template = JointStateTemplate(RIG_JOINTS)
    zero = (0.0, 0.0, 0.0, 0.0)
    stamps = np.round(time * 1e9).astype(int).tolist()
    for stamp, one, other in zip(stamps, top.tolist(), bit.tolist(), strict=True):
        yield RIG_STATE, stamp, template.fill(stamp, zero, (one, other, 0.0, other), zero)


def sticking(time, period=0.4, mean=9.0):
    """A bit that stands still once in a period."""
    return np.maximum(mean * (1.0 + 1.3 * np.sin(2.0 * np.pi * time / period)), 0.0)


# --- parts


def test_marks_can_be_chosen(known_bag):
    whole, part = summarise(known_bag), chosen(known_bag, marks=("mark_3", "mark_1"))
    assert list(part["mark_motion"]) == ["mark_1", "mark_3"]
    assert part["max_radius_m"]["mark_3"] == whole["max_radius_m"]["mark_3"]
    assert part["onset_s"] == pytest.approx(whole["onset_s"], abs=0.01)


def test_mark_that_is_not_there_is_named(known_bag):
    with pytest.raises(BagError, match="expected marks of mark_1, mark_2, mark_3, mark_4, found mark_9"):
        chosen(known_bag, marks=("mark_9",))


def test_time_can_be_chosen(known_bag):
    part = chosen(known_bag, begin=5.0, end=9.0)
    assert part["samples"] == 401
    assert part["motion"][0]["start_s"] == pytest.approx(5.0, abs=0.05)
    assert part["duration_s"] == 9.0
    assert part["onset_at_start"]
    assert not chosen(known_bag)["onset_at_start"]
    before = chosen(known_bag, end=2.9)
    assert before["onset_s"] is None


def test_part_is_not_compared_with_what_was_found_live(bench_run):
    part = chosen(bench_run.bag, begin=1.0)
    assert part["live"]["messages"] == part["live"]["differing"] == 0


def test_empty_part_is_an_error(known_bag):
    with pytest.raises(BagError, match="expected marks and rig states"):
        chosen(known_bag, begin=100.0)


# --- bags of other recorders


@pytest.fixture
def foreign(messages):
    """The known motion as recorded by a camera and a drive of another rig: no scene, x and y alone."""
    camera = JointStateTemplate(["lower/x", "lower/y"], velocity=False, effort=False)
    drive = JointStateTemplate(["top_drive"], effort=False)
    rows = []
    for topic, stamp, raw in messages:
        if topic == MARKS_STATE:
            rows.append((MARKS_STATE, stamp, camera.fill(stamp, read_joint_state(raw).position[8:10])))
        elif topic == RIG_STATE:
            rows.append((RIG_STATE, stamp, drive.fill(stamp, (0.0,), (4.0 * math.pi,))))
    return rows


def test_bag_without_a_scene_needs_the_clearance(foreign, write):
    bag = write(foreign)
    with pytest.raises(BagError, match=r"expected the scene .* --scene, or give --clearance"):
        summarise(bag)
    found = chosen(bag, clearance=0.08175, outer_radius=0.00825)
    assert found["scene"] is None
    assert found["onset_s"] == pytest.approx(3.1, abs=0.3)
    assert found["whirl_ratio"] == pytest.approx(-0.3, abs=0.02)
    assert list(found["max_radius_m"]) == ["lower"]
    json.dumps(found, allow_nan=False)


def test_topics_can_be_mapped(messages, write):
    """`/rig/state` under another of our names stands for a bag whose topics are called otherwise."""
    moved = [(WHIRL_STATE if topic == MARKS_STATE else topic, stamp, raw) for topic, stamp, raw in messages]
    bag = write(moved)
    assert not summarise(bag)["whirl_observable"]
    found = chosen(bag, topics={WHIRL_STATE: MARKS_STATE})
    assert found["whirl_observable"]
    assert found["whirl_ratio"] == pytest.approx(-0.3, abs=0.01)


def test_mapped_topic_that_is_not_there(known_bag):
    with pytest.raises(BagError, match="expected the topic /their/marks to read as /marks/state, found /"):
        chosen(known_bag, topics={"/their/marks": MARKS_STATE})


def test_mapped_onto_one_that_is_there(known_bag):
    with pytest.raises(BagError, match="expected no topic /marks/state beside /rig/state"):
        chosen(known_bag, topics={RIG_STATE: MARKS_STATE})


def test_neither_rig_states_nor_spin(foreign, write):
    bag = write([row for row in foreign if row[0] != RIG_STATE])
    with pytest.raises(BagError, match=r"expected the rotation, .* found neither"):
        chosen(bag, clearance=0.08175, outer_radius=0.00825)


def test_marks_alone_are_drawn(messages, write, tmp_path):
    """No rig states, no poses, no diagnostics: the rotation is that of the marks."""
    recording = read_recording(write([row for row in messages if row[0] in {TWIN_SCENE, MARKS_STATE}]))
    assert recording.rotation_from_spin
    assert build_report(recording, tmp_path / "report").page.exists()
    assert recording.summary.whirl_ratio == pytest.approx(-0.3, abs=0.01)


def test_marks_without_a_scene_are_drawn_without_the_hole(messages, write, tmp_path):
    """The clearance is given; orbits and shapes need the hole of a scene."""
    bag = write([row for row in messages if row[0] != TWIN_SCENE])
    recording = read_recording(bag, selection=Selection(clearance=0.08175, outer_radius=0.00825))
    files = build_report(recording, tmp_path / "report")
    assert "displacement" in files.figures
    assert not {"orbits", "string_shapes", "well"} & files.figures.keys()
    assert "no scene" in files.page.read_text("utf-8")


# --- no marks


def test_without_marks_whirl_is_not_observable_and_stick_slip_is_found(messages, write):
    time = np.arange(0.0, 12.0, 0.005)
    rows = [row for row in messages if row[0] == TWIN_SCENE]
    rows += rig_rows(time, np.full(time.size, 9.0), np.where(time > 4.0, sticking(time), 9.0))
    found = summarise(write(rows))
    assert found["whirl_observable"] is False
    assert found["onset_s"] is found["whirl_frequency_hz"] is None
    assert found["motion"] == []
    assert any("whirl is not observable" in note for note in found["notes"])
    assert found["bit"] == "stick-slip"
    stretch = found["stick_slip"][0]
    assert stretch["start_s"] == pytest.approx(4.2, abs=0.4)
    assert stretch["period_s"] == pytest.approx(0.4, rel=0.01)
    assert found["bit_spectral_peak_hz"] == pytest.approx(2.5, rel=0.03)
    json.dumps(found, allow_nan=False)


def record():
    """The lab record, where it is there: DRILL_TWIN_DATA names the folder it is in."""
    folder = os.environ.get("DRILL_TWIN_DATA")
    if not folder:
        pytest.skip("DRILL_TWIN_DATA does not name the folder that 175_completo_1.mat is in")
    found = [path for path in (Path(folder), Path(folder) / "ufrj_rig") if (path / "175_completo_1.mat").exists()]
    if not found:
        pytest.skip(f"175_completo_1.mat is not in {folder}")
    from scipy.io import loadmat

    data = loadmat(found[0] / "175_completo_1.mat")
    return [data[f"{name}_Sample_175_complete"].ravel() for name in ("Time", "Top_Speed", "Bit_Speed")]


def test_lab_record_shows_stick_slip_and_no_whirl(write):
    time, top, bit = record()
    bag = write(list(rig_rows(time[::2], top[::2] * RPM, bit[::2] * RPM)))
    found = chosen(bag, begin=37.0, end=41.0)
    assert found["whirl_observable"] is False
    assert found["onset_s"] is None
    assert found["bit"] == "stick-slip"
    stretch = found["stick_slip"][0]
    assert len(found["stick_slip"]) == 1
    assert stretch["cycles"] >= 9
    assert 0.32 <= stretch["shortest_s"] <= stretch["longest_s"] <= 0.43
    assert found["bit_spectral_peak_hz"] == pytest.approx(2.73, abs=0.05)
    whole = summarise(bag)
    assert whole["bit_spectral_peak_hz"] == pytest.approx(2.69, abs=0.05)
    assert sum(stretch["cycles"] for stretch in whole["stick_slip"]) > 90
