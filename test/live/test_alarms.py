# SPDX-License-Identifier: Apache-2.0
"""Alarms, limits, lamps and trends of the page: when they begin, when they end, and what a request may say of them."""

import json
import math

import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import TwinEncoder, encode_string
from drill_twin.io.messages.topics import DIAGNOSTICS, ESTIMATE_STATE, RIG_STATE, TWIN_SCENE, WHIRL_MOTION, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import SubjectMotion, WhirlStateEncoder, encode_motion
from drill_twin.live.alarms import Alarms
from drill_twin.live.lamps import stick_slip_lamp, whirl_lamp
from drill_twin.live.limits import parse_limit
from drill_twin.live.page_state import PageState
from drill_twin.live.sources import Sources
from drill_twin.live.supervision import Supervision
from drill_twin.live.trends import CHANNELS, SECONDS, Trends
from drill_twin.scene import load_scene
from drill_twin.whirl import StickSlip

VALUES = dict.fromkeys(CHANNELS, 1.0) | {"rop": math.nan}


def _texts(alarms):
    return [event["text"] for event in alarms.events()]


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
    for wrong in ("", "torque", "torque_high=", "speed_high=3 rpm", "torque_high=12 kN", "wob_high=5"):
        with pytest.raises(DrillTwinError, match="expected"):
            parse_limit(wrong)


def test_severity_of_the_lamps():
    assert whirl_lamp("", math.nan).level is None
    assert whirl_lamp("not observable", math.nan).level is None
    assert whirl_lamp("rotation about a fixed axis", 0.3).level == 0
    assert whirl_lamp("forward whirl", 0.4).level == 1
    assert whirl_lamp("forward whirl", 0.95).level == 2
    assert whirl_lamp("rolling along the wall", math.nan).level == 2
    assert stick_slip_lamp(StickSlip()).level is None


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
            assert seen.lamps["stick_slip"].share == pytest.approx(105.0 / 120.0, rel=0.08)
    assert list(levels) == ["start-up", "steady rotation", "torsional vibration", "at rest"]
    assert levels["torsional vibration"][0] < 40.0 + 5.5
    assert levels["at rest"][-1] > 150.0
    assert [(row["text"], row["active"]) for row in seen.snapshot()["alarms"]] == [
        ("stick-slip: torsional vibration", False)
    ]


def test_a_string_on_the_low_side_of_a_deviated_hole_is_not_severe_for_its_radius():
    levels = {}
    for name in ("pa6_bench", "well_b"):
        page, scene = PageState(), load_scene(name)
        marks = [mark.name for mark in scene.string.marks]
        page.update(TWIN_SCENE, encode_string(scene.to_yaml()))
        radii = [scene.clearance_at(mark.distance_from_bit) for mark in scene.string.marks]
        ones = [1.0] * len(marks)
        page.update(WHIRL_STATE, WhirlStateEncoder(marks).encode(0, radii, ones, ones, ones))
        motions = [SubjectMotion("string", "forward whirl", "")]
        page.update(WHIRL_MOTION, encode_motion(0, motions))
        lamps = page.snapshot()["lamps"]
        levels[name] = lamps["whirl"]["level"]
    assert levels == {"pa6_bench": 2, "well_b": 1}


def test_rate_of_penetration_comes_from_the_diagnostics(make_frame, make_geometry):
    page = PageState()

    def tell(rate):
        status = Status("simulator", Level.OK, "", {"rate_of_penetration_m_h": rate})
        page.update(DIAGNOSTICS, encode_diagnostics(0, [status]))

    tell("36")
    page.update(RIG_STATE, TwinEncoder(make_geometry()).rig_state(Frames.of(make_frame()))[0])
    assert page.snapshot()["rig"]["rop"] == pytest.approx(0.01)
    tell("fast")
    assert DIAGNOSTICS in page.skipped


def test_estimates_are_shown_with_their_bands_until_the_estimator_is_gone():
    times = [0.0]
    page = PageState(Sources(lambda: times[0]))

    def tell(level, text):
        chance = {"chance_of_whirl": "0.25"}
        ends = {"mean": "6.2832", "low": "3.1416", "high": "nan" if text == "odd" else "12.5664"}
        speed = Status("estimate: bit_speed", Level.OK, "6.283 (3.142 to 12.57) rad/s", ends)
        factor = Status("estimate: load_factor", Level.OK, "1.2 (1 to 1.4)", ends)
        page.update(ESTIMATE_STATE, encode_diagnostics(0, [Status("estimate", level, text, chance), speed, factor]))

    tell(Level.OK, "the model explains what is measured")
    chance, speed, factor = page.snapshot()["estimates"]["rows"]
    assert chance == {"name": "chance of whirl", "text": "25%"}
    assert (speed["name"], speed["quantity"]) == ("bit speed", "rotation")
    assert [speed[key] for key in ("mean", "low", "high")] == pytest.approx([1.0, 0.5, 2.0], rel=1e-4)  # rev/s
    assert factor == {"name": "load_factor", "text": "1.2 (1 to 1.4)"}  # without a unit there is nothing to convert
    assert page.snapshot()["alarms"] == []
    tell(Level.ERROR, "hookload leaves the band")
    assert [row["text"] for row in page.snapshot()["alarms"]] == ["estimator: hookload leaves the band"]
    tell(Level.OK, "odd")
    assert page.snapshot()["estimates"]["rows"][1] == {"name": "bit_speed", "text": "6.283 (3.142 to 12.57) rad/s"}
    assert [row["active"] for row in page.snapshot()["alarms"]] == [False]
    times[0] = 5.0
    assert page.snapshot()["estimates"] == {"level": 3, "text": "no estimates for 5 s", "rows": []}
    page.update(ESTIMATE_STATE, encode_diagnostics(0, [Status("x" * 10_000, Level.OK, "")] * 100))
    assert ESTIMATE_STATE in page.skipped


def test_motions_raise_alarms_and_are_logged_once():
    seen = Supervision(recorded=False)
    calm = "rotation about a fixed axis"
    for state in (calm, calm, "forward whirl", "forward whirl", "spiral"):
        seen.motion(state, 0.5)
    assert [row["text"] for row in seen.snapshot()["alarms"]] == ["whirl: spiral"]
    said = [f"whirl: {calm}", "whirl: forward whirl", "whirl: spiral"]
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
