# SPDX-License-Identifier: Apache-2.0
"""Stick-slip of the bit, from its speed alone."""

import math

import numpy as np
import pytest
from kinematics import MARKS, clock, growth, motion

from drill_twin.whirl import Analyzer, BitMotion, BitOnlyAnalyzer, StickSlip
from drill_twin.whirl.motion.stick_slip_index import stick_slip_index


def sticking(time, period=0.4, mean=9.0):
    """A bit that stands still once in a period."""
    return np.maximum(mean * (1.0 + 1.3 * np.sin(2.0 * np.pi * time / period)), 0.0)


def followed(time, speed, top=9.0):
    bit = StickSlip()
    for at, value, drive in zip(time.tolist(), speed.tolist(), np.broadcast_to(top, time.shape).tolist(), strict=True):
        bit.push(at, value, drive)
    return bit


@pytest.mark.parametrize("rate", [100, 1000])
@pytest.mark.parametrize("period", [0.25, 0.4, 4.5])
def test_period_and_severity(rate, period):
    time = np.arange(0.0, 2.0 + 12.0 * period, 1.0 / rate)
    bit = followed(time, sticking(time, period))
    assert bit.motion is BitMotion.STICK_SLIP
    (stretch,) = bit.periods
    assert stretch.period_s == pytest.approx(period, rel=0.01)
    assert stretch.frequency_hz == pytest.approx(1.0 / period, rel=0.01)
    assert stretch.cycles >= 9
    assert 1.0 < stretch.severity < 1.3
    assert stretch.slowest_rad_s < 1.4


def test_left_hand_rotation():
    time = np.arange(0.0, 6.0, 0.005)
    bit = followed(time, -sticking(time), -9.0)
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
    assert bit.criterion.startswith("stick-slip index 0.58")  # 0.6, low-passed


def test_it_begins_and_ends():
    time = np.arange(0.0, 40.0, 0.005)
    bit = followed(time, np.where((time > 5.0) & (time < 12.0), sticking(time), 9.0))
    assert bit.motion is BitMotion.STEADY
    (stretch,) = bit.periods
    assert stretch.start_s == pytest.approx(5.0, abs=0.5)
    assert stretch.end_s == pytest.approx(12.0, abs=0.5)


def test_unknown_speed_and_pauses():
    bit = StickSlip()
    bit.push(0.0, math.nan)
    assert bit.motion is BitMotion.UNKNOWN
    time = np.concatenate((np.arange(0.0, 6.0, 0.005), np.arange(60.0, 66.0, 0.005)))
    bit = followed(time, sticking(time))
    assert len(bit.periods) == 2
    assert max(stretch.longest_s for stretch in bit.periods) < 0.5
    bit.push(1.0, 3.0)  # from before: passed over
    assert bit.speed.samples[0] == time.size


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


@pytest.mark.parametrize("swing", [0.1, 0.45, 0.55, 0.875, 0.9, 1.3])
@pytest.mark.parametrize("period", [0.8, 5.5, 9.0])
def test_index_and_its_classes(period, swing):
    """Steady below 0.5, stick-slip from 1: of a record of 60 s at 50 Hz, low-passed by little."""
    time = np.arange(0.0, 60.0, 0.02)
    speed = np.maximum(12.0 * (1.0 + swing * np.sin(math.tau * time / period)), 0.0)
    exact = stick_slip_index(speed)
    assert exact == np.ptp(speed) / (2.0 * np.mean(speed))
    assert followed(time, speed, 12.0).index == pytest.approx(exact, rel=0.08)
    assert followed(time, speed, math.nan).index == pytest.approx(exact, rel=0.08)
    motion = followed(time, speed, 12.0).motion
    assert motion is (BitMotion.STEADY if exact < 0.5 else BitMotion.VIBRATION if exact < 1.0 else BitMotion.STICK_SLIP)


@pytest.mark.parametrize("ramp", [0.0, 5.0, 25.0])
def test_a_start_from_rest_is_no_stick_slip(ramp):
    """The bit stands and rings while the string is wound up, breaks loose, overshoots and settles."""
    time = np.arange(0.0, 80.0, 0.02)
    top = 12.0 * np.minimum(time / max(ramp, 1e-9), 1.0)
    loose = np.maximum(time - 3.0, 0.0)
    ringing = 0.3 * np.sin(math.tau * 8.9 * time)
    speed = np.where(time < 3.0, ringing, top * (1.0 - np.cos(loose) * np.exp(-loose / 4.0)))
    motions, bit = [], StickSlip()
    for values in zip(time.tolist(), speed.tolist(), top.tolist(), strict=True):
        bit.push(*values)
        motions.append(bit.motion)
    assert bit.motion is BitMotion.STEADY
    assert motions[-1] is BitMotion.STEADY
    before = {*motions[: round(50 * max(ramp, 3.0))]}
    assert before <= {BitMotion.AT_REST, BitMotion.STARTING, BitMotion.EARLY}
    assert (BitMotion.STARTING in before) is (ramp > 0.0)  # a ramp is seen; a jump before the first sample is not
    assert all(period.severity < 1.3 for period in bit.periods)
    assert bit.index < 0.05


def test_at_speed_from_the_first_sample_on_there_was_no_start_up():
    """A run that begins at speed said `start-up` for ten seconds."""
    time, motions, bit = np.arange(0.0, 15.0, 0.02), [], StickSlip()
    for at in time.tolist():
        bit.push(at, 12.0, 12.0)
        motions.append(bit.motion)
    assert list(dict.fromkeys(motions)) == [BitMotion.EARLY, BitMotion.STEADY]
    at_rest = followed(time, np.where(time < 3.0, 0.0, 12.0), np.where(time < 3.0, 0.0, 12.0))
    assert at_rest.motion is BitMotion.STEADY
    assert followed(time[:300], np.where(time < 3.0, 0.0, 12.0)[:300], 12.0 * (time[:300] > 3.0)).motion is (
        BitMotion.STARTING
    )


def test_a_bit_that_stands_still_and_a_string_that_stops():
    time = np.arange(0.0, 90.0, 0.02)
    bit = followed(time, np.where(time < 30.0, 12.0, 0.01), 12.0)
    assert bit.motion is BitMotion.STANDS
    assert math.isnan(bit.index)
    stopped = followed(time, np.where(time < 30.0, 12.0, 0.0), np.where(time < 30.0, 12.0, 0.0))
    assert stopped.motion is BitMotion.AT_REST
    assert stopped.largest_index < 0.1


def test_the_index_of_an_array():
    turning = 1.0 + np.sin(np.linspace(0.0, 20.0 * math.pi, 2000))
    assert stick_slip_index(turning) == pytest.approx(1.0, rel=1e-3)
    assert stick_slip_index(12.0 + 0.1 * turning) < 0.1
    assert stick_slip_index(np.full(9, 3.0)) == 0.0
    assert stick_slip_index(np.array([-1.0, 1.0])) == math.inf


def free_swing(decrement, mean=9.0, period=6.0, cycles=12, height=1.1):
    """A swing about the mean whose height falls by a logarithmic decrement a cycle, and its times [s]."""
    time = np.arange(0.0, cycles * period, 0.05)
    swing = height * np.exp(-decrement * time / period) * np.sin(2.0 * np.pi * time / period)
    return time, np.maximum(mean * (1.0 + swing), 0.0)


@pytest.mark.parametrize("decrement", [0.03, 0.05, 0.1])
@pytest.mark.parametrize("height", [0.9, 1.1])
def test_a_free_swing_that_dies_away_is_no_stick_slip(decrement, height):
    bit = followed(*free_swing(decrement, height=height, cycles=7))
    assert bit.motion is BitMotion.DECAYING
    assert bit.periods == []
    assert bit.decrement[0] == pytest.approx(decrement, abs=0.25 * decrement)
    assert bit.index > 0.5  # what the index is does not depend on why


def test_a_steady_or_growing_swing_does_not_die_away():
    for decrement in (0.0, -0.05):
        bit = followed(*free_swing(decrement))
        assert bit.motion is BitMotion.STICK_SLIP
        assert bit.periods[-1].cycles > 5


def test_two_cycles_do_not_tell_whether_a_swing_dies_away():
    bit = followed(*free_swing(0.05, height=0.9, cycles=4))
    assert bit.motion is BitMotion.VIBRATION
    assert bit.criterion.endswith("whether it dies away is not known yet")
