# SPDX-License-Identifier: Apache-2.0
"""One path from topics to findings: the same for any order of arrival, and no message can bring it down."""

import math
import random

import numpy as np
import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.severity import DEFAULT, Grade, worst
from drill_twin.io.bag.reader import Bag
from drill_twin.io.findings_encoder import FindingsEncoder, TwinSummary
from drill_twin.io.messages.decode import read_joint_state, read_string
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.stamps import pack_stamp, seconds
from drill_twin.io.messages.topics import (
    MARKS_STATE,
    RIG_STATE,
    TWIN_SCENE,
    TWIN_SUMMARY,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.messages.whirl_encode import decode_motion, decode_onset
from drill_twin.io.samples import STUCK, UNKNOWN_RIG, WAITING, RigSample
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.report.recording import read_recording
from drill_twin.whirl import AnalysisError, BitMotion, MarkInfo, MotionCode, MotionState, StickSlipCode
from drill_twin.whirl.severity import WINDOW, accelerations, sizes

INPUTS = (TWIN_SCENE, MARKS_STATE, RIG_STATE)
"""Topics that the analysis needs."""

FOUND = (WHIRL_STATE, WHIRL_MOTION, WHIRL_ONSET, TWIN_SUMMARY)


@pytest.fixture(scope="module")
def inputs(bench_run):
    return [(topic, raw) for topic, _, raw in Bag(bench_run.bag).messages(INPUTS)]


@pytest.fixture(scope="module")
def live(bench_run):
    return without_factor((topic, raw) for topic, _, raw in Bag(bench_run.bag).messages(FOUND))


def fed(messages, pipeline=None):
    pipeline = pipeline or WhirlPipeline()
    return pipeline, without_factor(found for topic, raw in messages for found in pipeline.analyse(topic, raw))


def without_factor(found):
    """Findings without the real-time factor, which tells wall time: the last number of a `/twin/summary`."""
    return [(topic, raw[:-16] + raw[-8:] if topic == TWIN_SUMMARY else raw) for topic, raw in found]


def test_the_summary_has_what_a_dashboard_wants_without_nan(bench_run):
    states = [read_joint_state(raw) for _, _, raw in Bag(bench_run.bag).messages((TWIN_SUMMARY,))]
    assert [state.stamp // 10_000_000 for state in states] == [1, *range(20, 301, 20)]
    assert {state.names for state in states} == {
        ("rate_of_penetration", "weight_on_bit", "rotation",
         *(f"{size}/mark_{mark}" for mark in (1, 2, 3, 4) for size in ("lateral_rms", "lateral_peak")),
         "whirl", "stick_slip", "stick_slip_severity", "severity", "lateral_severity", "onset", "realtime_factor")
    }  # fmt: skip
    assert np.isfinite([state.position for state in states]).all()
    last = dict(zip(states[-1].names, states[-1].position, strict=True))
    assert (last["rate_of_penetration"], last["weight_on_bit"]) == (0.0, pytest.approx(100.0))
    assert last["rotation"] == pytest.approx(4.0 * np.pi)
    assert MotionCode(int(last["whirl"])).whirls
    assert last["onset"] == bench_run.summary.onset.time_s
    assert last["realtime_factor"] > 0.0
    onset = states[0].names.index("onset")
    assert [state.position[onset] > 0.0 for state in states] == sorted(state.position[onset] > 0.0 for state in states)


def test_the_live_severity_is_that_of_the_same_window_of_the_bag(bench_run):
    recording = read_recording(bench_run.bag)
    *_, raw = (raw for _, _, raw in Bag(bench_run.bag).messages((TWIN_SUMMARY,)))
    live = read_joint_state(raw)
    time, centre = recording.marks.time, recording.centre_lines()
    window = (time > seconds(live.stamp) - WINDOW - 1e-9) & (time <= seconds(live.stamp))
    _, found = accelerations(time[window], centre[window])
    values = [
        (quantity, value, place.name)
        for mark, place in enumerate(recording.places)
        for quantity, value in zip(("lateral_rms", "lateral_peak"), sizes(found[:, mark]), strict=True)
    ]
    told = dict(zip(live.names, live.position, strict=True))
    assert {f"{quantity}/{mark}": value for quantity, value, mark in values} == pytest.approx(
        {name: value for name, value in told.items() if "/" in name}
    )
    assert told["lateral_severity"] == worst(values).grade
    assert told["severity"] >= told["lateral_severity"]


def test_the_live_severity_has_the_bounds_of_the_scene_and_is_unknown_where_it_is_not_observable():
    marks, step = [MarkInfo("mark", 1.0, "centre", 0.0, 0.01)], 10_000_000
    own = DEFAULT._replace(lateral_rms=(0.1, 0.2, 0.3, 0.4))
    for bounds, state, grade in (
        (None, MotionState.FIXED_AXIS, 0), (own, MotionState.FIXED_AXIS, 3), (own, MotionState.NOT_OBSERVABLE, -1)
    ):  # fmt: skip
        summary = TwinSummary(marks, bounds)
        for stamp in range(step, 200 * step, step):
            centre = np.array([1e-4 * np.exp(18.0j * stamp * 1e-9)])  # 0.032 m/s^2
            centre += 0.01 * np.exp(6.0j * stamp * 1e-9)  # 0.36 m/s^2
            summary.add(stamp, RigSample(6.0, 6.0, 1e3), centre)
            summary.add(stamp, RigSample(6.0, 6.0, 1e3), centre + 1.0)  # late: left out
        found = read_joint_state(summary.encode(stamp, "hole", state, BitMotion.STEADY, 0.1))
        told = dict(zip(found.names, found.position, strict=True))
        assert told["lateral_severity"] == grade
        assert told["severity"] == max(grade, 0)  # the bit turns steadily
        expected = -1.0 if grade == -1 else pytest.approx(math.hypot(0.36, 0.0324), rel=0.01)
        assert told["lateral_rms/mark"] == expected


@pytest.mark.parametrize(
    ("motion", "index", "bit", "grade"),
    [
        (BitMotion.STICK_SLIP, 1.1, 3.0, Grade.HIGH),
        (BitMotion.STICK_SLIP, 1.1, -0.5, Grade.SEVERE),  # it turns backwards
        (BitMotion.DECAYING, 1.1, 3.0, Grade.NONE),
        (BitMotion.STANDS, math.nan, 0.0, Grade.SEVERE),
        (BitMotion.STARTING, math.nan, -0.5, -1),
        (BitMotion.AT_REST, math.nan, 0.0, Grade.NONE),
    ],
)
def test_torsion_is_graded_by_its_kind(motion, index, bit, grade):
    summary = TwinSummary([])
    summary.add(10_000_000, RigSample(6.0, bit, 1e3))
    found = read_joint_state(summary.encode(10_000_000, "hole", MotionState.NOT_OBSERVABLE, motion, index))
    assert found.position[found.names.index("severity")] == grade
    assert found.position[found.names.index("lateral_severity")] == -1


def test_the_rate_of_penetration_is_that_of_the_depth_and_what_a_rig_lacks_is_left_out():
    marks = [MarkInfo("mark", 1.0, "centre", 0.0, 0.01)]
    calm = MotionState.FIXED_AXIS, BitMotion.STEADY, np.nan
    summary, poor = TwinSummary(marks), TwinSummary(marks)
    for stamp in range(10_000_000, 400_000_001, 10_000_000):
        if summary.add(stamp, RigSample(6.0, 6.0, 1e3, 0.01 * stamp * 1e-9)):
            last = read_joint_state(summary.encode(stamp, "hole", *calm))
        if poor.add(stamp, RigSample(6.0, np.nan)):
            least = read_joint_state(poor.encode(stamp, "hole", *calm))
    told = dict(zip(last.names, last.position, strict=True))
    assert [told[name] for name in ("rate_of_penetration", "weight_on_bit", "rotation", "whirl", "stick_slip")] == [
        pytest.approx(0.01), 1e3, 6.0, MotionCode.FIXED_AXIS, StickSlipCode.STEADY
    ]  # fmt: skip
    assert least.names[:2] == ("rotation", "lateral_rms/mark")


def test_a_bag_gives_what_was_found_live_byte_for_byte(inputs, live):
    pipeline, found = fed(inputs)
    assert found == live
    assert pipeline.findings.quality.accepted == 300
    assert (pipeline.malformed, pipeline.pairing.unpaired, pipeline.trouble, pipeline.runs) == (0, 0, "", 1)


@pytest.mark.parametrize("seed", range(5))
def test_order_of_arrival_between_the_topics_does_not_matter(inputs, live, seed):
    """DDS keeps the order within a topic, not between topics."""
    choice = random.Random(seed)
    queues = {topic: [raw for name, raw in inputs if name == topic] for topic in INPUTS}
    mixed = []
    while any(queues.values()):
        topic = choice.choice([name for name, queue in queues.items() if queue])
        mixed += [(topic, queues[topic].pop(0)) for _ in range(min(len(queues[topic]), choice.randint(1, 40)))]
    assert fed(mixed)[1] == live


def test_after_a_stamp_from_the_future_the_analysis_goes_on(inputs, live):
    """One sample of next year: without a new beginning every good one after it would be late for ever."""
    scene, *samples = inputs
    future = [(topic, restamped(raw, 10**15)) for topic, raw in samples[:2]]
    pipeline, found = fed([scene, *future, *samples])
    assert pipeline.runs == 2
    assert pipeline.findings.quality.accepted == 300
    assert found[-3:] == live[-3:]
    again = WhirlPipeline()
    late = [*samples[: 2 * STUCK], *samples[: 2 * STUCK - 2]]  # one too few to be a run of their own
    fed([scene, *late, *samples[2 * STUCK :]], again)
    assert again.runs == 1


def restamped(raw, stamp):
    patched = bytearray(raw)
    pack_stamp(patched, 4, stamp)
    return bytes(patched)


def test_scene_may_come_after_the_first_samples(inputs, live):
    scene, *samples = inputs
    assert scene[0] == TWIN_SCENE
    assert fed([*samples[:200], scene, *samples[200:]])[1] == live


def test_scene_may_be_given(inputs, live, bench_scene):
    pipeline = WhirlPipeline(bench_scene)
    announced = pipeline.start()
    assert fed(inputs, pipeline)[1] == live[1:]
    assert announced == live[:1]
    assert decode_onset(announced[0][1])[1] is None
    assert pipeline.runs == 1


def test_latched_scene_sent_once_more_changes_nothing(inputs, live):
    assert fed([*inputs[:301], inputs[0], *inputs[301:]])[1] == live


def test_new_scene_begins_a_new_run(inputs, live):
    again = encode_string("# the second run\n" + read_string(inputs[0][1]))
    pipeline, found = fed([*inputs, (TWIN_SCENE, again), *inputs[1:]])
    assert found == [*live, *live]
    assert pipeline.runs == 2
    assert pipeline.findings.quality.accepted == 300


@pytest.mark.parametrize("topic", INPUTS)
@pytest.mark.parametrize("raw", [b"", b"\x00\x01\x00\x00", bytes(range(256)), b"\x00\x01\x00\x00" + b"\xff" * 400])
def test_garbage_is_counted_and_named_and_changes_nothing(inputs, live, topic, raw):
    pipeline, found = fed([*inputs[:100], (topic, raw), *inputs[100:]])
    assert found == live
    assert pipeline.malformed == 1
    assert pipeline.trouble


def test_marks_of_another_scene_are_refused(inputs, bench_scene):
    marks = bench_scene.string.marks
    renamed = bench_scene.model_copy(
        update={
            "string": bench_scene.string.model_copy(update={"marks": (marks[0].model_copy(update={"name": "other"}),)})
        }
    )
    pipeline, found = fed(inputs, WhirlPipeline(renamed))
    assert found == []
    assert pipeline.malformed == 300
    assert "other/x" in pipeline.trouble
    assert "mark_1/x" in pipeline.trouble


def test_samples_without_a_partner_are_dropped_in_the_end_and_counted(inputs):
    lone = [(topic, raw) for topic, raw in inputs if topic != RIG_STATE]
    pipeline, found = fed(lone)
    assert [topic for topic, _ in found] == [WHIRL_ONSET]
    assert pipeline.pairing.unpaired == 300 - WAITING


def test_lost_samples_of_one_topic_cost_only_themselves(inputs):
    lost = {k for k in range(1, 601) if inputs[k][0] == MARKS_STATE and 200 <= k < 220}
    pipeline, _ = fed([message for k, message in enumerate(inputs) if k not in lost])
    assert pipeline.findings.quality.accepted == 300 - len(lost)
    assert np.isfinite(pipeline.findings.orbit_radius).all()


def test_summary_without_a_scene_is_an_error(inputs):
    pipeline, found = fed(inputs[1:])
    assert found == []
    with pytest.raises(DrillTwinError, match="expected the scene of the run on /twin/scene"):
        pipeline.summary()


# --- streams that lack something


def test_without_rig_states_the_spin_turns(inputs):
    pipeline = WhirlPipeline(lacks=[RIG_STATE])
    fed([row for row in inputs if row[0] != RIG_STATE], pipeline)
    assert pipeline.findings.quality.accepted == 300
    assert pipeline.summary().rotation_rev_s == pytest.approx(2.0, rel=0.05)
    assert pipeline.findings.bit.value == "not observable"


def test_without_marks_the_bit_is_all_there_is(inputs):
    pipeline, found = fed([row for row in inputs if row[0] != MARKS_STATE], WhirlPipeline(lacks=[MARKS_STATE]))
    assert pipeline.quality.accepted == 300
    assert not pipeline.summary().observable
    bit = pipeline.summary().bit
    assert bit is BitMotion.STARTING  # after 3 s
    assert pipeline.motion == f"whirl not observable, bit: {bit.value}"
    stamp, motions = decode_motion(next(raw for topic, raw in found if topic == WHIRL_MOTION))
    assert stamp > 0
    assert [(motion.subject, motion.state) for motion in motions] == [
        ("string", "not observable"),
        ("bit", "too early to tell"),  # the first message, at the first sample
    ]


def test_scene_without_marks_is_analysed_for_the_bit(inputs, bench_scene):
    bare = bench_scene.model_copy(update={"string": bench_scene.string.model_copy(update={"marks": ()})})
    pipeline, _ = fed(inputs[1:], WhirlPipeline(bare))
    assert (pipeline.malformed, pipeline.quality.accepted) == (0, 300)
    assert not pipeline.summary().observable


def test_motion_of_the_bit_is_on_the_topic(live):
    motions = [decode_motion(raw)[1] for topic, raw in live if topic == WHIRL_MOTION]
    assert all(motion[-1].subject == "bit" for motion in motions)
    assert [*dict.fromkeys(motion[-1].state for motion in motions)] == ["too early to tell", "start-up"]


def test_some_of_the_marks(inputs):
    pipeline, _ = fed(inputs, WhirlPipeline(marks=["mark_3"]))
    assert pipeline.findings.marks == ("mark_3",)
    with pytest.raises(AnalysisError, match="found mark_7"):
        WhirlPipeline(pipeline.scene, marks=["mark_7"])


@pytest.mark.parametrize(
    ("bit", "index", "told"),
    [(BitMotion.STEADY, 0.01, (Level.OK, "none")), (BitMotion.VIBRATION, 0.7, (Level.OK, "medium")),
     (BitMotion.STICK_SLIP, 1.1, (Level.WARN, "high")), (BitMotion.STARTING, math.nan, (Level.OK, "unknown"))],
)  # fmt: skip
def test_diagnostics_warn_of_a_high_severity(bit, index, told):
    encoder = FindingsEncoder(())
    encoder.summary.add(0, UNKNOWN_RIG[0])
    encoder.summary.encode(0, "world", MotionState.NOT_OBSERVABLE, bit, index)
    assert encoder.severity == told
