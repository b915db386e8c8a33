# SPDX-License-Identifier: Apache-2.0
"""Advice on a map whose boundaries are known in closed form: calm below one diagonal, a whirl dies below another."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.topic_words import AdviceCode
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span
from drill_twin_studies.maps.advice import Adviser, Tracker, encode_advice
from drill_twin_studies.maps.runs import Key, RunRecord

STEPS = 16
PLANE = Plane(Span(0.0, 160.0), Span(0.0, 16.0), STEPS)  # a step is 10 N and 1 rad/s


def adviser(*, begins=16, dies=8, margin=0.1):
    """Whirl from rest where i + j >= begins; an existing one goes on where i + j >= dies."""
    nodes = [(i, j) for i in range(STEPS + 1) for j in range(STEPS + 1)]
    regimes = [Regime.FORWARD if i + j >= begins else Regime.SMOOTH for i, j in nodes]
    records = {Key(*node): RunRecord(regime) for node, regime in zip(nodes, regimes, strict=True)}
    for i, j in nodes:
        if dies <= i + j < begins:
            records[Key(i, j, 0, (STEPS, STEPS))] = RunRecord(Regime.FORWARD)
        elif i + j < min(dies, begins):
            records[Key(i, j, 0, (STEPS, STEPS))] = RunRecord(Regime.SMOOTH)
    return Adviser(OperatingMap("string", "", "", PLANE, 100.0, (), records), margin)


def node_of(target):
    return round(target.weight / 10.0), round(target.speed)


def test_a_calm_set_point_with_margin_is_held():
    said = adviser().advise(40.0, 4.0, whirls=False)
    assert (said.level, said.target, said.regime) == (Level.OK, None, Regime.SMOOTH)
    assert said.margin.weight == pytest.approx(75.0)
    assert "75 N or 1.19 rev/s from the boundary: hold" in said.text


def test_the_margin_along_each_axis_is_that_to_its_own_boundary():
    """Whirl from 120 N on at any speed, and from 8 rad/s on at any weight."""
    nodes = [(i, j) for i in range(STEPS + 1) for j in range(STEPS + 1)]
    records = {Key(i, j): RunRecord(Regime.FORWARD if i >= 12 or j >= 8 else Regime.SMOOTH) for i, j in nodes}
    margin = OperatingMap("string", "", "", PLANE, 100.0, (), records).margin(40.0, 4.0)
    assert margin == pytest.approx((75.0, 3.5, 3.5 / STEPS))


def test_near_the_boundary_it_asks_for_more_margin():
    said = adviser().advise(80.0, 7.0, whirls=False)
    assert said.level is Level.WARN
    assert said.target.margin >= 0.1
    assert sum(node_of(said.target)) in {12, 13}
    assert "for more margin" in said.text


def test_beyond_the_boundary_it_names_the_nearest_calm_set_point():
    said = adviser().advise(100.0, 10.0, whirls=False)
    assert said.level is Level.ERROR
    assert said.margin.share < 0.0
    i, j = node_of(said.target)
    assert (abs(i - j), i + j < 16) == (0, True) or abs(i - j) == 1
    assert "the nearest calm set-point" in said.text


def test_out_of_a_whirl_by_the_second_boundary():
    calm = adviser().advise(60.0, 6.0, whirls=False)
    whirling = adviser().advise(60.0, 6.0, whirls=True)
    assert calm.target is None
    assert (whirling.level, whirling.keeps) == (Level.ERROR, True)
    assert sum(node_of(whirling.target)) < 8
    assert "where a whirl dies" in whirling.text


def test_a_whirl_that_dies_is_waited_for_and_one_that_does_not_sent_farther():
    some = adviser()
    waiting = some.advise(20.0, 2.0, whirls=True, seconds=1.0)
    assert (waiting.level, waiting.target) == (Level.WARN, None)
    assert "dies here within 150 s by the map: hold" in waiting.text
    late = some.advise(20.0, 2.0, whirls=True, seconds=150.1)
    assert late.level is Level.ERROR
    assert sum(node_of(late.target)) < 4
    corner = some.advise(0.0, 0.0, whirls=True, seconds=150.1)
    assert (corner.target.weight, corner.target.speed) == (0.0, 0.0)
    assert "stop the rotation, and begin again at 0 N at 0.1592 rev/s" in corner.text


def test_a_rotation_that_stops_is_not_resumed_in_a_whirl():
    some = adviser()
    some.map = replace(some.map, plane=PLANE._replace(speed=Span(1.0, 17.0)))
    stopping = some.advise(0.0, 0.5, whirls=True)
    assert stopping.target.speed == 0.0
    assert some.advise(0.0, 0.5, whirls=False).target.speed >= 1.0


def test_the_advice_to_stop_holds_until_the_whirl_has_ended():
    tracker, some = Tracker(), adviser(dies=0)
    some.map = replace(some.map, plane=PLANE._replace(speed=Span(1.0, 17.0)))
    said = []
    tracker.take(-10.0, 40.0, 4.0)
    for second, speed in enumerate((4.0, 2.0, 1.5, 0.5, 0.0)):
        tracker.take(10.0 * second, 40.0, speed)
        said.append(tracker.advise(some, whirls=True))
    assert [advice.target.speed for advice in said] == [0.0] * 5
    assert "the string still whirls, and no better set-point is known: stop the rotation" in said[2].text
    assert tracker.advise(some, whirls=False) is None
    assert "does not turn" in tracker.waits_for


def said_of(tracker, some, begin, end, set_point, whirls=lambda _: False):
    """Advice ten times a second, as the node asks for it, from samples a hundred times a second."""
    found = []
    for k in range(round(100 * begin), round(100 * end)):
        tracker.take(0.01 * k, *set_point(0.01 * k))
        if k % 10 == 9:
            found.append(tracker.advise(some, whirls=whirls(0.01 * k)))
    return found


def test_nothing_is_advised_while_a_driver_ramps_from_rest():
    """The ramps of the bench, to a set-point that whirls: one target, once they have ended."""
    tracker, some = Tracker(), adviser()
    ramp = lambda time: (100.0 * min(time / 8.6, 1.0), 10.0 * min(time / 8.0, 1.0))  # noqa: E731
    assert set(said_of(tracker, some, 0.0, 8.6, ramp)) == {None}
    assert "changing" in tracker.waits_for
    after = said_of(tracker, some, 8.6, 30.0, ramp)
    assert len({advice.target for advice in after if advice is not None}) == 1
    assert after[-1].level is Level.ERROR


def test_a_target_stands_on_the_way_to_it_and_ends_there():
    tracker, some = Tracker(), adviser()
    (first, *_) = [advice for advice in said_of(tracker, some, 0.0, 5.0, lambda _: (100.0, 10.0)) if advice]
    weight, speed = first.target.weight, first.target.speed

    def way(time):
        share = min((time - 5.0) / 5.0, 1.0)
        return 100.0 + (weight - 100.0) * share, 10.0 + (speed - 10.0) * share

    moving = said_of(tracker, some, 5.0, 10.0, way)
    assert {advice.target for advice in moving} == {first.target}
    there = said_of(tracker, some, 10.0, 20.0, way)[-1]
    assert (there.level, there.target) == (Level.OK, None)


def test_set_points_that_swing_with_a_whirl_get_advice_too():
    tracker, some = Tracker(), adviser(dies=8)
    swing = lambda time: (100.0 + 60.0 * math.sin(2.0 * time), 10.0)  # noqa: E731
    said = said_of(tracker, some, 0.0, 30.0, swing, whirls=lambda time: time > 5.0)
    assert said[40] is None
    assert all(advice is not None and advice.target is not None for advice in said[160:])
    assert len({advice.target for advice in said[160:]}) == 1


def test_a_speed_at_which_no_run_could_tell_a_whirl_is_not_advised():
    some = adviser()
    assert some.advise(100.0, 0.5, whirls=True).target.speed <= 1.0
    some.map = replace(some.map, duration=10.0)  # six revolutions at 3.8 rad/s
    some = Adviser(some.map)
    for whirls in (False, True):
        assert some.advise(170.0, 0.5, whirls=whirls).target.speed == 4.0


def test_it_says_so_where_there_is_nothing_calm():
    said = adviser(begins=0, dies=0).advise(40.0, 4.0, whirls=False)
    assert (said.level, said.target) == (Level.ERROR, None)
    assert "no calm set-point in its ranges, 0 N at 0 rev/s to 160 N at 2.546 rev/s" in said.text
    endless = adviser(dies=0).advise(40.0, 4.0, whirls=True)
    assert endless.target.speed == 0.0
    assert "stop the rotation, and begin again" in endless.text
    assert "begin again" not in adviser(begins=0, dies=0).advise(40.0, 4.0, whirls=True).text


@pytest.mark.parametrize("whirls", [False, True])
def test_outside_the_map_the_way_leads_into_it(whirls):
    said = adviser().advise(500.0, 2.0, whirls=whirls)
    assert (said.level, said.regime) == (Level.ERROR, None)
    assert "outside the map" in said.text
    assert said.target.weight < 160.0


def test_advice_leads_to_a_set_point_that_is_held():
    some = adviser()
    for whirls in (False, True):
        for i in range(STEPS + 1):
            for j in range(STEPS + 1):
                said = some.advise(10.0 * i, float(j), whirls=whirls)
                if said.target is not None:
                    assert some.advise(said.target.weight, said.target.speed, whirls=whirls).target is None


def test_its_message_has_the_numbers_of_the_sentence():
    said = adviser().advise(100.0, 10.0, whirls=False)
    state = read_joint_state(encode_advice(5, said, 100.0, 10.0, whirls=False))
    values = dict(zip(state.names, state.position.tolist(), strict=True))
    assert state.stamp == 5
    assert (values["advice"], values["weight_on_bit"], values["rotation"]) == (AdviceCode.LEAVE, 100.0, 10.0)
    assert (values["target"], values["target/weight_on_bit"]) == (1.0, said.target.weight)
    assert values["target/rotation"] == said.target.speed
    assert values["regime"] == Regime.FORWARD.code


def test_its_message_is_finite_outside_the_map_and_without_advice():
    for said in (None, adviser().advise(1e4, 10.0, whirls=True)):
        state = read_joint_state(encode_advice(0, said, math.nan, 10.0, whirls=True))
        assert np.isfinite(state.position).all()
        assert (state.position[0] == AdviceCode.NONE) == (said is None)
        assert state.position[state.index("regime")] == -1.0
