# SPDX-License-Identifier: Apache-2.0
"""A string that settles at another place, on the low side of an inclined hole above all, does not whirl."""

from dataclasses import replace

import numpy as np
import pytest
from kinematics import BENCH, MARKS, TURN, clock, growth, motion, play

from drill_twin.whirl import MotionState

INCLINED = replace(BENCH, inclined=True)


def climb(time, begin, end, angle, radius=0.95):
    """A string on the wall at `radius` of the clearance that friction pushes up by `angle` [deg]."""
    share = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    smooth = share * share * (3.0 - 2.0 * share)
    return radius * np.exp(1j * np.radians(angle) * smooth) * (1.0 - np.exp(-time / 0.1))


def still(analyzer):
    summary = analyzer.summary()
    assert summary.onset is None, summary.onset
    assert summary.lasting_motion is MotionState.FIXED_AXIS
    assert summary.whirl_end_s is None
    assert {period.state for period in summary.motion} <= {MotionState.AT_REST, MotionState.FIXED_AXIS}


@pytest.mark.parametrize(("begin", "end"), [(4.0, 9.0), (5.0, 12.0), (9.0, 14.0)])
def test_friction_pushes_the_string_up_the_wall_as_the_torque_rises(begin, end):
    """As at 60 degrees of inclination, where whirl was found at 0.01 of the rotation."""
    time = clock(100, 30)
    moved = motion(time, marks=(INCLINED,), bow=0.01, offset=climb(time, begin, end, 50.0)[:, None])
    still(play(moved.with_noise(0.002, 1))[0])


def test_slow_climb_of_a_string_whose_inclination_is_not_known():
    time = clock(100, 30)
    moved = motion(time, bow=0.01, offset=climb(time, 6.0, 13.0, 50.0)[:, None])
    still(play(moved.with_noise(0.002, 2))[0])


def test_whirl_after_the_fall_to_the_low_side_is_dated_to_when_it_leaves_it():
    time = clock(100, 20)
    rest = 0.9 * (1.0 - np.exp(-time / 0.1))
    whirl = growth(8.0, 0.05, 2.0, 0.5, limit=0.5)
    moved = motion(time, marks=(INCLINED,), bow=0.02, offset=rest[:, None], whirl=whirl)
    analyzer, _ = play(moved.with_noise(0.003, 3))
    assert analyzer.summary().onset.time_s == pytest.approx(moved.true_onset(), abs=0.25)


def test_displaced_string_that_stands_is_not_called_whirl():
    """A whirl that comes to a stop at a place: no forward or backward whirl at a ratio of 0 afterwards."""
    time = clock(100, 40)

    def whirl(_time, angle):
        stop = np.interp(14.0, time, angle)
        turned = np.where(angle < stop, 0.4 * angle, 0.4 * stop + 0.3 * (1.0 - np.exp(-(angle - stop) / 60.0)))
        return 0.5 / (1.0 + np.exp(-3.0 * (time - 7.0))) * np.exp(1j * turned)

    analyzer, found = play(motion(time, bow=0.02, whirl=whirl).with_noise(0.003, 4))
    called = {f.motion for f in found if f.time_s > 17.0}
    assert called == {MotionState.FIXED_AXIS}
    summary = analyzer.summary()
    assert summary.onset is not None
    assert summary.lasting_motion is MotionState.FIXED_AXIS
    assert summary.whirl_end_s == pytest.approx(14.5, abs=1.5)


def test_irregular_motion_has_no_single_frequency():
    rng = np.random.default_rng(4)
    lines = list(zip(rng.uniform(-1.5, 2.5, 6), rng.uniform(0.0, 6.0, 6), strict=True))

    def wander(time, angle):
        total = sum(np.exp(1j * (ratio * angle + phase)) for ratio, phase in lines)
        return 0.2 * total / (1.0 + np.exp(-3.0 * (time - 5.0)))

    summary = play(motion(clock(100, 25), marks=MARKS[:1], whirl=wander).with_noise(0.005, 5))[0].summary()
    assert summary.lasting_motion is MotionState.IRREGULAR
    assert summary.whirl_frequency_hz is None
    assert summary.whirl_ratio is None
    assert summary.mean_frequency_hz is not None


def swing(time, pace, angle, radius):
    """A string that slides to and fro over an arc of the wall, +-`angle` [deg], at `pace` [Hz], from 5 s on."""
    random = np.random.default_rng(7)
    beat = sum(np.sin(2.0 * np.pi * pace * f * time + random.uniform(0.0, 6.0)) for f in (1.0, 1.13, 0.81))
    grown = 1.0 / (1.0 + np.exp(-2.0 * (time - 5.0)))
    arc = radius * np.exp(1j * np.radians(angle) * grown * beat / 3.0)
    return arc * (1.0 - np.exp(-time / 0.1))


@pytest.mark.parametrize("pace", [0.4, 0.7, 1.9, 2.0, 3.1])
@pytest.mark.parametrize("angle", [20.0, 50.0, 80.0])
def test_a_string_that_swings_on_the_low_side_does_not_whirl(pace, angle):
    """Rotation is 2 rev/s: slower, as fast and faster."""
    time = clock(100, 40)
    moved = motion(time, marks=(INCLINED,), bow=0.02, offset=swing(time, pace, angle, 0.95)[:, None])
    summary = play(moved.with_noise(0.003, 4))[0].summary()
    assert summary.onset is None, summary.onset
    assert summary.lasting_motion is MotionState.PLANE_SWING


@pytest.mark.parametrize("ratio", [-0.4, 0.35, 0.6])
def test_a_whirl_on_the_low_side_is_one(ratio):
    """An orbit about a point of the low side, that never goes round the hole."""
    time = clock(100, 30)
    rest, whirl = 0.6 * (1.0 - np.exp(-time / 0.1)), growth(12.0, 0.05, 1.0, ratio, limit=0.3)
    moved = motion(time, marks=(INCLINED,), bow=0.02, offset=rest[:, None], whirl=whirl)
    summary = play(moved.with_noise(0.003, 5))[0].summary()
    assert summary.onset.time_s == pytest.approx(moved.true_onset(), abs=3.0)
    assert summary.lasting_motion in {MotionState.FORWARD_WHIRL, MotionState.BACKWARD_WHIRL}


def test_a_swing_that_becomes_a_whirl_round_the_hole_is_an_onset_then():
    time = clock(100, 40)
    around = np.where(time < 20.0, 0.0, 2.0 * np.pi * 0.3 * 2.0 * (time - 20.0))
    path = swing(time, 0.7, 40.0, 0.95) * np.exp(1j * around)
    summary = play(motion(time, marks=(INCLINED,), bow=0.02, offset=path[:, None]).with_noise(0.003, 6))[0].summary()
    assert summary.onset.time_s == pytest.approx(20.0, abs=3.0)
    assert [period.state for period in summary.motion][-1] in {MotionState.FORWARD_WHIRL, MotionState.IRREGULAR}


def test_a_stabiliser_that_follows_the_swing_of_the_collars_does_not_whirl():
    """As in `wells/s_shaped` at 180 rpm: an ellipse of 0.1 mm in 1.7 mm beside a swing of centimetres."""
    marks = (
        replace(BENCH, name="collars", inclined=True),
        replace(BENCH, name="tight", clearance=0.0017, inclined=True),
    )
    time = clock(100, 40)
    small = growth(10.0, 0.05, 1.0, -0.65, limit=0.08)(time, 4.0 * np.pi * time)
    place = np.stack((swing(time, 0.7, 20.0, 0.95), 0.9 * (1.0 - np.exp(-time / 0.1)) + small), axis=-1)
    moved = motion(time, marks=marks).with_noise(0.003, 4)
    rest = place * [mark.clearance for mark in marks]
    summary = play(replace(moved, rest=rest))[0].summary()
    assert summary.onset is None, summary.onset
    assert summary.lasting_motion is MotionState.PLANE_SWING


def turning_by_itself(time, spin, up, radius, whirl=None):
    """A string on the low side with a spin [rad] of its own, pushed up the wall by `up` [rad]."""
    moved = motion(time, marks=(INCLINED,), whirl=whirl)
    rest = radius * np.exp(-1j * up) * (1.0 - np.exp(-time / 0.1)) + 0.03 * np.exp(1j * (spin + 0.7))
    return replace(moved, spin=spin[:, None], rest=rest[:, None] * INCLINED.clearance).with_noise(0.003, 1)


def late(time, begin, pace, climb=20.0):
    """Spin and angle up the wall [rad] of a string that the torsion reaches at `begin` [s], and that overshoots."""
    since = np.maximum(time - begin, 0.0)
    spin = 2.0 * TURN * (since - 1.5 * (1.0 - np.exp(-since / 1.5)))
    return spin, np.radians(climb) * (1.0 - np.exp(-0.8 * since) * np.cos(TURN * pace * since))


@pytest.mark.parametrize("begin", [4.0, 6.0])
@pytest.mark.parametrize(("pace", "radius"), [(0.5, 0.62), (0.5, 0.95), (0.8, 0.95)])
def test_a_string_that_starts_long_after_the_top_drive_and_climbs_the_wall_does_not_whirl(begin, pace, radius):
    """As in `wells/s_shaped` and `wells/extended_reach`, whose lower marks stand for 4 to 16 turns of the top drive."""
    time = clock(50, 25)
    summary = play(turning_by_itself(time, *late(time, begin, pace), radius))[0].summary()
    assert summary.onset is None, summary.onset


@pytest.mark.parametrize("ratio", [-1.9, -0.4, 0.35])
def test_a_whirl_soon_after_a_late_start_is_an_onset(ratio):
    """The mark itself has turned for two revolutions when the whirl crosses."""
    time = clock(100, 30)
    spin, _ = late(time, 4.0, 0.4)
    moved = turning_by_itself(time, spin, 0.0, 0.0)
    whirl = growth(6.5, 0.05, 2.0, ratio, limit=0.3)(time, spin)[:, None] * INCLINED.clearance
    moved = replace(moved, whirl=whirl)
    onset = play(moved)[0].summary().onset
    assert onset.time_s == pytest.approx(moved.true_onset(), abs=0.25)
    assert onset.detected_s < moved.true_onset() + 1.5


@pytest.mark.parametrize("stops", [((10.0, 11.0),), ((10.0, 14.0),)])
@pytest.mark.parametrize("over", [0.4, 3.0])
def test_a_string_that_stands_in_stick_slip_and_slides_back_has_no_synchronous_part(stops, over):
    """It stands still in the rotating frame too, 27 % of the clearance from its mean place."""
    time = clock(50, 25)
    rate, up = np.full_like(time, 2.0 * TURN), np.zeros_like(time)
    for begin, end in ((-1.0, 0.2), *stops):
        standing, since = (time >= begin) & (time < end), np.maximum(time - end, 0.0)
        rate[standing & (begin > 0.0)] = 0.0
        climbed = np.radians(25.0) * (1.0 - np.exp(-over * since) * np.cos(0.5 * TURN * since))
        up = np.where(since > 0.0, climbed, np.where(standing, np.radians(25.0) * np.exp(-2.0 * (time - begin)), up))
    spin = np.concatenate(([0.0], np.cumsum(rate[1:] * np.diff(time))))
    summary = play(turning_by_itself(time, spin, up, 0.95))[0].summary()
    assert summary.onset is None, summary.onset
