# SPDX-License-Identifier: Apache-2.0
"""Windows from samples of a rig that come late, twice, not at all, frozen or absurd, and from a clock that jumps."""

import math

import numpy as np
import pytest

import drill_twin as dt
from drill_twin_studies.estimation.estimate import WindowTiming
from drill_twin_studies.estimation.intake import Intake

PACE = WindowTiming(0.01, 100, 10)


@pytest.fixture
def intake():
    return Intake(PACE, dt.load_scene("pa6_bench"), ["torque", "hookload"])


def wave(time):
    return {"torque": np.sin(time), "hookload": 10.0 + 0.1 * np.cos(7.0 * time)}


def feed(intake, times, values=wave, shift=100.0):
    for time in times:
        intake.take(shift + time, values(time))
    return [intake.window() for _ in range(len(intake.ready))]


def test_samples_become_means_over_the_time_before_each_end(intake):
    times = np.arange(0, 301) * 0.01
    first, second = feed(intake, times)
    expected = [np.sin(times[1 + 10 * k : 11 + 10 * k]).mean() for k in range(20)]
    np.testing.assert_allclose(first.measured["torque"], expected[:10], atol=1e-12)
    np.testing.assert_allclose(second.measured["torque"], expected[10:], atol=1e-12)
    tenths = np.vstack((np.zeros((PACE.tail, 10)), np.kron(np.eye(10), np.full((10, 1), 0.1))))
    np.testing.assert_allclose(second.weights, [tenths, tenths], atol=1e-12)
    assert not intake.troubles
    schedule = dt.load_scene("pa6_bench").rig
    of_scene = [40.0 / 8.6, schedule.rotation.value / 8.0, 0.0]
    assert first.commands[-1] == pytest.approx(of_scene)  # none were given


def total(times, frames):
    """Integral from zero of a signal that is constant in each frame."""
    return np.interp(times, PACE.period * np.arange(frames.size + 1), np.append(0.0, np.cumsum(frames)) * PACE.period)


def record_of(kind, rate, draw):
    """Ends of the samples, stamps, and which of them are not lost."""
    ends = np.arange(1, int(9.9 * rate)) / rate
    stamps, kept = ends, np.ones(ends.size, dtype=bool)
    if kind == "late":
        ends = stamps = ends + 0.2 / rate + 1e-3
    elif kind == "fast clock":
        ends = stamps = ends * 1.0001
    elif kind == "uneven":
        ends = stamps = ends + draw.uniform(-0.09, 0.09, ends.size) / rate
    elif kind == "with losses":
        kept[5:] = draw.uniform(size=ends.size)[5:] > 0.2  # once the usual distance is known
    return ends, stamps, kept


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0, 7.0, 10.0, 20.0, 100.0])
@pytest.mark.parametrize("kind", ["exact", "late", "fast clock", "uneven", "with losses"])
def test_what_a_model_that_does_as_the_rig_is_compared_by_is_what_was_measured(intake, kind, rate):
    draw = np.random.default_rng(5)
    frames = draw.standard_normal(1000)
    ends, stamps, kept = record_of(kind, rate, draw)
    begins = np.append(0.0, ends[:-1])
    means = (total(ends, frames) - total(begins, frames)) / (ends - begins)
    intake.take(7.0, {"torque": 0.0})  # of the time before the first window
    for stamp, mean in zip(stamps[kept], means[kept], strict=True):
        intake.take(7.0 + stamp, {"torque": mean})
    count = 0
    padded = np.append(np.zeros(PACE.tail), frames)
    for number in range(len(intake.ready)):
        window = intake.window()
        known = np.isfinite(window.measured["torque"])
        own = padded[100 * number :][: PACE.tail + 100] @ window.weights[0]
        np.testing.assert_allclose(own[known], window.measured["torque"][known], atol=3e-4)  # stamps of 1 us
        np.testing.assert_allclose(window.weights[0].sum(axis=0), known, atol=1e-9)
        count += known.sum()
    usual = min(rate, 10.0) * number
    assert count >= (0.6 if kind == "with losses" else 0.95) * usual - 1
    assert not intake.troubles


def test_samples_that_are_instants_are_compared_at_their_times():
    intake = Intake(PACE, dt.load_scene("pa6_bench"), ["torque"], instant={"torque"})
    times = np.delete(np.arange(1, 76) * 0.0437, slice(36, 46))  # none from 1.58 to 2.05 s
    ends = np.arange(1 - PACE.tail, 201) * PACE.period
    intake.take(100.0, {})
    for number, window in enumerate(feed(intake, times)[:2]):
        known = np.isfinite(window.measured["torque"])
        own = np.sin(ends[100 * number :][: PACE.tail + 100]) @ window.weights[0]
        np.testing.assert_allclose(own[known], window.measured["torque"][known], atol=1e-4)
        assert known.all()


def test_a_slow_record_is_not_missing_between_its_samples(intake):
    between = [window.between for window in feed(intake, np.arange(0, 10) * 2.0)]
    assert between == [k > 0 and k % 2 == 0 for k in range(len(between))]
    assert not intake.troubles
    lost = [window.between for window in feed(intake, [22.0, 24.0])]
    assert not any(lost[::2])
    assert intake.troubles["missing window"] > 0


def test_means_that_last_too_long_are_left_out_and_told(intake):
    windows = feed(intake, np.arange(0, 6) * 4.0)
    assert all(np.isnan(window.measured["torque"]).all() for window in windows)
    assert not any(window.between for window in windows[4:])
    assert intake.troubles["mean of more than 2.5 s"] > 0


def test_set_points_are_interpolated_and_held(intake):
    given = lambda time: {"weight_on_bit": 20.0 * time, "rotation": 3.0} | wave(time)  # noqa: E731
    windows = feed(intake, np.arange(0, 101) * 0.02, given)
    windows += feed(intake, [2.5, 3.2], wave)
    np.testing.assert_allclose(windows[0].commands[:, 0], 20.0 * np.arange(1, 101) * 0.01)
    np.testing.assert_allclose(windows[2].commands, np.tile([40.0, 3.0, 0.0], (100, 1)))


def test_set_points_go_on_to_those_of_the_sample_after_the_window(intake):
    windows = feed(intake, [0.0, 0.7, 1.4, 2.1], lambda time: {"weight_on_bit": 20.0 * time} | wave(time))
    np.testing.assert_allclose(windows[0].commands[:, 0], 20.0 * np.arange(1, 101) * 0.01)


def test_late_repeated_and_missing_samples_are_counted_and_left_out(intake):
    feed(intake, np.arange(0, 250) * 0.01)
    intake.take(math.nan, {"torque": 1e3})
    intake.take(101.9, {"torque": 1e3})  # its window is closed
    intake.take(102.49, wave(2.49))  # the newest again
    intake.take(102.3, wave(2.3))  # late within the open window: taken
    windows = feed(intake, np.arange(450, 700) * 0.01)
    assert intake.troubles == {"stamp not finite": 1, "late": 1, "repeated": 1, "missing window": 1}
    assert np.isnan(windows[1].measured["torque"]).all()
    assert np.isfinite(windows[-1].measured["torque"]).all()


@pytest.mark.parametrize("jump", [-50.0, 1e6])
def test_time_goes_on_when_the_clock_jumps(intake, jump):
    windows = feed(intake, np.arange(0, 201) * 0.01)
    windows += feed(intake, np.arange(201, 503) * 0.01, shift=100.0 + jump)
    assert len(windows) == 5
    assert intake.troubles == {"clock jump": 1}
    np.testing.assert_allclose(windows[-1].measured["torque"], np.sin(np.arange(4.05, 5.0, 0.1)), atol=0.02)
    assert intake.origin == pytest.approx(100.0 + jump, abs=0.02)


def test_absurd_samples_are_left_out_and_a_step_is_not(intake):
    def values(time):
        torque = 1e9 if round(time * 100) in {150, 161} else np.inf if round(time * 100) == 170 else np.sin(time)
        return {"torque": torque, "hookload": 10.0 if time < 1.5 else 5.0}

    windows = feed(intake, np.arange(0, 301) * 0.01, values)
    assert intake.troubles == {"absurd": 2}
    assert np.nanmax(np.abs(windows[1].measured["torque"])) <= 1.0
    np.testing.assert_allclose(windows[1].measured["hookload"][[0, -1]], [10.0, 5.0])


def test_frozen_channel_is_told_and_left_out_until_it_changes(intake):
    def values(time):
        return wave(min(time, 2.0) if time < 7.0 else time) | {"hookload": 10.0 + 0.1 * np.cos(7.0 * time)}

    windows = feed(intake, np.arange(0, 902) * 0.01, values)
    assert intake.troubles["frozen"] == 1
    assert np.isnan(windows[6].measured["torque"]).all()
    assert np.isfinite(windows[6].measured["hookload"]).all()
    assert np.isfinite(windows[8].measured["torque"]).all()
    assert not intake.frozen


def test_channel_that_never_changed_is_not_frozen(intake):
    windows = feed(intake, np.arange(0, 601) * 0.01, lambda _: {"torque": 0.0})
    assert np.isfinite(windows[4].measured["torque"]).all()


@pytest.mark.parametrize(
    ("factor", "told"), [(1.0, ""), (1.04, ""), (0.9, "turns at 108 rpm"), (1.1, "turns at 132 rpm")]
)
def test_a_drive_that_does_not_turn_at_its_set_point_is_told(intake, factor, told):
    at_work = 120.0 * math.pi / 30.0

    def values(time):
        swing = 1.0 + 0.5 * np.sin(2.0 * np.pi * time / 5.0)  # of a soft drive in stick-slip
        return wave(time) | {"rotation": at_work, "top_drive_speed": factor * at_work * swing}

    feed(intake, np.arange(0, 1501) * 0.01, values)
    assert intake.drive.told == ""  # it may still run up
    feed(intake, np.arange(1501, 2502) * 0.01, values)
    assert told in intake.drive.told
    assert bool(told) == bool(intake.drive.told)
    feed(intake, np.arange(2502, 2703) * 0.01, lambda time: values(time) | {"rotation": 0.5 * at_work})
    assert intake.drive.told == ""  # the set-point has changed


def test_a_drive_whose_speed_is_not_measured_is_not_judged(intake):
    feed(intake, np.arange(0, 2502) * 0.01, lambda time: wave(time) | {"rotation": 12.0})
    assert intake.drive.told == ""
