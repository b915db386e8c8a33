# SPDX-License-Identifier: Apache-2.0
"""Stick-slip of the bit, from its speed alone."""

import math

import numpy as np
import pytest
from kinematics import MARKS, clock, growth, motion

from drill_twin.whirl import Analyzer, BitMotion, BitOnlyAnalyzer, StickSlip


def sticking(time, period=0.4, mean=9.0):
    """A bit that stands still once in a period."""
    return np.maximum(mean * (1.0 + 1.3 * np.sin(2.0 * np.pi * time / period)), 0.0)


def followed(time, speed):
    bit = StickSlip()
    for at, value in zip(time.tolist(), speed.tolist(), strict=True):
        bit.push(at, value)
    return bit


@pytest.mark.parametrize("rate", [100, 1000])
@pytest.mark.parametrize("period", [0.25, 0.4, 4.5])
def test_period_and_severity(rate, period):
    time = np.arange(0.0, 12.0 * period, 1.0 / rate)
    bit = followed(time, sticking(time, period))
    assert bit.motion is BitMotion.STICK_SLIP
    (stretch,) = bit.periods
    assert stretch.period_s == pytest.approx(period, rel=0.01)
    assert stretch.frequency_hz == pytest.approx(1.0 / period, rel=0.01)
    assert stretch.cycles >= 9
    assert 0.8 < stretch.severity < 1.3
    assert stretch.slowest_rad_s < 1.4


def test_left_hand_rotation():
    time = np.arange(0.0, 6.0, 0.005)
    bit = followed(time, -sticking(time))
    assert bit.motion is BitMotion.STICK_SLIP
    assert bit.periods[0].period_s == pytest.approx(0.4, rel=0.01)


def test_steady_rotation_with_noise():
    time = np.arange(0.0, 30.0, 0.005)
    bit = followed(time, 9.0 + np.random.default_rng(1).normal(0.0, 0.5, time.size))
    assert bit.motion is BitMotion.STEADY
    assert bit.periods == []


def test_vibration_that_does_not_stick():
    time = np.arange(0.0, 10.0, 0.005)
    bit = followed(time, 9.0 * (1.0 + 0.6 * np.sin(2.0 * np.pi * time / 0.4)))
    assert bit.motion is BitMotion.VIBRATION
    assert bit.periods == []
    assert "severity 0.5" in bit.criterion or "severity 0.6" in bit.criterion


def test_it_begins_and_ends():
    time = np.arange(0.0, 20.0, 0.005)
    bit = followed(time, np.where((time > 5.0) & (time < 12.0), sticking(time), 9.0))
    assert bit.motion is BitMotion.STEADY
    (stretch,) = bit.periods
    assert stretch.start_s == pytest.approx(5.0, abs=0.5)
    assert stretch.end_s == pytest.approx(12.0, abs=0.5)


def test_unknown_speed_and_pauses():
    bit = StickSlip()
    bit.push(0.0, math.nan)
    assert bit.motion is BitMotion.UNKNOWN
    time = np.concatenate((np.arange(0.0, 4.0, 0.005), np.arange(60.0, 64.0, 0.005)))
    bit = followed(time, sticking(time))
    assert len(bit.periods) == 2
    assert max(stretch.longest_s for stretch in bit.periods) < 0.5
    bit.push(1.0, 3.0)  # from before: passed over
    assert bit.samples == time.size


def test_beside_whirl():
    """Both are found, and the whirl does not depend on the bit."""
    moved = motion(clock(100, 12), whirl=growth(6.0, 0.05, 1.5, 0.5), marks=MARKS)
    bit = sticking(moved.time)
    one, other, positions = Analyzer(MARKS), Analyzer(MARKS), moved.positions
    for i, stamp in enumerate(moved.stamps.tolist()):
        args = (positions[i], moved.spin[i], float(moved.top_speed[i]))
        found = one.push(stamp, *args, None, float(bit[i]))
        other.push(stamp, *args)
    assert found.bit is BitMotion.STICK_SLIP
    assert one.summary().onset == other.summary().onset is not None
    assert one.summary().stick_slip[0].period_s == pytest.approx(0.4, rel=0.01)
    assert other.summary().bit is BitMotion.UNKNOWN


def test_without_marks_whirl_is_not_observable():
    blind, time = BitOnlyAnalyzer(), np.arange(0.0, 6.0, 0.005)
    for at, speed in zip(time.tolist(), sticking(time).tolist(), strict=True):
        blind.push(round(at * 1e9), 9.0, speed)
    blind.push(0, 9.0, 9.0)
    blind.push(10**10, math.nan, math.nan)
    summary = blind.summary()
    assert not summary.observable
    assert summary.onset is None
    assert summary.motion == ()
    assert summary.rotation_rev_s == pytest.approx(9.0 / (2.0 * math.pi), rel=1e-6)
    assert (summary.quality.late, summary.quality.incomplete) == (1, 1)
    assert summary.bit is BitMotion.STICK_SLIP
    assert any("not observable" in note for note in summary.notes)


def test_severe_swing_that_never_sticks_is_no_stick_slip():
    time = np.arange(0.0, 10.0, 0.005)
    bit = followed(time, 9.0 * (0.3 + 2.0 * np.maximum(np.sin(2.0 * np.pi * time / 0.8), 0.0)))
    assert bit.motion is BitMotion.VIBRATION
    assert bit.periods == []
