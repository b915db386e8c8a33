# SPDX-License-Identifier: Apache-2.0
"""A string that spins about a fixed shape does not whirl, whatever the noise: no onset may be found."""

import numpy as np
import pytest
from kinematics import BENCH, MARKS, clock, motion, play, turning
from variants import long_one_of

from drill_twin import analyze
from drill_twin.whirl import Analyzer, MarkInfo, MotionState


def assert_no_whirl(moved, **how):
    analyzer, found = play(moved, **how)
    summary = analyzer.summary()
    assert summary.onset is None, summary.onset
    assert summary.whirl_frequency_hz is None
    assert set(summary.mark_onset_s.values()) == {None}
    assert {period.state for period in summary.motion} <= {
        MotionState.AT_REST, MotionState.FIXED_AXIS, MotionState.PLANE_SWING,
    }  # fmt: skip
    return found


@pytest.mark.parametrize(("rate", "noise"), [(100, 0.05), (20, 0.05), (20, 0.1)])
def test_minutes_of_bowed_rotation_with_noise(rate, noise):
    moved = motion(clock(rate, 300 if rate == 100 else 600), bow=0.1, offset=0.3 + 0.1j, marks=MARKS)
    found = assert_no_whirl(moved.with_noise(noise, seed=7))
    assert found[-1].motion is MotionState.FIXED_AXIS


@pytest.mark.parametrize("bow", [0.0, 0.03, 0.2, 0.6])
@pytest.mark.parametrize("ramp", [0.0, 0.5, 5.0])
def test_rotation_that_ramps_up_from_rest(bow, ramp):
    moved = motion(clock(100, 15), bow=bow, ramp=ramp, offset=0.2).with_noise(0.005, seed=1)
    assert_no_whirl(moved)
    assert play(moved)[0]._state.orbit.synchronous[0] == pytest.approx(bow, abs=0.01)


@pytest.mark.parametrize(("start", "seconds"), [(0.05, 0.05), (10.0, 0.3), (10.0, 2.0), (10.0, 10.0)])
def test_string_that_falls_to_one_side_and_stays(start, seconds):
    time = clock(100, 40)
    lean = 0.9 * (1.0 - np.exp(-np.maximum(time - start, 0.0) / seconds))
    assert_no_whirl(motion(time, bow=0.05, offset=lean[:, None]).with_noise(0.01, seed=2))


@pytest.mark.parametrize(("final", "seconds"), [(0.15, 1.0), (0.2, 0.3), (0.24, 3.0)])
def test_bow_that_grows_to_a_new_steady_size(final, seconds):
    time = clock(100, 30)
    bow = 0.02 + (final - 0.02) * np.clip((time - 10.0) / seconds, 0.0, 1.0)
    assert_no_whirl(motion(time, bow=bow).with_noise(0.01, seed=3))


def test_large_bow_from_the_start_is_no_surge():
    assert_no_whirl(motion(clock(100, 30), bow=0.45).with_noise(0.02, seed=4))


def test_change_of_speed_with_imbalance():
    time = clock(200, 40)
    angle, rate = turning(time, 2.0)
    more = np.clip(time - 15.0, 0.0, 2.0) * 2.0 * np.pi  # 2 to 4 rev/s in 2 s
    extra = np.concatenate(([0.0], np.cumsum(0.5 * (more[1:] + more[:-1]) * np.diff(time))))
    moved = motion(time, bow=0.0, twist=0.0)
    spin = (angle + extra)[:, None]
    size = 0.05 * ((rate + more) / (4.0 * np.pi)) ** 1.5 * BENCH.clearance
    lag = np.exp(1j * (spin - 0.2 * (rate + more)[:, None] / 12.0))
    moved = type(moved)(moved.marks, time, spin, rate + more, moved.whirl, size[:, None] * lag, moved.noise)
    assert_no_whirl(moved.with_noise(0.01, seed=5))


def test_without_rotation_nothing_is_whirl():
    time = clock(100, 20)
    swing = 0.5 * np.exp(2j * np.pi * 0.7 * time) * np.exp(-time / 5.0)
    found = assert_no_whirl(motion(time, speed=0.0, ramp=0.0, whirl=lambda _t, _a: swing))
    assert found[-1].motion is MotionState.AT_REST
    assert np.isnan(found[-1].ratio).all()


@pytest.mark.parametrize("rate", [20, 100])
def test_camera_without_spin(rate):
    assert_no_whirl(motion(clock(rate, 120), bow=0.05, offset=0.1, marks=MARKS).with_noise(0.03, seed=6), spin=False)


@pytest.mark.parametrize("rate", long_one_of(2, [20, 100]))
def test_no_false_onset_in_as_many_revolutions_as_four_marks_see_in_a_day(rate):
    hours, many = (3, 40) if rate == 20 else (1, 100)
    marks = tuple(MarkInfo(f"m{i}", 0.1 * i, "wall", BENCH.wall_offset, BENCH.clearance) for i in range(many))
    assert hours * many >= 24 * 4
    analyzer = Analyzer(marks)
    for part in range(6 * hours):
        moved = motion(clock(rate, 600), ramp=0.0, bow=0.1, offset=0.2, marks=marks).with_noise(0.05, seed=part)
        positions = moved.positions
        for i, stamp in enumerate((moved.stamps + part * 600 * 10**9).tolist()):
            analyzer.push(stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
    summary = analyzer.summary()
    assert summary.quality.accepted == hours * 3600 * rate
    assert summary.onset is None
    assert set(summary.mark_onset_s.values()) == {None}


@pytest.mark.parametrize("rate", [20, 100])
def test_string_that_swings_in_a_plane_does_not_whirl(rate):
    """It passes the middle again and again; its angle jumps, but it sweeps no area."""
    swing = 0.3 * np.sin(2.0 * np.pi * 0.7 * clock(rate, 60)) * np.exp(0.4j)
    moved = motion(clock(rate, 60), bow=0.03, whirl=lambda _t, _a: swing * (clock(rate, 60) > 10.0))
    assert_no_whirl(moved.with_noise(0.005, seed=8))


def test_string_that_bounces_on_the_low_side_from_the_start():
    """The fall of an inclined hole: it leaves the axis at once and bounces for seconds."""
    time = clock(100, 30)
    bounce = 0.3 * np.exp(-time / 2.0) * np.abs(np.cos(2.0 * np.pi * 1.3 * time))
    roll = np.exp(0.15j * np.sin(2.0 * np.pi * 0.9 * time) * np.exp(-time / 3.0))
    lean = (1.0 - np.exp(-time / 0.1)) * (1.0 - bounce) * roll
    assert_no_whirl(motion(time, bow=0.02, offset=lean[:, None]).with_noise(0.005, seed=9))


@pytest.mark.parametrize("begin", [0.0, 5.0])
@pytest.mark.parametrize(("reach", "pace"), [(45.0, 0.4), (63.0, 0.9), (86.0, 1.3)])
def test_string_that_swings_along_the_wall_does_not_whirl(begin, reach, pace):
    """Of a hole that is not known to be inclined; from the first sample, or growing over ten seconds."""
    time = np.arange(0.0, 30.0, 0.01)
    grown = np.clip((time - begin) / 10.0, 0.0, 1.0) if begin else 1.0
    angle = -0.5 * np.pi + np.radians(reach) * grown * np.sin(2.0 * np.pi * pace * time)
    noise = 2e-4 * np.random.default_rng(1).normal(size=(2, time.size))
    x, y = 0.054 * np.array([np.cos(angle), np.sin(angle)]) + noise
    found = analyze(time, x, y, rotation=4.0 * np.pi, clearance=0.054, radius=0.1016)
    assert found.onset_s is None
    assert found.summary.motion[-1].state is MotionState.PLANE_SWING
