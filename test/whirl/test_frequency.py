# SPDX-License-Identifier: Apache-2.0
"""Whirl frequency with its window and spread, lines of the spectrum, and both in words."""

import numpy as np
import pytest
from kinematics import MARKS, TURN, clock, motion, play

from drill_twin import analyze
from drill_twin.report.text import findings
from drill_twin.whirl.spectrum import lines_of

TIME = np.arange(0.0, 40.0, 0.01)
MARK = MARKS[3:]


def found(ratio, seconds, *, speed=2.0, noise=0.01, seed=1):
    """Summary of a mark that whirls with a ratio, constant or a function of time [s], from 3 s on."""
    time = clock(100, seconds)
    ratios = np.broadcast_to(ratio(time) if callable(ratio) else ratio, time.shape)

    def whirl(time, angle):
        return 0.6 / (1.0 + np.exp(12.0 - 4.0 * time)) * np.exp(1j * np.cumsum(ratios * np.gradient(angle)))

    return play(motion(time, speed=speed, marks=MARK, whirl=whirl).with_noise(noise, seed))[0].summary()


@pytest.mark.parametrize("speed", [2.0, -2.0])
@pytest.mark.parametrize("ratio", [0.45, -0.07, -6.0])
def test_settled_whirl_has_its_frequency_inside_a_narrow_interval(speed, ratio):
    summary = found(ratio, 30.0, speed=speed)
    low, high = summary.whirl_frequency_interval_hz
    assert summary.whirl_frequency_changes is False
    assert low < summary.whirl_frequency_hz < high
    assert high - low < 0.02
    assert summary.whirl_frequency_hz == pytest.approx(2.0 * ratio, abs=2.0 * (high - low))
    assert summary.whirl_ratio == pytest.approx(ratio, abs=0.005)


def test_windows_of_one_settled_whirl_agree_within_their_intervals():
    def paced(time):
        return 0.5 + 0.05 * np.sin(TURN * 0.7 * time)

    shares = [found(paced, seconds) for seconds in (30.0, 45.0, 60.0)]
    for one in shares:
        low, high = one.whirl_frequency_interval_hz
        assert one.whirl_frequency_changes is False
        assert all(low <= other.whirl_frequency_hz <= high for other in shares)


@pytest.mark.parametrize("change", [0.3, -0.6])
def test_drifting_whirl_is_still_changing(change):
    summary = found(lambda time: 0.5 + change * time / 40.0, 40.0)
    low, high = summary.whirl_frequency_interval_hz
    begin, end = summary.whirl_frequency_window_s
    assert summary.whirl_frequency_changes is True
    assert low <= summary.whirl_frequency_hz <= high
    assert summary.whirl_frequency_hz == pytest.approx(1.0 + 2.0 * change * 0.5 * (begin + end) / 40.0, abs=0.01)


def test_whirl_that_has_changed_is_taken_once_it_has_settled():
    summary = found(lambda time: np.interp(time, (10.0, 18.0), (0.9, 0.5)), 45.0)
    low, high = summary.whirl_frequency_interval_hz
    assert summary.whirl_frequency_changes is False
    assert low <= 1.0 <= high
    assert summary.whirl_frequency_hz == pytest.approx(1.0, abs=0.05)


def test_short_whirl_is_not_called_settled():
    summary = found(0.5, 12.0)
    low, high = summary.whirl_frequency_interval_hz
    assert summary.whirl_frequency_changes is None
    assert low <= summary.whirl_frequency_hz <= high


def test_frequency_of_two_whirls_in_turn_is_one_of_them_and_not_between():
    summary = found(lambda time: np.where(time % 40.0 < 24.0, 0.6, -1.5), 80.0)
    assert summary.whirl_frequency_hz == pytest.approx(1.2, abs=0.05)


def test_cells_merge_without_a_change_of_the_frequency():
    summary = found(-0.8, 400.0)
    assert summary.whirl_frequency_hz == pytest.approx(-1.6, abs=1e-3)
    assert summary.whirl_frequency_window_s == pytest.approx((108.0, 400.0), abs=6.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_line_of_a_circular_orbit(sense):
    lines = lines_of(TIME, 0.04 * np.exp(1j * sense * TURN * 0.9 * TIME), 2.0 * sense)
    assert [line.frequency for line in lines] == pytest.approx([0.9], abs=1e-3)
    assert lines[0].radius == pytest.approx(0.04, rel=0.01)


def test_two_whirls_in_turn_are_two_lines():
    rate = np.where(TIME < 20.0, 0.5, -1.5)
    centre = 0.03 * np.exp(1j * TURN * np.concatenate(([0.0], np.cumsum(rate[1:]) * 0.01)))
    assert sorted(line.frequency for line in lines_of(TIME, centre, 2.0)) == pytest.approx([-1.5, 0.5], abs=0.03)


def test_too_short_a_record_has_no_line():
    assert lines_of(TIME[:9], TIME[:9] + 0j, 2.0) == []


SUMMARY = {
    "run": 1, "runs": 1, "start_utc": None,
    "units": "si", "version": None, "severity": None,
    "severity_by_quantity": {}, "wear_power_w": {}, "rate_of_penetration_m_s": None, "specific_energy_pa": None,
    "stick_slip_level": None, "applied": {"rotation_rad_s": None},
    "whirl_observable": True, "onset_s": 5.0, "onset_mark": "m", "onset_confidence": 1.0, "whirl_end_s": None,
    "lasting_motion": "irregular", "whirl_frequency_hz": None, "frequency_mark": "m", "whirl_ratio": None,
    "whirl_frequency_interval_hz": [-0.04, 0.63], "whirl_frequency_changes": None, "rotation_rev_s": 2.0,
    "whirl_frequency_window_s": [9.0, 20.0], "max_radius_m": {},
    "spectrum_lines": [{"frequency_hz": 0.22, "radius_m": 0.04}],
    "loads": {}, "motion": [], "mark_motion": {"m": [{"state": "forward whirl"}]}, "bit": "steady", "stick_slip": [],
    "bit_spectral_peak_hz": None, "stick_slip_index": None, "largest_stick_slip_index": None,
}  # fmt: skip


def test_irregular_motion_is_told_by_interval_and_lines():
    rows = dict(findings(SUMMARY))
    assert rows["whirl frequency"] == "no single one, the motion is irregular: -0.040 to +0.630 Hz in windows, at m"
    assert rows["lines of the spectrum"] == "+0.22 Hz (40.0 mm), at m"
    assert rows["whirl ratio"] == "none"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (False, "+0.500 Hz (forward), -0.040 to +0.630 Hz in nine of ten cases, at m from 9.00 to 20.00 s"),
        (True, "+0.500 Hz (forward), -0.040 to +0.630 Hz in windows, at m from 9.00 to 20.00 s; still changing"),
        (None, "-0.040 to +0.630 Hz in windows, at m from 9.00 to 20.00 s; too short to tell whether it has settled"),
    ],
)
def test_frequency_is_told_with_window_and_spread(changes, said):
    settled = {"lasting_motion": "forward whirl", "whirl_frequency_hz": 0.5, "whirl_frequency_changes": changes}
    assert dict(findings({**SUMMARY, **settled}))["whirl frequency"].endswith(said)


def test_transient_is_told_as_such():
    fixed = {"lasting_motion": "rotation about a fixed axis", "whirl_end_s": 9.0, "whirl_frequency_hz": 0.5}
    rows = dict(findings({**SUMMARY, **fixed}))
    assert rows["motion that lasts"] == "rotation about a fixed axis"
    assert "a transient: no whirl since 9.00 s" in rows["onset of whirl"]
    assert "while it lasted" in rows["whirl frequency"]


def test_spiral_names_the_states_of_its_marks():
    rows = dict(findings({**SUMMARY, "lasting_motion": "spiral", "whirl_frequency_hz": 1.0}))
    assert rows["motion that lasts"] == "spiral, the shape of the string (its marks at the end: forward whirl)"


def in_hole(seconds, *lines):
    """Findings of a sum of lines [Hz, over the clearance] in a hole of 54 mm, rotated at 120 rpm."""
    time = np.arange(0.0, seconds, 0.01)
    noise = 2e-4 * np.random.default_rng(11).normal(size=(2, time.size))
    z = sum(0.054 * size * np.exp(2j * np.pi * pace * time) for pace, size in lines)
    found = analyze(time, z.real + noise[0], z.imag + noise[1], rotation=4.0 * np.pi, clearance=0.054, radius=0.1016)
    return found.summary


@pytest.mark.parametrize("seconds", [1.0, 2.0])
def test_frequency_of_too_short_a_whirl_is_not_told(seconds):
    """Half of the pace was told of one second of rolling."""
    summary = in_hole(seconds, (-3.76, 1.0))
    assert summary.onset is not None
    assert summary.whirl_frequency_hz is None
    assert any("too few revolutions" in note for note in summary.notes)


@pytest.mark.parametrize(("second", "hz"), [(0.4, None), (0.33, -2.4), (0.2, -2.4)])
def test_two_whirls_have_the_frequency_of_the_stronger_or_none(second, hz):
    """The mean phase of two equal lines is no motion's: +1.2 Hz was told of -2.4 and +1.4 Hz."""
    found = in_hole(40.0, (-2.4, 0.4), (1.4, second)).whirl_frequency_hz
    assert found == (hz and pytest.approx(hz, abs=0.01))
