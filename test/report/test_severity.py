# SPDX-License-Identifier: Apache-2.0
"""Acceleration, severity levels and specific energy of motions that are known in closed form."""

import math

import pytest

from drill_twin.report import read_recording
from drill_twin.report.severity import ACCELERATION, STICK_SLIP, level, level_text, severity


@pytest.mark.parametrize(
    ("value", "bounds", "expected"),
    [(0.49, ACCELERATION, 0), (0.5, ACCELERATION, 1), (3.2, ACCELERATION, 4), (20.0, ACCELERATION, 7),
     (1.0, STICK_SLIP, 5)],
)  # fmt: skip
def test_levels(value, bounds, expected):
    assert level(value, bounds) == expected
    assert level_text(expected).startswith(f"level {expected} of 7 (")
    assert level_text(expected).endswith("bounds of this program, not of a vendor)")


def test_acceleration_of_two_circular_motions(known_bag):
    found = severity(read_recording(known_bag))
    sizes = [(2.0 * math.pi * rate) ** 2 * radius for rate, radius in ((2.0, 0.001), (0.6, 0.030))]  # Hz, m
    for mark in found["acceleration"].values():
        assert mark["lateral_rms_m_s2"] == pytest.approx(math.hypot(*sizes), rel=1e-2)
        assert mark["lateral_peak_m_s2"] == pytest.approx(sum(sizes), rel=5e-3)
        assert mark["axial_rms_m_s2"] == pytest.approx(0.0, abs=1e-6)
        assert mark["lateral_level"] == 0
    assert found["acceleration_rate_hz"] == pytest.approx(100.0)
    assert found["rate_of_penetration_m_s"] is None  # this bit does not drill


def test_a_card_says_whose_the_bounds_are(known_report):
    assert "lateral acceleration rms at" in (page := known_report.page.read_text("utf-8"))
    assert "level 0 of 7 (none; bounds of this program, not of a vendor)</span>" in page
