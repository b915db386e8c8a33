# SPDX-License-Identifier: Apache-2.0
"""Markers of a curved hole: points on its axis stay there, distances from the axis are exaggerated."""

from types import SimpleNamespace

import numpy as np
import pytest
from companion_parts import part

from drill_twin.core.compile.jit import as_python
from drill_twin.io.messages.cdr import PoseArrayTemplate
from drill_twin.io.messages.drawing.geometry import ExaggeratedGeometry, StringGeometry
from drill_twin.io.messages.drawing.markers import MarkerArrayTemplate
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topic_row import MARKER_ARRAY
from drill_twin.io.messages.topics import STRING_POSES, TWIN_SCENE
from drill_twin.io.messages.type_store import deserialize
from drill_twin.io.scene_geometry import hole_steps, string_steps
from drill_twin.physics.model.strain import transverse_axes
from drill_twin.physics.model.survey import survey
from drill_twin.physics.model.wellbore import (
    axis_offset,
    distance_along,
    from_hole_coordinates,
    offsets,
    to_hole_coordinates,
)
from drill_twin.report.string_curve import along_hole
from drill_twin.scene import load_scene, parse_scene

PAGE = part("drill_twin_dashboard.live.page_state")

FACTOR = 20.0
DEPTHS = np.array([0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0])


@pytest.fixture(scope="module")
def line():
    """Straight down, then a build with a turn, then a straight tangent."""
    return survey(np.array([0.0, 40.0, 110.0, 200.0]), np.radians([0.0, 0.0, 35.0, 35.0]), np.radians([0.0, 0, 40, 40]))


@pytest.fixture(scope="module")
def off(line):
    """Places beside the axis and a little along it."""
    random = np.random.default_rng(3)
    return line.at(DEPTHS).centre + random.uniform(-0.5, 0.5, (DEPTHS.size, 3))


def test_places_are_seen_as_the_contact_sees_them(line, off):
    axis = line.at(DEPTHS)
    here = offsets(axis, off)
    for k, place in enumerate(off):
        foot = as_python(axis_offset)(axis, k, *place)
        np.testing.assert_allclose(here.off[k], [foot.x, foot.y, foot.z], atol=1e-9)
        np.testing.assert_allclose(here.tangent[k], [foot.tx, foot.ty, foot.tz], atol=1e-12)
        assert here.along[k] == pytest.approx(as_python(distance_along)(axis, k, *place), abs=1e-9)


def test_what_is_unrolled_can_be_rolled_again(line, off):
    axis = line.at(DEPTHS)
    flat = to_hole_coordinates(axis, off)
    np.testing.assert_allclose(from_hole_coordinates(axis, flat), off, atol=1e-9)
    sideways = np.linalg.norm(offsets(axis, off).off, axis=1)
    np.testing.assert_allclose(np.hypot(flat[:, 0], flat[:, 1]), sideways, atol=1e-9)
    ex, ey = transverse_axes(axis.tangent)
    np.testing.assert_allclose(np.cross(ex, ey), axis.tangent, atol=1e-12)


@pytest.fixture(scope="module")
def geometry(line):
    marks = (50.0, 120.0)
    hole, string = ((0.0, 180.0, 0.15),), ((0.0, 180.0, 0.1),)
    return StringGeometry(180.0 - DEPTHS, ("low", "high"), marks, 180.0, 0.1, 0.15, hole, string, line.at)


def test_lateral_motion_is_widened_about_the_axis(line, off, geometry):
    widened = ExaggeratedGeometry(geometry, FACTOR)
    axis = line.at(DEPTHS)
    np.testing.assert_allclose(widened.nodes(axis.centre), axis.centre, atol=1e-9)
    wide, narrow = offsets(axis, widened.nodes(off)), offsets(axis, off)
    np.testing.assert_allclose(wide.off, FACTOR * narrow.off, atol=1e-6)
    np.testing.assert_allclose(wide.along, narrow.along, atol=1e-6)
    at_marks = line.at(np.array([130.0, 60.0]))
    on_axis = np.stack((np.zeros(2), np.zeros(2), at_marks.along), axis=1)
    np.testing.assert_allclose(widened.marks(on_axis), at_marks.centre, atol=1e-6)


def test_the_wall_and_its_rings_follow_the_hole(line, geometry):
    axis = line.at(DEPTHS)
    picture = MarkerArrayTemplate(geometry, FACTOR)
    marks = np.array([[[0.0, 0.0, -130.0], [0.0, 0.0, -60.0]]])
    raw = picture.rows([0], axis.centre[None], marks, np.zeros((1, 7)))[0]
    markers = {(marker.ns, marker.id): marker for marker in deserialize(raw, MARKER_ARRAY).markers}
    wall = np.array([[p.x, p.y, p.z] for p in markers["hole", 0].points])
    assert np.linalg.norm(wall - line.at(np.linspace(0.0, 180.0, len(wall))).centre, axis=1).max() < 1e-9
    ring = np.array([[p.x, p.y, p.z] for p in markers["hole", 1].points]).reshape(-1, 64, 3)
    for circle in (ring[0], ring[-1]):
        centre = circle.mean(axis=0)
        np.testing.assert_allclose(np.linalg.norm(circle - centre, axis=1), FACTOR * 0.15, rtol=1e-9)
    np.testing.assert_allclose(ring[-1].mean(axis=0), axis.centre[-1], atol=1e-9)
    np.testing.assert_allclose((ring[-1] - axis.centre[-1]) @ axis.tangent[-1], 0.0, atol=1e-9)


def test_a_report_sees_the_string_along_the_hole():
    scene = load_scene("pa6_bench")
    curves = np.zeros((2, 5, 3))
    assert along_hole(scene, curves) is curves  # a straight hole is so already
    length = scene.length
    stations = [SimpleNamespace(depth=d, inclination=i, azimuth=0.0) for d, i in ((0.0, 0.0), (length, 0.4))]
    bent = scene.model_copy(update={"hole": scene.hole.model_copy(update={"survey": stations})})
    line = survey(np.array([0.0, length]), np.array([0.0, 0.4]), np.zeros(2))
    centres = line.at(np.linspace(length, 0.0, 5)).centre
    flat = along_hole(bent, centres[None])
    np.testing.assert_allclose(flat[0, :, :2], 0.0, atol=1e-9)
    np.testing.assert_allclose(flat[0, :, 2], -np.linspace(length, 0.0, 5), atol=1e-3)


CURVED = """\
base: pa6_bench
hole:
  survey:
    - {depth: 0 m, inclination: 0 deg}
    - {depth: 5 m, inclination: 20 deg}
"""


def test_the_page_of_watch_has_the_string_along_the_hole_and_the_hole_as_it_is_drilled():
    page = PAGE.PageState()
    scene = parse_scene(CURVED, name="curved")
    page.update(TWIN_SCENE, encode_string(scene.to_yaml()))
    line = survey(np.array([0.0, 5.0]), np.radians([0.0, 20.0]), np.zeros(2))
    nodes = line.at(np.linspace(5.0, 0.0, 11)).centre
    assert np.abs(nodes[:, 0]).max() > 0.5  # far more than the hole is wide
    page.update(STRING_POSES, PoseArrayTemplate(11).fill(10**9, nodes, np.tile([0.0, 0.0, 0.0, 1.0], (11, 1))))
    picture = page.snapshot()
    well = picture["scene"]["well"]
    assert well["deviated"]
    radius = 5.0 / np.radians(20.0)
    angle = np.radians(20.0)
    assert well["centre"][-1] == pytest.approx([radius * (1.0 - np.cos(angle)), 0.0, radius * np.sin(angle)], abs=1e-3)
    assert picture["scene"]["string"] == ((0.0, 5.0, 0.00825),)
    assert set(picture["scene"]["walls"].values()) == {0.09}
    np.testing.assert_allclose(np.array(picture["nodes"])[:, :2], 0.0, atol=1e-6)
    np.testing.assert_allclose(np.array(picture["nodes"])[:, 2], -np.linspace(5.0, 0.0, 11), atol=1e-3)
    page.update(TWIN_SCENE, encode_string(load_scene("pa6_bench").to_yaml()))
    assert not page.snapshot()["scene"]["well"]["deviated"]


STEPS = {
    "hole.intervals": "[{top: 1 m, bottom: 2 m, radius: 120 mm}]",
    "string.sections": str([
        {"length": f"{length} m", "outer_diameter": "16.5 mm", "youngs_modulus": "2.8 GPa", "poisson_ratio": 0.4,
         "density": "1140 kg/m^3", **more}
        for length, more in ((1, {"blade_diameter": "60 mm"}), (4, {"joints": {"spacing": "2 m", "length": "0.5 m",
         "diameter": "30 mm"}}))
    ]),
}  # fmt: skip


def test_hole_and_string_have_their_radius_at_every_depth():
    scene = load_scene("pa6_bench", overrides=STEPS)
    assert hole_steps(scene) == ((0.0, 1.0, 0.09), (1.0, 2.0, 0.12), (2.0, 5.0, 0.09))
    assert string_steps(scene) == tuple(
        (pytest.approx(begin), pytest.approx(end), pytest.approx(radius))
        for begin, end, radius in ((0, 1, 0.03), (1, 2.5, 0.00825), (2.5, 3, 0.015), (3, 4.5, 0.00825), (4.5, 5, 0.015))
    )
    arc = np.linspace(0.0, 5.0, 11)
    geometry = StringGeometry(arc, (), (), 5.0, 0.03, 0.09, hole_steps(scene), string_steps(scene))
    nodes = np.stack((0.01 * arc, 0.0 * arc, arc - 5.0), axis=1)
    raw = MarkerArrayTemplate(geometry, 2.0).rows([0], nodes[None], np.zeros((1, 0, 3)), np.zeros((1, 11)))[0]
    markers = deserialize(raw, MARKER_ARRAY).markers
    walls = [m for m in markers if m.ns == "hole" and m.type == 3]
    assert sorted((m.pose.position.z, m.scale.x, m.scale.z) for m in walls) == [
        (-3.5, 0.36, 3.0), (-1.5, 0.48, 1.0), (-0.5, 0.36, 1.0),
    ]  # fmt: skip
    strings = [m for m in markers if m.ns == "string"]
    assert [m.scale.x for m in strings] == pytest.approx([0.12, 0.033, 0.06, 0.033, 0.06])
    assert [(m.points[0].z, m.points[-1].z) for m in strings] == [
        (-5, -4),
        (-4, -2.5),
        (-2.5, -2),
        (-2, -0.5),
        (-0.5, 0),
    ]
    assert all(p.x == pytest.approx(0.02 * (p.z + 5.0)) for m in strings for p in m.points)
    assert len({(m.ns, m.id) for m in markers}) == len(markers)


def test_thousands_of_joints_are_one_interval():
    joints = {"spacing": "10 mm", "length": "5 mm", "diameter": "30 mm"}
    section = {"length": "5 m", "outer_diameter": "16.5 mm", "youngs_modulus": "2.8 GPa", "poisson_ratio": 0.4,
               "density": "1140 kg/m^3", "joints": joints}  # fmt: skip
    assert string_steps(load_scene("pa6_bench", overrides={"string.sections": str([section])})) == ((0.0, 5.0, 0.015),)
