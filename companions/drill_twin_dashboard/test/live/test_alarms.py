# SPDX-License-Identifier: Apache-2.0
"""Alarms, limits, lamps and trends of the page: when they begin, when they end, and what a request may say of them."""

import json
import math

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.severity import Grade, Severity
from drill_twin.io.findings_encoder import TwinSummary
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import TwinEncoder, encode_string
from drill_twin.io.messages.topics import DIAGNOSTICS, ESTIMATE_STATE, RIG_STATE, TWIN_SCENE, TWIN_SUMMARY
from drill_twin.io.samples import RigSample
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import load_scene
from drill_twin.scene.blocks.severity import SeverityBounds
from drill_twin.whirl import BitMotion, MotionCode, MotionState, StickSlip
from drill_twin_dashboard.live.alarms import CHANNELS, SECONDS, Alarms, Trends, parse_limit
from drill_twin_dashboard.live.page_state import PageState
from drill_twin_dashboard.live.shown import Sources
from drill_twin_dashboard.live.supervision import Supervision, lamp, stick_slip_lamp

VALUES = dict.fromkeys(CHANNELS, 1.0) | {"rop": math.nan}


def _texts(alarms):
    return [event["text"] for event in alarms.events]


def test_an_alarm_stays_until_it_is_acknowledged_and_over():
    alarms = Alarms(recorded=False)
    assert alarms.update("a", 1, "whirl: forward whirl", 1.0)
    assert not alarms.update("a", 1, "whirl: spiral", 2.0)
    assert [row["text"] for row in alarms.rows()] == ["whirl: spiral"]
    alarms.acknowledge(alarms.rows()[0]["number"], 3.0)
    assert [(row["active"], row["acknowledged"]) for row in alarms.rows()] == [(True, True)]
    assert alarms.update("a", 2, "worse", 4.0)  # raised again
    assert [(row["level"], row["acknowledged"]) for row in alarms.rows()] == [(2, False)]
    assert alarms.update("a", 0, "", 5.0)
    assert [(row["active"], row["acknowledged"]) for row in alarms.rows()] == [(False, False)]
    alarms.acknowledge(None, 6.0)
    assert alarms.rows() == []
    assert _texts(alarms) == [
        "whirl: forward whirl", "acknowledged: whirl: spiral", "worse", "over: worse", "acknowledged: worse",
    ]  # fmt: skip
    with pytest.raises(DrillTwinError, match="expected the number of an alarm, found 7"):
        alarms.acknowledge(7, 6.0)


def test_a_limit_raises_an_alarm_at_once_and_ends_it_after_ten_seconds_within():
    seen = Supervision(recorded=False)
    assert seen.take({"torque_high": 10.0, "wob_low": 0.5, "seek": 3}) == {"seek": 3}

    def run(begin, end, torque):
        for k in range(round(10 * begin), round(10 * end)):
            seen.rig(0.1 * k, {**VALUES, "torque": torque(0.1 * k)})
        return [(row["text"], row["active"]) for row in seen.snapshot()["alarms"]]

    text = "top-drive torque above its high limit"
    assert run(0.0, 2.0, lambda _: 5.0) == []
    assert run(2.0, 2.1, lambda _: 20.0) == [(text, True)]
    assert run(2.1, 40.0, lambda time: 20.0 if time % 8.0 < 0.5 else 5.0) == [(text, True)]
    assert _texts(seen.alarms).count(text) == 1
    assert run(40.0, 42.0, lambda _: 5.0) == [(text, True)]
    assert run(42.0, 52.0, lambda _: 5.0) == [(text, False)]
    seen.take({"acknowledge": True, "torque_high": False})
    assert run(52.0, 54.0, lambda _: 20.0) == []


@pytest.mark.parametrize(
    "request_", [{"torque_high": True}, {"wob_low": 9.0, "wob_high": 9.0}, {"acknowledge": 3}, {"acknowledge": False}]
)
def test_an_impossible_request_is_refused_with_a_sentence(request_):
    seen = Supervision(recorded=False)
    with pytest.raises(DrillTwinError, match=r"^expected "):
        seen.take(request_)


def test_a_limit_of_the_command_line_has_a_unit():
    assert parse_limit("torque_high=12 kN m") == {"torque_high": 12e3}
    assert parse_limit("rps_low = 90 rpm") == {"rps_low": pytest.approx(1.5)}
    assert parse_limit("rop_high=36 m/h") == {"rop_high": pytest.approx(0.01)}
    for wrong in (
        "",
        "torque",
        "torque_high=",
        "speed_high=3 rpm",
        "torque_middle=12 kN m",
        "torque_high=12 kN",
        "wob_high=5",
    ):
        with pytest.raises(DrillTwinError, match="expected"):
            parse_limit(wrong)


def test_a_lamp_tells_the_motion_and_its_colour_is_the_severity():
    assert lamp("spiral", None) == (None, "spiral", "severity unknown")
    found = [
        lamp("spiral", Severity(grade, "lateral_rms", 9.80665 * value, "mark_2"))
        for grade, value in zip(Grade, (0.02, 0.6, 2.6, 6.0, 12.0), strict=True)
    ]
    assert [one.level for one in found] == [0, 0, 1, 2, 2]
    assert found[2].severity == "medium: lateral acceleration 2.6 g rms at mark_2"
    assert stick_slip_lamp(StickSlip()) == (None, "not observable", "severity unknown")


def test_a_bit_that_turns_backwards_is_severe():
    seen = Supervision(recorded=False)
    for k in range(4000):
        swing = 1.1 * math.sin(math.tau * 0.02 * k / 5.5)
        seen.rig(0.02 * k, {**VALUES, "rps": 2.0, "bit_rps": 2.0 + 2.0 * swing})
    assert seen.lamps["stick_slip"].level == 2
    assert seen.lamps["stick_slip"].text == "stick-slip"
    assert seen.lamps["stick_slip"].severity.startswith("severe: stick-slip index 1.08")
    assert seen.lamps["stick_slip"].severity.endswith(", the bit turns backwards")
    (alarm,) = seen.snapshot()["alarms"]
    assert alarm["text"].startswith("stick-slip: stick-slip, severe: stick-slip index 1.08")


def test_the_lamp_of_stick_slip_goes_by_the_index_and_not_by_the_start_up():
    """The bit is wound up, breaks loose and catches up; then it swings from 15 to 225 rpm, and stops."""
    seen, levels = Supervision(recorded=False), {}
    for k in range(8000):
        time = 0.02 * k
        top = 120.0 * min(time / 8.0, 1.0) if time < 120.0 else 0.0
        swing = 105.0 * math.sin(math.tau * time / 5.5) if time >= 40.0 else 60.0 * math.exp(-time / 10.0)
        bit = (0.0 if time < 4.0 else top + swing) if time < 120.0 else 0.0
        jitter = 0.5 * math.sin(math.tau * 8.9 * time)
        seen.rig(time, {**VALUES, "rps": top / 60.0, "bit_rps": (bit + jitter) / 60.0})
        levels.setdefault(seen.lamps["stick_slip"].text, []).append(time)
        if round(time, 3) == 66.0:
            index = float(seen.lamps["stick_slip"].severity.removeprefix("medium: stick-slip index "))
            assert index == pytest.approx(105.0 / 120.0, rel=0.08)
    assert list(levels) == ["too early to tell", "start-up", "steady rotation", "torsional vibration", "at rest"]
    assert levels["torsional vibration"][0] < 40.0 + 5.5
    assert levels["at rest"][-1] > 150.0
    assert [(row["text"], row["active"]) for row in seen.snapshot()["alarms"]] == [
        ("stick-slip: torsional vibration, medium: stick-slip index 0.877", False)
    ]


@pytest.mark.parametrize(
    ("state", "size", "own", "level", "told"),
    [
        (MotionState.ROLLING, 0.03, None, 0, "none: lateral acceleration 0.03 g rms at mark_2"),  # it creeps
        (MotionState.ROLLING, 2.6, None, 1, "medium: lateral acceleration 2.6 g rms at mark_2"),
        (MotionState.FIXED_AXIS, 9.0, None, 2, "severe: lateral acceleration 9 g rms at mark_2"),  # and no whirl
        (MotionState.ROLLING, 0.03, (0.01, 0.02, 0.03, 0.04), 2, "severe: lateral acceleration 0.03 g rms at mark_2"),
        (MotionState.NOT_OBSERVABLE, 2.6, None, None, "severity unknown"),
    ],
)  # fmt: skip
def test_the_lamp_of_whirl_has_the_severity_of_the_lateral_acceleration(state, size, own, level, told):
    scene = load_scene("pa6_bench")
    if own:
        block = SeverityBounds(source="manual of a tool", lateral_rms=own)
        scene = scene.model_copy(update={"severity": block})
    page, marks, step = PageState(), mark_infos(scene), 10_000_000
    page.update(TWIN_SCENE, encode_string(scene.to_yaml()))
    summary, omega = TwinSummary(marks, scene.severity_bounds), 12.0
    for stamp in range(step, 100 * step, step):
        orbit = size * 9.80665 / omega**2 * np.exp(1j * omega * stamp * 1e-9)
        summary.add(stamp, RigSample(1.0, 1.0, 1.0, 0.0), orbit * np.array([0.5, 1.0, 0.5, 0.5]))
    page.update(TWIN_SUMMARY, summary.encode(stamp, "hole", state, BitMotion.STEADY, math.nan))
    shown = page.snapshot()["lamps"]["whirl"]
    assert shown == {"level": level, "text": state.value, "severity": told}
    ours = "of this program, not of a vendor, for tools of the field, not of a bench"
    source = "manual of a tool, for lateral acceleration rms; " if own else ours
    assert page.snapshot()["scene"]["bounds"].startswith(source)
    assert [row["text"] for row in page.snapshot()["alarms"]] == [f"whirl: {state.value}, {told}"] * bool(level)


def test_a_code_that_nobody_knows_is_skipped_and_counted():
    page = PageState()
    odd = JointStateTemplate(("whirl", "lateral_rms/mark"), velocity=False, effort=False)
    for number, code in enumerate((99.0, math.nan, math.inf)):
        page.update(TWIN_SUMMARY, odd.fill(number, [code, 1.0]))
    assert len(page.skipped) == 3
    assert page.snapshot()["lamps"]["whirl"]["level"] is None


def test_rate_of_penetration_is_that_of_the_rig_and_none_for_a_bit_that_has_not_drilled(make_frame, make_geometry):
    page, encoder, frame = PageState(), TwinEncoder(make_geometry()), make_frame()
    for drilled, shown in ((0.0, None), (0.5, 0.01)):
        rig = frame.rig._replace(drilled=drilled, rate_of_penetration=0.01)
        page.update(RIG_STATE, encoder.rig_state(frames_of(frame._replace(rig=rig)))[0])
        assert page.snapshot()["rig"]["rop"] == shown


def test_estimates_are_shown_with_their_bands_until_the_estimator_is_gone():
    times = [0.0]
    page = PageState(Sources(lambda: times[0]))
    names = ("trust", "alarm", "whirls", "chance_of_whirl", "bit_speed", "bit_speed/low", "bit_speed/high",
             "load_factor", "load_factor/low", "load_factor/high", "load_factor/deviation")  # fmt: skip
    template = JointStateTemplate(names, velocity=False, effort=False)

    def tell(text, *, trust=0.0, alarm=0.0, high=4.0 * math.pi):
        values = [trust, alarm, 0.0, 0.25, math.tau, math.pi, high, 1.2, 1.0, 1.4, 0.1]
        page.update(ESTIMATE_STATE, template.fill(0, values))
        page.update(DIAGNOSTICS, encode_diagnostics(0, [Status("estimator", Level.WARN, text)]))

    tell("the model explains what is measured")
    chance, speed, factor = page.snapshot()["estimates"]["rows"]
    assert chance == {"name": "chance of whirl", "mean": 0.25, "low": None, "high": None}
    assert speed == {"name": "bit speed", "quantity": "rotation", "mean": 1.0, "low": 0.5, "high": 2.0}  # rev/s
    assert factor == {"name": "load_factor", "mean": 1.2, "low": 1.0, "high": 1.4}  # without a unit to convert
    assert page.snapshot()["alarms"] == []
    tell("hookload leaves the band", trust=1.0, alarm=1.0)
    assert [row["text"] for row in page.snapshot()["alarms"]] == ["estimator: hookload leaves the band"]
    assert page.snapshot()["estimates"]["level"] == Level.ERROR
    tell("fine", high=math.nan)
    assert page.snapshot()["estimates"]["rows"][1]["high"] is None
    assert [row["active"] for row in page.snapshot()["alarms"]] == [False]
    tell("the filter has failed", trust=2.0)
    assert page.snapshot()["estimates"]["rows"] == []
    times[0] = 5.0
    assert page.snapshot()["estimates"] == {"level": 3, "text": "no estimates for 5 s", "rows": []}
    page.update(ESTIMATE_STATE, JointStateTemplate(["x" * 10_000]).fill(0, [0.0], [0.0], [0.0]))
    assert ESTIMATE_STATE in page.skipped


def test_motions_raise_alarms_and_are_logged_once():
    seen = Supervision(recorded=False)
    calm, forward = MotionCode.FIXED_AXIS, MotionCode.FORWARD_WHIRL
    told = "medium: lateral acceleration 2.5 g rms at mark_1"
    hard = Severity(Grade.MEDIUM, "lateral_rms", 25.0, "mark_1")
    for code, found in ((calm, None), (calm, None), (forward, hard), (forward, hard), (MotionCode.SPIRAL, hard)):
        seen.light("whirl", lamp(code.state.value, found))
    assert [row["text"] for row in seen.snapshot()["alarms"]] == [f"whirl: spiral, {told}"]
    said = [f"whirl: {calm.state.value}", f"whirl: forward whirl, {told}", f"whirl: spiral, {told}"]
    assert _texts(seen.alarms) == said


def test_trends_hold_least_mean_and_largest_of_each_interval_and_begin_again_with_the_time():
    trends = Trends(most=100)
    for k in range(100):
        trends.push(0.01 * k, {"wob": float(k), "rps": math.nan})
    rows = trends.all()["rows"]
    assert [row[0] for row in rows] == [0, 1, 2]  # the fourth is not over
    assert rows[1][:4] == [1, 25.0, 37.0, 49.0]
    assert rows[1][4:7] == [None, None, None]
    assert trends.recent()["rows"] == rows
    for k in range(100, 4000):
        trends.push(0.01 * k, {"wob": 0.0})
    assert len(trends.recent()["rows"]) == 100
    assert len(trends.recent()["rows"]) < 12
    trends.push(0.0, {"wob": 1.0})
    assert trends.all() == {"run": 1, "channels": list(CHANNELS), "seconds": SECONDS, "rows": []}
    json.dumps(trends.recent(), allow_nan=False)
