# SPDX-License-Identifier: Apache-2.0
"""Curves between nodes are exact for cubics, and pass through the nodes of any other shape."""

import numpy as np
import pytest

from drill_twin.dynamics.discretisation.discretise import survey_of
from drill_twin.io.messages.drawing.transforms import orientation, tangent_of
from drill_twin.report.string_curve import FINEST, low_side, smooth
from drill_twin.scene import load_scene


def test_tangents_come_back_from_orientations(make_frame):
    frame = make_frame(nodes=17)
    turned = orientation(frame.tangents, frame.spin)
    assert tangent_of(turned) == pytest.approx(frame.tangents, abs=1e-12)


def test_straight_string_stays_straight():
    nodes = np.linspace([0.0, 0.0, -5.0], [0.0, 0.0, 0.0], 9)[None]
    up = np.broadcast_to([0.0, 0.0, 1.0], nodes.shape)
    curve = smooth(nodes, up)
    assert np.abs(curve[..., :2]).max() == 0.0
    assert (np.diff(curve[0, :, 2]) > 0.0).all()
    assert curve.shape[1] == FINEST // 8 * 8 + 1


def test_arc_of_a_circle_is_met_to_a_thousandth():
    angle = np.linspace(0.0, 2.0, 6)
    nodes = np.stack((np.cos(angle), np.sin(angle), np.zeros(6)), axis=1)[None]
    along = np.stack((-np.sin(angle), np.cos(angle), np.zeros(6)), axis=1)[None]
    curve = smooth(nodes, along)
    assert np.linalg.norm(curve, axis=-1) == pytest.approx(1.0, abs=1e-3)
    assert curve[0, :: (curve.shape[1] - 1) // 5] == pytest.approx(nodes[0], abs=1e-12)


def test_fine_mesh_is_drawn_as_it_is(make_frame):
    frame = make_frame(nodes=150)
    assert smooth(frame.positions[None], frame.tangents[None]) == pytest.approx(frame.positions[None])


def test_low_side_is_where_gravity_points():
    built = {"hole.survey": "[{depth: 0 m, inclination: 0 deg}, {depth: 5 m, inclination: 20 deg, azimuth: 40 deg}]"}
    straight = {"hole.inclination": "60 deg"}
    depth = np.array([0.0, 2.5, 5.0])
    assert np.abs(low_side(load_scene("pa6_bench"), depth)).max() == 0.0
    low, angle = low_side(load_scene("pa6_bench", overrides=straight), depth)
    assert low == pytest.approx(np.sin(np.radians(60.0)))
    assert angle == pytest.approx(np.radians(60.0))
    scene = load_scene("pa6_bench", overrides=built)
    found, angle = low_side(scene, depth)
    assert angle == pytest.approx(np.radians([0.0, 10.0, 20.0]), abs=1e-9)
    assert np.abs(found) == pytest.approx(np.sin(angle), abs=1e-9)
    down = survey_of(scene.hole).down[-1]  # the hole builds towards where it leads, so the low side is opposite
    assert found[-1] * abs(complex(*down[:2])) == pytest.approx(-abs(found[-1]) * complex(*down[:2]))
