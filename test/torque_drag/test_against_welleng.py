# SPDX-License-Identifier: Apache-2.0
"""The same well in welleng (extra `bench`): minimum curvature, and the soft string of a uniform pipe."""

import math

import numpy as np
import pytest
from conftest import PIPE, well

import drill_twin as dt
from drill_twin.model.survey import directions, survey, top_frame

welleng = pytest.importorskip("welleng", reason="welleng of the extra bench is not installed")

STEP = 10.0
"""Between the stations that welleng integrates over [m]."""


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
    assert np.abs(place - (theirs - theirs[0])).max() < 1e-9 * depth[-1]
    assert np.allclose(own.down @ frame, directions(np.radians(inclination), np.radians(azimuth)))


def test_torque_and_drag_of_a_uniform_pipe() -> None:
    from welleng.architecture import BHA, WellBore
    from welleng.torque_drag import TorqueDrag

    scene = well(sections=(PIPE | {"length": 1000.0},))
    loads = dt.statics(scene)
    depth = np.arange(0.0, 1000.0 + STEP, STEP)
    inclination = np.interp(depth, [0.0, 200.0, 600.0, 1000.0], [0.0, 0.0, 60.0, 60.0])
    path = welleng.survey.Survey(md=depth, inc=inclination, azi=np.full(depth.size, 30.0))
    hole = WellBore("hole", 0.0, 1000.0, method="top_down")
    hole.add_section(od=0.35, id=0.3112, length=1000.0, bottom=1000.0, coeff_friction_sliding=0.25)
    pipe = BHA("pipe", 0.0, 1000.0)
    weight = scene.string.sections[0].mass_per_length * 9.81
    pipe.add_section(od=0.127, id=0.1086, length=1000.0, unit_weight=weight, name="pipe")
    theirs = TorqueDrag(path, hole, pipe, fluid_density=1e-9)
    pairs = (("trip out", "pickup"), ("trip in", "slackoff"), ("off bottom", "rotating"))
    for own, name in pairs:
        assert loads[own].soft.hookload == pytest.approx(theirs.tension[name][0], rel=5e-3)
        assert loads[own].hookload == pytest.approx(theirs.tension[name][0], rel=0.02)
    assert loads["off bottom"].soft.surface_torque == pytest.approx(theirs.torque["rotating"][0], rel=5e-3)
    assert loads["off bottom"].surface_torque * math.hypot(1.0, 0.25) == pytest.approx(
        theirs.torque["rotating"][0], rel=0.02
    )
