# SPDX-License-Identifier: Apache-2.0
"""Severity and specific energy of motions that are known in closed form."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from summaries import summarise

import drill_twin as dt
from drill_twin.core.errors import SceneError
from drill_twin.core.severity import DEFAULT, Grade, Severity, grade, told
from drill_twin.core.units.system import SYSTEMS
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.report import severity as severities
from drill_twin.report.load_text import severity_rows
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection
from drill_twin.report.severity import severity
from drill_twin.report.string_forces import JOINT, fibre_stress, force_on_joint
from drill_twin.scene import load_scene, parse_scene
from drill_twin.whirl.severity import accelerations, sizes, turns_backwards

GRAVITY = 9.80665
OWN = """
severity:
  source: manual of the tool, table 3
  lateral_rms: [0.5 g, 0.04 g, 0.6 g, 1 g]
""".replace("0.5 g, 0.04 g", "0.01 g, 0.02 g")


@pytest.mark.parametrize(
    ("quantity", "value", "expected"),
    [("lateral_rms", 0.49 * GRAVITY, 0), ("lateral_rms", 0.5 * GRAVITY, 1), ("lateral_peak", 1e6, 4),
     ("bending_stress", 150e6, 3), ("stick_slip", 1.0, 3), ("stick_slip", math.nan, None)],
)  # fmt: skip
def test_a_quantity_has_the_grade_of_the_highest_bound_that_it_reaches(quantity, value, expected):
    assert grade(quantity, value) == expected


@pytest.mark.parametrize(
    ("quantity", "value", "units", "text"),
    [("lateral_rms", 2.6 * GRAVITY, "lab", "medium: lateral acceleration 2.6 g rms at mark_2"),
     ("lateral_peak", 104.0 * GRAVITY, "si", "severe: lateral acceleration 104 g peak at mark_2"),
     ("bending_stress", 20e3 * 6894.757, "field", "medium: bending stress 20 ksi at mark_2"),
     ("stick_slip", 1.234, "si", "severe: stick-slip index 1.23 at mark_2")],
)  # fmt: skip
def test_severity_is_told_with_what_decided_it(quantity, value, units, text):
    found = Severity(grade(quantity, value), quantity, value, "mark_2")
    assert told(found.entry, SYSTEMS[units]) == text
    assert told({**found.entry, "why": "why it is"}, SYSTEMS[units]) == f"{text} (why it is)"
    assert told(None, SYSTEMS[units]) == "unknown"


def test_acceleration_of_two_circular_motions(known_bag):
    found = severity(read_recording(known_bag))
    expected = [(2.0 * math.pi * rate) ** 2 * radius for rate, radius in ((2.0, 0.001), (0.6, 0.030))]  # Hz, m
    for mark in found["acceleration"].values():
        assert mark["lateral_rms_m_s2"] == pytest.approx(math.hypot(*expected), rel=1e-2)
        assert mark["lateral_peak_m_s2"] == pytest.approx(sum(expected), rel=5e-3)
        assert mark["axial_rms_m_s2"] == pytest.approx(0.0, abs=1e-6)
    assert found["acceleration_rate_hz"] == pytest.approx(100.0)
    assert found["rate_of_penetration_m_s"] is None  # this bit does not drill
    assert (found["severity"]["grade"], found["severity"]["word"]) == (0, "none")
    assert found["severity_by_quantity"]["lateral_rms"]["grade"] is Grade.NONE
    assert found["severity_source"] is None


def test_bounds_of_the_scene_take_the_place_of_this_programs_and_their_source_is_told(known_bag):
    scene = parse_scene(load_scene("pa6_bench").to_yaml() + OWN)
    recording = read_recording(known_bag, scene)
    found = summarise(recording)
    assert found["severity"]["word"] == "medium"  # 0.046 g
    assert found["severity"]["quantity"] == "lateral_rms"
    rows = dict(severity_rows(found))
    assert rows["severity"].startswith("medium: lateral acceleration 0.046 g rms at mark_")
    given = "manual of the tool, table 3, for lateral acceleration rms"
    assert rows["bounds of severity"] == f"{given}; for the others of this program, not of a vendor"
    assert parse_scene(scene.to_yaml()).severity.whose == scene.severity.whose
    assert parse_scene(scene.to_yaml()) == scene
    assert rows["bending stress"].endswith(": not graded (its bounds are of steel)")  # PA6, of no bounds here
    assert "not graded" in rows["wall force on 30 ft"]


def test_bounds_of_all_quantities_have_the_source_alone():
    block = {"source": "manual", **{key: list(values) for key, values in DEFAULT._asdict().items()}}
    assert dt.load_scene("pa6_bench", {"severity": block}).severity.whose == "manual"


@pytest.mark.parametrize(
    ("block", "message"),
    [({"source": "manual"}, "severity: expected bounds of a quantity beside their source, found none"),
     ({"source": "", "stick_slip": [1, 2, 3, 4]}, "severity.source: expected text, found none"),
     ({"source": "x", "stick_slip": [1, 2, 3]}, "severity.stick_slip: expected at least 4 items, found 3"),
     ({"source": "x", "stick_slip": [1, 2, 3, 4, 5]}, "severity.stick_slip: expected at most 4 items, found 5"),
     ({"source": "x", "lateral_rms": ["1 g", "2 g", "2 g", "3 g"]}, "found 9.80665, 19.6133, 19.6133, 29.42 m/s^2")],
)  # fmt: skip
def test_bounds_that_cannot_be_say_what_was_expected_and_found(block, message):
    with pytest.raises(SceneError, match=re.escape(message)):
        dt.load_scene("pa6_bench", {"severity": block})


def test_a_page_says_once_whose_the_bounds_are(known_report):
    page = known_report.page.read_text("utf-8")
    assert page.count("not of a vendor") == page.count("for tools of the field, not of a bench") == 1
    assert "<b>severity none</b><span>decided by lateral acceleration " in page
    assert "level 0" not in page


def test_of_few_samples_in_a_revolution_no_acceleration_is_told(known_bag, write, messages):
    sparse = [row for k, row in enumerate(messages) if k == 0 or row[1] % 160_000_000 == 0]  # 3.1 in a revolution
    found = severity(read_recording(write(sparse)))
    assert found["acceleration"] == {}
    for name in ("lateral_rms", "axial_peak"):
        row = found["severity_by_quantity"][name]
        assert (row["grade"], row["value"]) == (None, None)
        assert row["why"].endswith("samples in a revolution, 4 are needed")
    summary = summarise(read_recording(write(sparse, "again")))
    assert summary["severity"]["word"] == "none"
    assert re.fullmatch(
        r"none of what is known: stick-slip index \S+; lateral acceleration unknown \([\d.]+ samples in a rev.*\)",
        told(summary["severity"], SYSTEMS["si"]),
    )
    assert "lateral acceleration rms, lateral acceleration peak, axial" in dict(severity_rows(summary))["unknown"]


def test_acceleration_is_taken_between_even_steps_only():
    time = np.delete(np.arange(0.0, 5.0, 0.01), [200, 201, 202])
    step, found = accelerations(time, np.exp(3.0j * time)[:, None])
    assert step == pytest.approx(0.01)
    assert sizes(found[:, 0]) == pytest.approx((9.0, 9.0), rel=1e-3)
    assert len(found) == time.size - 4
    assert np.isnan(sizes(accelerations(time[:2], np.zeros((2, 1)))[1])).all()
    assert np.isnan(sizes(np.full(5, np.nan))).all()
    assert turns_backwards([1.0, -0.1, -0.4, 0.4, -9.0], [6.0, 6.0, 6.0, -6.0, 0.1]).tolist() == [
        False, False, True, True, False
    ]  # fmt: skip


def bent(scene, curvature, turned):
    """Recording of a string on an arc towards x at poses, with the material turned [rad]."""
    rod = mesh(scene, 40)
    arc = rod.arc - scene.length
    shape = np.stack([0.5 * curvature * rod.arc**2, 0.0 * arc, arc], axis=-1)
    tangent = np.stack([curvature * rod.arc, 0.0 * arc, np.ones_like(arc)], axis=-1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    k = len(turned)
    poses = SimpleNamespace(
        position=np.broadcast_to(shape, (k, *shape.shape)), tangent=np.broadcast_to(tangent, (k, *shape.shape)),
        spin=np.broadcast_to(np.asarray(turned)[:, None], (k, arc.size)), time=np.arange(k) * 0.01,
    )  # fmt: skip
    return SimpleNamespace(scene=scene, nodes=arc.size, poses=poses, rig=())


def test_a_fibre_of_a_bent_string_that_turns_goes_from_pull_to_push_and_of_one_that_stands_does_not():
    scene, curvature = load_scene("pa6_bench"), 0.01
    section = scene.string.sections[0]
    expected = section.youngs_modulus * 0.5 * section.outer_diameter * curvature
    turns = np.linspace(0.0, 6.0 * math.pi, 200)
    half, _, stress = fibre_stress(bent(scene, curvature, turns), np.arange(200))
    assert half == pytest.approx(expected, rel=0.02)
    assert np.ptp(stress) == pytest.approx(2.0 * half)
    half, _, _ = fibre_stress(bent(scene, curvature, np.zeros(200)), np.arange(200))
    assert half == pytest.approx(0.0, abs=1e-6 * expected)


@pytest.mark.parametrize("nodes", [41, 81])
def test_the_wall_force_of_a_joint_does_not_depend_on_the_mesh(nodes):
    """A string in the wall by the same depth everywhere: the force on 30 ft is that on a metre times 9.144."""
    scene = load_scene("pa6_bench")
    rod = mesh(scene, nodes - 1)
    arc = rod.arc - scene.length
    position = np.stack([np.full_like(arc, scene.hole.radius), 0.0 * arc, arc], axis=-1)
    up = np.broadcast_to([0.0, 0.0, 1.0], position.shape)
    poses = SimpleNamespace(position=position[None], tangent=up[None], spin=np.zeros((1, nodes)), time=np.zeros(1))
    found, place = force_on_joint(SimpleNamespace(scene=scene, nodes=nodes, poses=poses, rig=()), np.arange(1))
    wall, depth = scene.effects.wall, 0.5 * scene.string.sections[0].outer_diameter
    assert scene.length < JOINT
    assert found == pytest.approx(wall.stiffness * depth**1.5 * scene.length, rel=0.02)
    assert 0.0 < place < scene.length


def test_whose_units_are_in_the_reader_s_system(known_bag):
    found = summarise(read_recording(known_bag, selection=Selection(units="field")))
    assert re.search(
        r" at \w+, [\d.]+ ft from the bit.*: not graded \(its bounds are of steel",
        dict(severity_rows(found))["bending stress"],
    )
    assert found["severity_by_quantity"]["bending_stress"]["grade"] is None
    assert DEFAULT.lateral_rms[0] == 0.5 * GRAVITY


@pytest.mark.parametrize(("speed", "drills"), [(0.0, False), (0.1, False), (1.0, True)])
def test_a_bit_that_does_not_turn_round_drills_nothing(monkeypatch, speed, drills):
    """A run at 0 rpm printed 5e-8 ft/h: the bit sinks in by the wave of the start."""
    monkeypatch.setattr(severities, "settled_from", lambda _: 0.0)
    time, one = np.linspace(0.0, 10.0, 11), np.ones(11)
    rig = SimpleNamespace(time=time, drilled=1e-6 * time, bit_speed=speed * one, bit_torque=-one, bit_force=one)
    found = severities._drilling(SimpleNamespace(rig=rig, scene_known=False))
    assert (found["rate_of_penetration_m_s"] is not None) is drills
