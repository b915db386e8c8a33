# SPDX-License-Identifier: Apache-2.0
"""Advice and operating map on the page: the scene's are shown, and nothing of a hostile node."""

import json
import math

import pytest

from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.io.messages.topics import ADVICE_MAP, ADVICE_STATE, DIAGNOSTICS, TWIN_SCENE
from drill_twin.scene import load_scene
from drill_twin_dashboard.live.page_state import PageState
from drill_twin_dashboard.live.shown import Sources
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span
from drill_twin_studies.maps.advice import Advice, AdvisedSetPoint, encode_advice
from drill_twin_studies.maps.drawing import lattice_data
from drill_twin_studies.maps.operating_map import Margin
from drill_twin_studies.maps.runs import Key, RunRecord

SCENE = load_scene("pa6_bench")


LEAVE = Advice(
    Level.ERROR, "", Regime.FORWARD, keeps=True, boundary="", margin=Margin(-20.0, math.inf, -0.25),
    target=AdvisedSetPoint(20.0, 1.5 * math.tau, 0.1),
)  # fmt: skip


def lattice(steps=8, beyond=Regime.FORWARD):
    """Calm on the lower half, another regime beyond."""
    plane = Plane(Span(0.0, 80.0), Span(0.0, 4.0 * math.pi), steps)
    nodes = [(i, j) for i in range(steps + 1) for j in range(steps + 1)]
    runs = {Key(*node): RunRecord(beyond if 2 * node[0] > steps else Regime.SMOOTH) for node in nodes}
    return lattice_data(OperatingMap(SCENE.name, digest_of(SCENE), SCENE.to_yaml(), plane, 10.0, (), runs))


@pytest.mark.parametrize("first", [ADVICE_MAP, TWIN_SCENE])
def test_map_and_advice_are_shown_in_whatever_order_they_come(first):
    page = PageState(Sources())
    messages = {ADVICE_MAP: encode_string(json.dumps(lattice())), TWIN_SCENE: encode_string(SCENE.to_yaml())}
    for topic in sorted(messages, key=lambda topic: topic != first):
        page.update(topic, messages[topic])
    page.update(ADVICE_STATE, encode_advice(0, LEAVE, 60.0, math.tau, whirls=False))
    page.update(DIAGNOSTICS, encode_diagnostics(0, [Status("rig2/advisor", Level.WARN, "go to 20 N")]))
    picture = page.snapshot()
    assert picture["advice"] == {"text": "go to 20 N", "level": 2, "wob": 20.0, "rps": 1.5}
    assert (picture["map"]["wob"], picture["map"]["rps"]) == ([0.0, 80.0], [0.0, 2.0])
    assert picture["map"]["window"] == [0.0, 40.0, 0.0, 2.0]
    assert (picture["map"]["codes"].count("0"), picture["map"]["codes"].count(str(Regime.FORWARD.code))) == (45, 36)


def test_the_kinds_beyond_ten_have_one_digit_each_too():
    page = PageState(Sources())
    page.update(TWIN_SCENE, encode_string(SCENE.to_yaml()))
    page.update(ADVICE_MAP, encode_string(json.dumps(lattice(beyond=Regime.ROLLING))))
    shown = page.snapshot()["map"]
    assert (len(shown["codes"]), shown["codes"].count("b")) == (81, 36)
    assert shown["regimes"][int("b", 16)] == "rolling along the wall"
    assert len(shown["colours"]) == len(shown["regimes"])


def test_another_scene_takes_the_map_away():
    page = PageState(Sources())
    page.update(ADVICE_MAP, encode_string(json.dumps(lattice())))
    other = load_scene("pa6_bench", overrides={"hole.radius": "80 mm"})
    page.update(TWIN_SCENE, encode_string(other.to_yaml()))
    assert page.snapshot()["map"] is None


def test_a_fine_map_is_thinned_out():
    page = PageState(Sources())
    page.update(ADVICE_MAP, encode_string(json.dumps(lattice(128))))
    assert len(page.snapshot()["map"]["codes"]) == 65**2


@pytest.mark.parametrize(
    "change",
    [
        {"steps": 9}, {"steps": 10**9}, {"steps": math.inf}, {"codes": "9"}, {"codes": "x" * 81}, {"regimes": None},
        {"weight_on_bit_N": [1.0, 1.0]}, {"rotation_rad_s": [0.0, math.inf]}, {"safe_window": ["a"]}, {"digest": ...},
    ],
)  # fmt: skip
def test_what_is_no_map_is_skipped_and_counted(change):
    page = PageState(Sources())
    data = {name: value for name, value in (lattice() | change).items() if value is not ...}
    page.update(ADVICE_MAP, encode_string(json.dumps(data)))
    assert page.snapshot()["map"] is None
    assert ADVICE_MAP in page.skipped


def test_odd_names_and_targets_are_plain():
    page = PageState(Sources())
    page.update(ADVICE_MAP, encode_string(json.dumps(lattice() | {"regimes": ["\x1b[2J" * 100] * 100})))
    odd = JointStateTemplate(
        ("advice", "target", "target/weight_on_bit", "target/rotation"), velocity=False, effort=False
    )
    page.update(ADVICE_STATE, odd.fill(0, [math.nan, math.inf, math.nan, 1e300]))
    page.update(DIAGNOSTICS, encode_diagnostics(0, [Status("advisor", Level.OK, "\n" * 10_000)]))
    picture = page.snapshot()
    assert len(json.dumps(picture, allow_nan=False)) < 8_000
    assert all(name.isprintable() for name in picture["map"]["regimes"])
    assert set(picture["advice"]) == {"text", "level"}
