# SPDX-License-Identifier: Apache-2.0
"""The summary is valid JSON and states what is known of a bag and what is missing."""

import json
import math
import shutil

import numpy as np
import pytest
from summaries import summarise

from drill_twin.api.scenes import override
from drill_twin.core.errors import BagError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.encode import MARK_AXES, encode_string
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES, TWIN_SCENE, WHIRL_STATE
from drill_twin.report.quantities import settled_from
from drill_twin.report.recording import read_recording
from drill_twin.report.summary import timeline
from drill_twin.report.text import findings, provenance
from drill_twin.runs import Session
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Schedule
from drill_twin.whirl import MotionPeriod, MotionState

KEYS = {
    "onset_s", "whirl_frequency_hz", "whirl_ratio", "max_radius_m", "realtime_factor", "physics_speed",
    "elements", "step_s",
    "effects", "seed", "version", "onset_mark", "motion", "mark_motion", "duration_s", "samples", "truncated", "notes",
}  # fmt: skip


@pytest.fixture(scope="module")
def summary(known_bag):
    return summarise(known_bag)


def test_holds_the_promised_keys(summary):
    assert set(summary) >= KEYS


def test_hookload_torque_and_drag_of_a_run(bench_run):
    """Before contact the string's weight is carried by hook and bit alone, so friction stays a small share of it."""
    recording = read_recording(bench_run.bag)
    rig, whole = recording.rig, summarise(recording)
    found, late = whole["loads"], rig.time >= whole["settled_s"]
    assert whole["settled_s"] == pytest.approx(rig.time[[0, -1]].mean())
    for key, series in (
        ("hookload_n", rig.hookload), ("weight_on_bit_n", rig.bit_force),
        ("top_drive_torque_nm", rig.top_drive_torque), ("bit_torque_nm", rig.bit_torque),
    ):  # fmt: skip
        assert found[key] == {"mean": series[late].mean(), "min": series.min(), "max": series.max()}
    weight = sum(s.mass_per_length * s.length for s in recording.scene.string.sections) * 9.81
    assert found["drag_n"]["mean"] == pytest.approx(np.mean((rig.hookload + rig.bit_force)[late]) - weight, abs=1e-6)
    assert abs(found["drag_n"]["mean"]) < 0.2 * weight
    rows = dict(findings(whole))
    assert {"hookload", "drag", "torque of the top drive", "torque on the bit"} <= set(rows)
    assert rows["hookload"].endswith(" N in all")


@pytest.mark.parametrize(("ramp", "settled"), [(1.0, 1.505), (2.0, 2.0), (2.5, 1.505)])
def test_means_begin_after_the_ramps_where_a_quarter_follows(bench_run, bench_scene, ramp, settled):
    changes = {"rig.weight_on_bit.duration": ramp, "rig.rotation.duration": 0.5}
    assert settled_from(read_recording(bench_run.bag, override(bench_scene, changes))) == pytest.approx(settled)


SOFT = {
    "wob": "20 N", "rpm": "120", "rig.weight_on_bit.duration": "1 s", "rig.rotation.duration": "0.5 s",
    "duration": "5 s", "effects.wall.stiffness": "1e3 N/m^2.5",
}  # fmt: skip
"""A wall as soft as foam: the string sinks in by centimetres."""


def test_depth_in_a_soft_wall_beside_that_at_rest(tmp_path):
    """The largest of all frames, to the sampling of the poses; at rest (q / K)^(2/3) of a helix and the weight."""
    scene = load_scene("pa6_bench", overrides=SOFT)
    found = summarise(Session(scene).run(tmp_path / "bag_0").bag)
    twin, schedule, period = Twin(scene), Schedule.from_scene(scene), 1.0 / scene.numerics.frame_rate
    deepest = max(
        twin.advance(schedule.at((k + 1) * period), period).wall_depth
        for k in range(round(scene.rig.duration / period))
    )
    wall = found["wall"]
    assert wall["deepest_m"] == pytest.approx(deepest, rel=0.05)
    section = scene.string.sections[0]
    weight = section.mass_per_length * 9.81 * scene.length
    clearance, bending = scene.clearance_at(0.0), section.youngs_modulus * np.pi * section.outer_diameter**4 / 64.0
    load = max(abs(scene.rig.weight_on_bit.value), abs(scene.rig.weight_on_bit.initial))
    pressed = (load + weight) ** 2 * clearance / (4.0 * bending) + section.mass_per_length * 9.81
    assert wall["static_m"] == pytest.approx((pressed / 1e3) ** (2.0 / 3.0), rel=1e-6)
    assert wall["clearance_m"] == pytest.approx(clearance)
    assert "of the clearance" in dict(findings(found))["depth into the wall"]
    assert any(note.startswith("the wall is soft") for note in found["notes"]) == (deepest > 0.1 * clearance)
    assert deepest > 0.1 * clearance


def test_no_onset_is_not_said_of_too_few_samples_nor_of_what_a_sub_cannot_see(summary):
    def onset(rate, sub):
        quality = {**summary["quality"], "samples_per_revolution": rate}
        return dict(findings({**summary, "onset_s": None, "quality": quality, "sub": sub}))["onset of whirl"]

    sub = {"slowest_hz": 0.12, "share_at_rest": None, "largest_impact": None, "impacts": 0}
    assert onset(50.0, None) == "none found"
    assert onset(50.0, sub) == "none found; a whirl slower than 0.12 Hz shows in no reading"
    assert onset(3.14, None) == "not observable: 3.1 samples in a revolution, 4 are needed"


def test_without_contact_no_depth_is_told(summary):
    assert summary["wall"]["deepest_m"] == 0.0
    assert "depth into the wall" not in dict(findings(summary))
    assert not any("soft" in note for note in summary["notes"])


def test_is_plain_json_and_comes_back_equal(summary):
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_finds_what_was_put_into_the_bag(summary):
    assert 3.0 < summary["onset_s"] < 3.4
    assert summary["whirl_frequency_hz"] == pytest.approx(-0.6, abs=0.02)
    assert summary["whirl_ratio"] == pytest.approx(-0.3, abs=0.01)
    assert summary["rotation_rev_s"] == pytest.approx(2.0, rel=1e-3)
    assert set(summary["max_radius_m"]) == {"mark_1", "mark_2", "mark_3", "mark_4"}
    assert list(summary["max_radius_m"].values()) == pytest.approx([0.031] * 4, rel=0.02)
    assert summary["motion"][-1]["state"] == "backward whirl"
    assert summary["motion"][-1]["end_s"] == summary["duration_s"] == 12.0
    assert summary["samples"] == 1200
    assert not summary["truncated"]


def test_says_what_was_run(summary):
    assert (summary["version"], summary["seed"], summary["elements"], summary["step_s"]) == ("9.9.9", 7, 10, 0.002)
    assert summary["effects"] == ["gravity", "wall"]
    assert summary["pace"] == "realtime"
    assert (summary["realtime_factor"], summary["physics_speed"]) == (0.998, 12.5)
    assert (summary["steps"], summary["cut_steps"], summary["steps_above_tolerance"]) == (6000, 21, 7)
    assert dict(provenance(summary))["steps"] == "6000, halved 21 times, 7 above the tolerance"
    assert summary["live"] == {"onset_s": None, "messages": 0, "differing": 0}


def test_real_run_agrees_with_what_was_found_live(bench_run):
    found = summarise(bench_run.bag)
    assert found["onset_s"] == bench_run.summary.onset_s
    assert found["live"]["onset_s"] == pytest.approx(found["onset_s"], abs=1e-9)
    assert found["whirl_frequency_hz"] == bench_run.summary.whirl_frequency_hz
    assert found["live"]["messages"] == 300
    assert found["live"]["differing"] == 0
    assert found["realtime_factor"] > 0.0
    assert found["steps"] >= 300
    assert 0 <= found["steps_above_tolerance"] <= found["steps"]
    assert [note for note in found["notes"] if "no whirl frequency" not in note] == []


def test_live_findings_that_differ_are_noticed(bench_run, write):
    rows = list(Bag(bench_run.bag).messages())
    changed = [k for k, (topic, _, _) in enumerate(rows) if topic == WHIRL_STATE][250]
    topic, stamp, raw = rows[changed]
    rows[changed] = topic, stamp, raw[:-16] + b"\x01" * 8 + raw[-8:]
    found = summarise(write(rows))
    assert found["live"]["differing"] == 1
    assert any("1 of 300 findings recorded live differ" in note for note in found["notes"])


def test_opens_the_folder_of_a_run(bench_run):
    assert summarise(bench_run.bag.parent)["samples"] == 300


def test_bag_of_a_killed_recorder_is_read_as_far_as_it_goes(bench_run, tmp_path):
    whole = next(bench_run.bag.glob("*.mcap")).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(0.7 * len(whole))])
    found = summarise(cut)
    assert found["truncated"]
    assert found["damage"]
    assert 0 < found["samples"] < 300
    assert found["duration_s"] == pytest.approx(found["samples"] / 100)
    json.dumps(found, allow_nan=False)


def test_whirl_that_never_comes_is_none_not_nan(messages, write):
    before = [row for row in messages if row[1] <= 2_500_000_000]
    found = summarise(write(before))
    assert found["onset_s"] is found["onset_mark"] is found["whirl_frequency_hz"] is found["whirl_ratio"] is None
    assert [period["state"] for period in found["motion"]][-1] == "rotation about a fixed axis"
    assert found["realtime_factor"] is found["steps"] is found["steps_above_tolerance"] is None
    json.dumps(found, allow_nan=False)


def test_single_sample_is_enough_for_json(messages, write):
    found = summarise(write(messages[:4]))
    assert found["samples"] == 1
    json.dumps(found, allow_nan=False)


def test_marks_that_are_not_numbers_are_counted(messages, known_scene, write):
    names = [f"{place.name}/{axis}" for place in known_scene.mark_table for axis in MARK_AXES]
    template = JointStateTemplate(names)
    nan = [math.nan] * len(names)
    rows = [
        (topic, stamp, template.fill(stamp, nan, nan, nan))
        if topic == MARKS_STATE and 500_000_000 < stamp <= 600_000_000
        else (topic, stamp, raw)
        for topic, stamp, raw in messages
    ]
    found = summarise(write(rows))
    assert found["samples"] == 1190
    assert found["quality"]["incomplete"] == 10
    assert 3.0 < found["onset_s"] < 3.4
    json.dumps(found, allow_nan=False)


def test_last_of_several_runs_counts_and_is_said(messages, write):
    scene = next(raw for topic, _, raw in messages if topic == TWIN_SCENE)
    second = [(TWIN_SCENE, 0, encode_string("# again\n" + read_text(scene)))]
    second += [row for row in messages[1:] if row[1] <= 2_000_000_000]
    found = summarise(write([*messages, *second]))
    assert found["samples"] == 200
    assert found["onset_s"] is None
    assert (found["run"], found["runs"]) == (2, 2)


def read_text(raw: bytes) -> str:
    from drill_twin.io.messages.decode import read_string

    return read_string(raw)


def test_samples_without_partners_are_said(messages, write):
    rows = [row for row in messages if not (row[0] == RIG_STATE and row[1] > 6_000_000_000)]
    found = summarise(write(rows))
    assert found["samples"] == 600
    assert any("states of the marks or the rig have no partner" in note for note in found["notes"])


@pytest.mark.parametrize(
    ("left_out", "message"),
    [
        ({TWIN_SCENE}, r"expected the scene on /twin/scene, found no message there; name the scene with --scene"),
        ({MARKS_STATE, RIG_STATE}, r"expected marks and rig states .* found 0 on /marks/state, 0 on /rig/state"),
    ],
)
def test_bag_without_what_the_analysis_needs(messages, write, left_out, message):
    with pytest.raises(BagError, match=message):
        summarise(write([row for row in messages if row[0] not in left_out]))


def test_without_rig_states_the_rotation_comes_from_the_spin(messages, write, summary):
    found = summarise(write([row for row in messages if row[0] != RIG_STATE]))
    assert found["onset_s"] == pytest.approx(summary["onset_s"], abs=0.02)
    assert found["rotation_rev_s"] == pytest.approx(2.0, rel=1e-3)
    assert any("taken from the spin" in note for note in found["notes"])
    assert found["bit"] == "not observable"


def test_scene_can_be_named(messages, write, known_scene):
    folder = write([row for row in messages if row[0] != TWIN_SCENE])
    found = summarise(read_recording(folder, known_scene))
    assert 3.0 < found["onset_s"] < 3.4
    assert found["version"] is None
    assert found["elements"] == 10  # seen in the poses


def test_broken_scene_is_named(messages, write):
    rows = [(TWIN_SCENE, 0, encode_string("name: [")), *messages[1:]]
    with pytest.raises(BagError, match="found a scene that cannot be used: /twin/scene"):
        summarise(write(rows))


def test_bag_that_is_none(tmp_path):
    (tmp_path / "run").mkdir()
    with pytest.raises(BagError, match="found nothing in it"):
        summarise(tmp_path / "run")


def test_copied_bag_gives_the_same(known_bag, summary, tmp_path):
    shutil.copytree(known_bag, tmp_path / "copy_0")
    assert summarise(tmp_path / "copy_0") == summary


def test_poses_are_not_needed(messages, write):
    found = summarise(write([row for row in messages if row[0] != STRING_POSES]))
    assert 3.0 < found["onset_s"] < 3.4


def test_timeline_leaves_out_what_has_no_length_and_joins_the_rest():
    period = MotionPeriod
    fixed, whirl = MotionState.FIXED_AXIS, MotionState.FORWARD_WHIRL
    periods = (period(0.1, fixed, "a"), period(2.0, whirl, "b"), period(2.0, fixed, "c"), period(3.0, whirl, "d"))
    assert [(line["start_s"], line["end_s"], line["criterion"]) for line in timeline(periods, 5.0)] == [
        (0.1, 3.0, "a"),
        (3.0, 5.0, "d"),
    ]
