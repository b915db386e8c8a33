# SPDX-License-Identifier: Apache-2.0
"""The same well in other programs (extra `bench`): minimum curvature, and the soft string of a uniform pipe."""

import math

import numpy as np
import pytest
from bent_well import PIPE, well

import drill_twin as dt
from drill_twin.physics.model.survey import directions, survey, top_frame

welleng = pytest.importorskip("welleng", reason="welleng of the extra bench is not installed")

STEP = 2.0
"""Between the stations over which the soft string is integrated [m]."""


def test_minimum_curvature() -> None:
    random = np.random.default_rng(3)
    depth = np.append(0.0, np.cumsum(random.uniform(10.0, 60.0, 60)))
    inclination = np.abs(np.cumsum(random.normal(0.5, 1.0, 61)))
    azimuth = 350.0 + np.cumsum(random.normal(0.0, 2.0, 61))
    other = welleng.survey.Survey(md=depth, inc=inclination, azi=azimuth % 360.0)
    own = survey(depth, np.radians(inclination), np.radians(azimuth))
    frame = top_frame(math.radians(inclination[0]), math.radians(azimuth[0]))
    place = own.position @ frame
    theirs = np.column_stack([other.n, other.e, other.tvd])
    assert np.abs(place - (theirs - theirs[0])).max() < 1e-9  # of 2,000 m
    assert np.allclose(own.down @ frame, directions(np.radians(inclination), np.radians(azimuth)))


def test_torque_and_drag_of_a_uniform_pipe() -> None:
    """By torque_drag: welleng 0.30 adds weight and tension where a hole builds, though they press to opposite sides."""
    reason = "torque_drag of the extra bench is not installed"
    torque_drag = pytest.importorskip("torque_drag", reason=reason)
    if not hasattr(torque_drag, "calc"):  # this folder, as a namespace package
        pytest.skip(reason)
    loads = dt.statics(well(sections=(PIPE | {"length": 1000.0},)))
    depth = np.arange(0.0, 1000.0 + STEP, STEP)
    inclination = np.interp(depth, [0.0, 200.0, 600.0, 1000.0], [0.0, 0.0, 60.0, 60.0])
    turn = np.diff(inclination, prepend=0.0)
    path = [
        {"md": at, "inc": angle, "delta": {"md": STEP, "inc": change, "azi": 0.0}}
        for at, angle, change in zip(depth.tolist(), inclination.tolist(), turn.tolist(), strict=True)
    ]
    inch = 0.0254
    size = {"od": PIPE["outer_diameter"] / inch, "id": PIPE["inner_diameter"] / inch, "shoe": 1000.0, "length": 1000.0}
    theirs = torque_drag.calc(
        path, {"pipe": size, "odAnn": 12.25}, {"rhof": 0.0, "rhod": 7.85}, fric=[0.25] * depth.size, torque_calc=True
    )
    for own, name in (("trip out", "hoisting"), ("trip in", "lowering"), ("off bottom", "static")):
        assert loads[own].soft.hookload == pytest.approx(1e3 * theirs.force[name][0], rel=0.01)
        assert loads[own].hookload == pytest.approx(1e3 * theirs.force[name][0], rel=0.02)
    torque = 1e3 * theirs.torque["static"][0]
    assert loads["off bottom"].soft.surface_torque == pytest.approx(torque, rel=0.01)
    assert loads["off bottom"].surface_torque * math.hypot(1.0, 0.25) == pytest.approx(torque, rel=0.02)
