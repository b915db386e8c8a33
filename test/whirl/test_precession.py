# SPDX-License-Identifier: Apache-2.0
"""Radius, precession and ratio of known orbits; spin kept apart from whirl."""

import json
from dataclasses import replace

import numpy as np
import pytest
from kinematics import BENCH, MARKS, clock, growth, motion, play


@pytest.mark.parametrize("ratio", [-2.0, -0.5, -0.1, 0.2, 0.5, 0.8, 0.95, 1.3])
@pytest.mark.parametrize("rate", [20, 200])
def test_ratio_and_sign(ratio, rate):
    moved = motion(clock(rate, 30), bow=0.03, offset=0.1, whirl=growth(6.0, 0.05, 2.0, ratio, limit=0.6)).with_noise(
        0.01, 1
    )
    analyzer, found = play(moved)
    late = np.array([f.ratio[0] for f in found if f.time_s > 20.0])
    assert np.median(late) == pytest.approx(ratio, rel=0.02)
    assert np.sign(late).tolist() == [np.sign(ratio)] * late.size
    assert found[-1].precession[0] == pytest.approx(found[-1].ratio[0] * analyzer._state.orbit.rotation[0], rel=1e-12)
    definite = min(1.0, rate / 2.0 / 15.0)  # six times the rotation, 2 rev/s, needs 15 samples in a revolution
    assert found[-1].confidence[0] > 0.9 * definite
    assert analyzer.summary().whirl_ratio == pytest.approx(ratio, rel=0.02)


def test_rotation_to_the_left_gives_the_mirrored_figures():
    """Precession and ratio are positive forward, whichever way the string turns."""
    right = motion(clock(100, 15), bow=0.03, offset=0.1, whirl=growth(6.0, 0.05, 2.0, 0.5, limit=0.6))
    left = replace(
        right, spin=-right.spin, top_speed=-right.top_speed, whirl=right.whirl.conj(), rest=right.rest.conj()
    )
    (analyzer, found), (mirrored, others) = play(right), play(left)
    assert others[-1].ratio[0] == pytest.approx(found[-1].ratio[0], rel=1e-9)
    assert others[-1].precession[0] == pytest.approx(found[-1].precession[0], rel=1e-9)
    assert mirrored.summary().whirl_ratio == pytest.approx(analyzer.summary().whirl_ratio, rel=1e-9)


def test_wall_mark_and_centre_mark_agree():
    moved = motion(clock(100, 15), bow=0.03, whirl=growth(6.0, 0.05, 2.0, 0.5), marks=MARKS[2:], twist=0.0)
    _, found = play(moved)
    for findings in found:
        assert findings.orbit_radius[0] == pytest.approx(findings.orbit_radius[1], abs=1e-12)
    assert found[-1].ratio[0] == pytest.approx(found[-1].ratio[1], rel=1e-9)


def test_orbit_radius_is_the_centre_lines_distance_from_the_axis():
    moved = motion(clock(100, 12), bow=0.1, offset=0.2j, whirl=growth(6.0, 0.05, 2.0, 0.5))
    analyzer, found = play(moved)
    radius = np.array([f.orbit_radius[0] for f in found])
    assert radius == pytest.approx(abs(moved.centre[:, 0]), abs=1e-12)
    assert analyzer.summary().max_radius_m[BENCH.name] == pytest.approx(abs(moved.centre).max(), rel=1e-12)


def test_parts_of_the_motion_are_told_apart():
    moved = motion(clock(100, 30), bow=0.1, offset=0.3, whirl=growth(6.0, 0.05, 2.0, 0.37, limit=0.5)).with_noise(
        0.005, 2
    )
    orbit = play(moved)[0]._state.orbit
    assert orbit.radius[0, 0] * BENCH.clearance == pytest.approx(abs(moved.whirl[-1, 0]), rel=0.03)
    assert orbit.synchronous[0] == pytest.approx(0.1, rel=0.15)


def test_a_bow_turns_with_the_string():
    analyzer, found = play(motion(clock(100, 12), bow=0.1).with_noise(0.005, 3))
    assert found[-1].ratio[0] == pytest.approx(1.0, rel=0.01)
    assert analyzer._state.orbit.radius[0, 0] < 0.01


def test_a_string_that_does_not_move_has_no_precession():
    _, found = play(motion(clock(100, 8)).with_noise(0.0005, 3))
    assert np.isnan(found[-1].precession[0])
    assert np.isnan(found[-1].ratio[0])
    assert found[-1].confidence[0] == 0.0


def test_two_motions_one_after_the_other_give_the_one_that_weighs_more():
    def whirl(time, angle):
        back = time > 12.0
        turned = np.where(
            back, 0.5 * np.interp(12.0, time, angle) - 0.1 * (angle - np.interp(12.0, time, angle)), 0.5 * angle
        )
        return np.where(time > 5.0, 0.6, 0.0) * np.exp(1j * turned)

    analyzer, _ = play(motion(clock(100, 60), whirl=whirl))
    assert analyzer.summary().whirl_ratio == pytest.approx(-0.1, abs=0.004)


def test_few_samples_per_revolution_are_said_so():
    analyzer, _ = play(motion(clock(27, 20), speed=6.0, whirl=growth(8.0, 0.05, 2.0, 0.5)))
    summary = analyzer.summary()
    assert summary.quality.samples_per_revolution == pytest.approx(27 / 6, rel=0.02)
    assert any(note.startswith("not definite: 4.5 samples in a revolution") for note in summary.notes)
    assert summary.whirl_ratio == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("rate", [7.0, 12.0, 20.0])
def test_rate_too_low_for_the_rotation_gives_no_number(rate):
    """At 20 samples in a second and 6 rev/s, whirl at -1.9 looks like whirl at 1.43."""
    analyzer, found = play(motion(clock(rate, 25), speed=6.0, whirl=growth(8.0, 0.05, 2.0, -1.9)))
    summary = analyzer.summary()
    assert summary.whirl_frequency_hz is None
    assert summary.whirl_ratio is None
    assert any("aliasing" in note for note in summary.notes)
    assert all(np.isnan(f.ratio).all() for f in found if f.time_s > 3.0)
    assert {period.state.value for period in summary.motion[1:]} <= {"not observable"}
    if rate > 8.0:  # below, bins do not even hang together
        assert found[-1].motion.value == "not observable"
        assert "samples in a revolution" in found[-1].motion_criterion


def test_summary_is_plain_json():
    analyzer, _ = play(motion(clock(100, 12), whirl=growth(6.0, 0.05, 2.0, 0.5), marks=MARKS))
    plain = json.loads(json.dumps(analyzer.summary().to_dict(), allow_nan=False))
    assert plain["onset_s"] == analyzer.summary().onset_s
    assert plain["motion"][-1]["state"] == "forward whirl"
    assert plain["quality"]["accepted"] == 1200
    assert set(plain["max_radius_m"]) == {mark.name for mark in MARKS}


def test_summary_of_nothing():
    from drill_twin.whirl import Analyzer

    summary = Analyzer(MARKS).summary()
    assert summary.onset_s is None
    assert summary.rotation_rev_s is None
    assert summary.max_radius_m == dict.fromkeys(mark.name for mark in MARKS)
    json.dumps(summary.to_dict(), allow_nan=False)
