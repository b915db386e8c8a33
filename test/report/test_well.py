# SPDX-License-Identifier: Apache-2.0
"""The well is drawn as it is drilled, with the string at its size where it lies."""

import numpy as np
import pytest

from drill_twin.report import draw
from drill_twin.report.recording import read_recording
from drill_twin.scene import load_scene

STATIONS = ((0, 0), (2, 0), (5, 60))
CURVED = {
    "hole.survey": str([{"depth": f"{depth} m", "inclination": f"{angle} deg"} for depth, angle in STATIONS]),
    "hole.intervals": "[{top: 0 m, bottom: 1 m, radius: 120 mm}]",
}


@pytest.fixture(scope="module")
def curved(known_bag):
    return draw("well", read_recording(known_bag, load_scene("pa6_bench", overrides=CURVED)))


def test_section_has_the_depth_and_the_way_of_the_well(curved):
    section = curved.axes[0]
    hole = next(patch for patch in section.patches if patch.get_label() == "hole").get_xy()
    left, right = np.array_split(hole[:-1], 2)
    axis = 0.5 * (left + right[::-1])
    arc = 3.0 / np.radians(60.0)
    assert axis[0] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert axis[-1] == pytest.approx([arc * 0.5, 2.0 + arc * np.sin(np.radians(60.0))], rel=1e-3)
    assert section.yaxis_inverted()
    assert section.get_aspect() == 1.0


def test_hole_has_its_radius_at_every_depth(curved):
    wall = curved.axes[1].get_lines()[1]
    radius, depth = wall.get_data()
    assert radius[depth < 0.99] == pytest.approx(120.0)
    assert radius[depth > 1.01] == pytest.approx(90.0)
    assert curved.axes[1].get_xlabel() == "low side [mm]"


def test_tracks_are_those_of_the_last_pose(known_bag):
    recording = read_recording(known_bag)
    figure = draw("well", recording)
    shape = recording.shapes()[-1]
    middle = shape[np.argmin(np.abs(shape[:, 2] + 2.5))]
    _, across, gap, _, force, torque = figure.axes
    assert across.get_xlabel() == "x [mm]"
    line = across.get_lines()[-1]
    assert np.interp(2.5, line.get_ydata(), line.get_xdata()) == pytest.approx(1e3 * middle[0], abs=0.05)
    line = gap.get_lines()[0]
    expected = 81.75 - 1e3 * np.hypot(middle[0], middle[1])
    assert np.interp(2.5, line.get_ydata(), line.get_xdata()) == pytest.approx(expected, abs=0.05)
    for panel, top, bit, unit in (
        (force, recording.rig.hookload[-1], -recording.rig.bit_force[-1], "[N]"),
        (torque, recording.rig.top_drive_torque[-1], -recording.rig.bit_torque[-1], "[N m]"),
    ):
        points = next(line for line in panel.get_lines() if line.get_label() == "recorded")
        assert points.get_xdata() == pytest.approx([top, bit])
        assert points.get_ydata() == pytest.approx([0.0, 5.0])
        assert panel.get_xlabel() == unit
        assert panel.yaxis_inverted()


def test_section_of_a_straight_hole_is_not_the_mirror_of_its_track(known_bag):
    recording = read_recording(known_bag)
    section, across, *_ = draw("well", recording).axes
    outline = next(patch for patch in section.patches if patch.get_label() == "string").get_xy()
    line = across.get_lines()[-1]
    track = np.interp(2.5, line.get_ydata(), line.get_xdata())
    seen = outline[np.abs(outline[:, 1] - 2.5) < 0.02, 0].mean()
    assert np.sign(seen) == np.sign(track)
    assert abs(track) > 1.0
