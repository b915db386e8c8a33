# SPDX-License-Identifier: Apache-2.0
"""Mode, line and mean agree for a circular orbit; two orbits are two lines, and windows give an interval."""

import numpy as np
import pytest

from drill_twin.report.text import findings
from drill_twin.whirl.spectrum import precession_record

TIME = np.arange(0.0, 40.0, 0.01)


def record(rate, centre, rotation=2.0):
    """Record of a mark that precesses at `rate` [rev/s, in the sense of rotation]."""
    return precession_record(TIME, rate, rate / abs(rotation), np.abs(centre), centre, rotation)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_circular_orbit(sense):
    rate = np.full_like(TIME, 0.9)
    found = record(rate, 0.04 * np.exp(1j * sense * np.pi * 2.0 * 0.9 * TIME), 2.0 * sense)
    assert found.interval_hz == pytest.approx((0.9, 0.9))
    assert found.mean_ratio == pytest.approx(0.45)
    assert [line.frequency for line in found.lines] == pytest.approx([0.9], abs=1e-3)
    assert found.lines[0].radius == pytest.approx(0.04, rel=0.01)


def test_change_of_rate_gives_an_interval_and_two_lines():
    rate = np.where(TIME < 20.0, 0.5, -1.5)
    centre = 0.03 * np.exp(2j * np.pi * np.concatenate(([0.0], np.cumsum(rate[1:]) * 0.01)))
    found = record(rate, centre)
    assert found.interval_hz == pytest.approx((-1.5, 0.5), abs=0.02)
    assert sorted(line.frequency for line in found.lines) == pytest.approx([-1.5, 0.5], abs=0.03)


def test_less_than_two_windows_has_no_interval():
    few = slice(0, 700)
    rate = np.full_like(TIME[few], 0.9)
    found = precession_record(TIME[few], rate, rate / 2.0, rate, rate + 0j, 2.0)
    assert found.interval_hz is None


SUMMARY = {
    "run": 1, "runs": 1, "start_utc": None,
    "units": "si", "version": None, "acceleration": {}, "rate_of_penetration_m_s": None, "specific_energy_pa": None,
    "severity": None, "severity_by_quantity": {}, "severity_source": None, "wear_power_w": {},
    "bending_cycles_per_second": None, "applied": {"rotation_rad_s": None},
    "whirl_observable": True, "onset_s": 5.0, "onset_mark": "m", "onset_confidence": 1.0, "whirl_end_s": None,
    "lasting_motion": "irregular", "whirl_frequency_hz": None, "frequency_mark": "m", "whirl_ratio": None,
    "whirl_frequency_interval_hz": [-0.04, 0.63], "window_rev": 10.0, "rotation_rev_s": 2.0, "max_radius_m": {},
    "spectrum_lines": [{"frequency_hz": 0.22, "radius_m": 0.04}], "ratios": {"mode": 0.7, "line": 0.11, "mean": 0.15},
    "loads": {}, "motion": [], "mark_motion": {"m": [{"state": "forward whirl"}]}, "bit": "steady", "stick_slip": [],
    "bit_spectral_peak_hz": None, "stick_slip_index": None, "largest_stick_slip_index": None,
}  # fmt: skip


def test_irregular_motion_is_told_by_interval_and_lines():
    rows = dict(findings(SUMMARY))
    assert rows["whirl frequency"].startswith("no single one, the motion is irregular: -0.04 to +0.63 Hz over windows")
    assert rows["lines of the spectrum"] == "+0.22 Hz (40.0 mm), at m"
    assert "most frequent" not in rows["whirl ratio"]
    assert "+0.110 (highest line of the spectrum), +0.150 (mean weighted by the radius)" in rows["whirl ratio"]


def test_transient_is_told_as_such():
    fixed = {"lasting_motion": "rotation about a fixed axis", "whirl_end_s": 9.0, "whirl_frequency_hz": 0.5}
    rows = dict(findings({**SUMMARY, **fixed}))
    assert rows["motion that lasts"] == "rotation about a fixed axis"
    assert "a transient: no whirl since 9.00 s" in rows["onset of whirl"]
    assert "while it lasted" in rows["whirl frequency"]


def test_spiral_names_the_states_of_its_marks():
    rows = dict(findings({**SUMMARY, "lasting_motion": "spiral", "whirl_frequency_hz": 1.0}))
    assert rows["motion that lasts"] == "spiral, the shape of the string (its marks at the end: forward whirl)"
