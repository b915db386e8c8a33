# SPDX-License-Identifier: Apache-2.0
"""The hole and the sections of a scene: what they mean, and mistakes in them told in one line."""

import numpy as np
import pytest

from drill_twin.physics.model.survey import dogleg, survey

HOLE = "  radius: 90 mm\n"
TUBE = "density: 1.10 g/cm^3\n"
SURVEY = """  radius: 90 mm
  survey:
    - {depth: 0 m, inclination: 10 deg}
    - {depth: 3 m, inclination: 20 deg, azimuth: 5 deg}
    - {depth: 5 m, inclination: 25 deg}
"""
WIDE = "  intervals: [{top: 1 m, bottom: 2 m, radius: 10 cm}, {top: 2 m, bottom: 3 m, radius: 5 cm}]\n"

MISTAKES = [
    # what replaces the hole, what the message must say
    (SURVEY.replace("depth: 0 m", "depth: 1 m"), "hole.survey[0].depth: expected 0 m, the top clamp"),
    (SURVEY.replace("depth: 3 m", "depth: 5 m"), "hole.survey[2].depth: expected more than the station above it (5 m)"),
    (SURVEY.replace("depth: 5 m", "depth: 4 m"), "expected the last station at or below the bit (5 m), found 4 m"),
    (SURVEY.replace("20 deg", "140 deg"), "hole.survey[1]: expected a turn of at most"),
    (SURVEY + "  inclination: 3 deg\n", "hole.inclination: expected no `inclination` beside a `survey`"),
    (SURVEY.replace("10 deg", "190 deg"), "hole.survey[0].inclination: expected an angle, at least 0 deg"),
    ("  radius: 90 mm\n  survey: [{depth: 0 m, inclination: 1 deg}]\n", "expected at least two stations, found one"),
    (HOLE + WIDE.replace("top: 2 m", "top: 1.5 m"), "hole.intervals[1].top: expected at least 2 m"),
    (HOLE + WIDE.replace("bottom: 2 m", "bottom: 1 m"), "hole.intervals[0].bottom: expected more than its top (1 m)"),
    (HOLE + WIDE.replace("5 cm", "8 mm"), "outer_diameter: expected less than the diameter of the hole (0.016 m)"),
]  # fmt: skip


@pytest.mark.parametrize(("hole", "words"), MISTAKES, ids=[words[:40] for _, words in MISTAKES])
def test_a_mistake_in_the_hole(refusal, hole, words):
    assert words in refusal(HOLE, hole)


SECTIONS = [
    ("      blade_diameter: 16 mm\n", "blade_diameter: expected at least the outer diameter (0.0165 m), found 0.016 m"),
    ("      blade_diameter: 18 cm\n", "blade_diameter: expected less than the diameter of the hole (0.18 m)"),
    ("      joints: {spacing: 1 m, length: 1 m, diameter: 2 cm}\n", "joints.length: expected less than the spacing"),
    ("      joints: {spacing: 1 m, length: 1 cm, diameter: 1 cm}\n", "joints.diameter: expected at least the outer"),
    ("      joints: {spacing: 1 m, length: 1 cm, diameter: 18 cm}\n", "joints.diameter: expected less than the"),
    ("      joints: {spacing: 6 m, length: 1 cm, diameter: 2 cm}\n", "joints.spacing: expected between 1 and 2000"),
    ("      joints: {spacing: 1 mm, length: 0.1 mm, diameter: 2 cm}\n", "joints.spacing: expected between 1 and 2000"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "words"), SECTIONS, ids=[words[:40] for _, words in SECTIONS])
def test_a_mistake_in_a_section(refusal, line, words):
    assert words in refusal(TUBE, TUBE + line)


@pytest.mark.parametrize(
    ("wall", "words"),
    [
        ("{stiffness: 1e7 N/m^2.5, linear_stiffness: 1e6 N/m^2}", "found both"),
        ("{restitution: 0.5}", "found neither"),
        ("{linear_stiffness: 1e6 N/m^2.5}", "expected a stiffness per length"),
        ("{stiffness: 1e7 N/m^2.5, restitution: 0}", "at least 0.01"),
    ],
)
def test_a_mistake_in_the_wall(refusal, wall, words):
    assert words in refusal("{stiffness: 1e7 N/m^2.5}", wall)


def test_a_survey_needs_the_string_in_space(refusal):
    message = refusal(HOLE, SURVEY, {"effects.stretch": "off", "effects.torsion": "off"})
    assert "hole.survey: expected `stretch` and `torsion` to be listed with a survey" in message


def test_the_clearance_follows_hole_and_section(changed):
    scene = changed(HOLE, HOLE + WIDE)
    radius = 0.00825
    found = [scene.clearance_at(5.0 - depth) for depth in (0.5, 1.5, 2.5, 3.5)]
    assert found == pytest.approx([0.09 - radius, 0.1 - radius, 0.05 - radius, 0.09 - radius])
    blades = changed(TUBE, TUBE + "      blade_diameter: 3 cm\n")
    assert blades.clearance_at(1.0) == pytest.approx(0.09 - 0.015)
    assert blades.mark_table[0].wall_offset == 0.015


def test_a_joint_ends_each_spacing(changed):
    scene = changed(TUBE, TUBE + "      joints: {spacing: 2 m, length: 20 cm, diameter: 2 cm}\n")
    assert [piece.length for piece in scene.string.pieces] == pytest.approx([1.8, 0.2, 1.8, 0.2, 1.0])
    assert [scene.outer_radius_at(s) for s in (1.7, 1.9, 2.1, 3.9, 4.5)] == [0.00825, 0.01, 0.00825, 0.01, 0.00825]


def test_minimum_curvature_of_a_published_leg():
    """The worked example of drillingformulas.com: 3500 ft, 15 deg, N 20 E to 3600 ft, 25 deg, N 45 E.

    27.22 ft north, 19.45 ft east, 94.01 ft down; the dogleg is 12.95 deg.
    """
    degrees = np.radians
    inclination, azimuth = degrees(np.array([15.0, 25.0])), degrees(np.array([20.0, 45.0]))
    assert np.degrees(dogleg(inclination, azimuth)) == pytest.approx([12.95], abs=0.01)
    line = survey(np.array([0.0, 100.0]), inclination, azimuth)
    ci, si, ca, sa = np.cos(inclination[0]), np.sin(inclination[0]), np.cos(azimuth[0]), np.sin(azimuth[0])
    axes = np.array([[-ci * ca, -ci * sa, si], [-sa, ca, 0.0], [-si * ca, -si * sa, -ci]])
    assert line.position[1] @ axes == pytest.approx([27.22, 19.45, 94.01], abs=0.01)


def test_an_arc_is_followed_exactly():
    """Half-way along a quarter circle of radius 100 m, and beyond its end straight on."""
    line = survey(np.array([0.0, 50.0 * np.pi]), np.array([0.0, 0.5 * np.pi]), np.array([0.0, 0.0]))
    axis = line.at(np.array([25.0 * np.pi, 50.0 * np.pi + 7.0]))
    half = 100.0 * np.sqrt(0.5)
    assert axis.centre[0] == pytest.approx([-(100.0 - half), 0.0, -half])
    assert axis.centre[1] == pytest.approx([-107.0, 0.0, -100.0])
    assert axis.tangent[0] == pytest.approx([np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    assert axis.curvature == pytest.approx([0.01, 0.0])
