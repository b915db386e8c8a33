# SPDX-License-Identifier: Apache-2.0
"""Whirl where the lateral motion of a string ends is told in the run."""

import pytest

from drill_twin.api import load_scene
from drill_twin.runs.loop import RunLoop
from drill_twin.scene.set_points import Schedule

THIN = {"effects.mud.viscosity": "1e-6 cP", "added_mass.confined": "false"}
"""Mud that brakes by its vortices alone: with viscous drag none of these strings whirls."""
FAST = THIN | {"rig.rotation.value": "150 rpm", "effects.eccentricity.offset": "5 mm"}
RUBBING = THIN | {
    "rig.rotation.value": "200 rpm",
    "effects.eccentricity.offset": "10 mm",
    "effects.wall_friction.coefficient": "0.6",
}


PLUMB = {
    "hole.survey": "[{depth: 0 m, inclination: 0 deg, azimuth: 0 deg},"
                   " {depth: 3000 m, inclination: 0.001 deg, azimuth: 0 deg}]",
}  # fmt: skip
"""A bend that nothing feels: the kernel is that of s_shaped."""


def _told(changes, well="vertical_3000", until=20.0):
    scene = load_scene(f"wells/{well}", (PLUMB if well == "vertical_3000" else {}) | changes)
    loop, schedule, period = (
        RunLoop(scene, scene.numerics.frame_period, lambda *_: None),
        Schedule.from_scene(scene),
        0.02,
    )
    while loop.twin.time < until:
        ahead = [schedule.at(loop.twin.time + (k + 1) * period) for k in range(min(50, loop.most_frames))]
        frames, error = loop.fill(ahead)
        assert error is None
        loop.count(frames, 0.0)
    return loop.diagnostics().get("left_out", "")


@pytest.mark.slow
def test_a_calm_string_says_nothing():
    assert _told({}) == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [pytest.param(FAST, marks=pytest.mark.long, id="fast"), pytest.param(RUBBING, id="rubbing")]
)
def test_a_string_that_whirls_at_the_joint_says_so(changes):
    assert "the string whirled where its lateral motion ends" in _told(changes)


FROM_REST = {"rig.start": "axis", "rig.rotation.shape": "step", "rig.rotation.duration": "30 s"}


def test_a_string_that_falls_to_the_low_side_before_it_turns_does_not_whirl():
    """From rest on the axis: it moves sideways faster than the surface that has begun to turn."""
    assert _told(FROM_REST, "s_shaped", 5.0) == ""
