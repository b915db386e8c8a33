# SPDX-License-Identifier: Apache-2.0
"""Windows from samples of a rig that come late, twice, not at all, frozen or absurd, and from a clock that jumps."""

import math

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.studies.estimation.intake import Intake
from drill_twin.studies.estimation.prediction import WindowTiming

PACE = WindowTiming(0.01, 100, 10)


@pytest.fixture
def intake():
    return Intake(PACE, dt.load_scene("pa6_bench"), ["torque", "hookload"])


def wave(time):
    return {"torque": np.sin(time), "hookload": 10.0 + 0.1 * np.cos(7.0 * time)}


def feed(intake, times, values=wave, shift=100.0):
    for time in times:
        intake.take(shift + time, values(time))
    return [intake.window() for _ in range(intake.waiting)]


def test_samples_become_means_over_the_time_before_each_end(intake):
    times = np.arange(0, 301) * 0.01
    first, second = feed(intake, times)
    expected = [np.sin(times[1 + 10 * k : 11 + 10 * k]).mean() for k in range(20)]
    np.testing.assert_allclose(first.measured["torque"][1:], expected[1:10], atol=1e-12)
    np.testing.assert_allclose(second.measured["torque"], expected[10:], atol=1e-12)
    assert not intake.troubles
    schedule = dt.load_scene("pa6_bench").rig
    of_scene = [40.0 / 8.6, schedule.rotation.value / 8.0, 0.0]
    assert first.commands[-1] == pytest.approx(of_scene)  # none were given


def test_samples_that_are_instants_are_those_at_the_ends():
    intake = Intake(PACE, dt.load_scene("pa6_bench"), ["torque", "hookload"], instant={"torque"})
    times = np.delete(np.arange(0, 76) * 0.04, slice(40, 50))  # none from 1.6 to 2.0 s
    first, second = feed(intake, times)[:2]
    ends = np.arange(1, 11) * 0.1
    np.testing.assert_allclose(first.measured["torque"], np.sin(ends), atol=1e-3)
    np.testing.assert_allclose(second.measured["torque"][:5], np.sin(1.0 + ends[:5]), atol=1e-3)
    assert np.isnan(second.measured["torque"][6:9]).all()
    assert np.isfinite(second.measured["hookload"][:5]).all()


def test_set_points_are_interpolated_and_held(intake):
    given = lambda time: {"weight_on_bit": 20.0 * time, "rotation": 3.0} | wave(time)  # noqa: E731
    windows = feed(intake, np.arange(0, 101) * 0.02, given)
    windows += feed(intake, [2.5, 3.2], wave)
    np.testing.assert_allclose(windows[0].commands[:, 0], 20.0 * np.arange(1, 101) * 0.01)
    np.testing.assert_allclose(windows[2].commands, np.tile([40.0, 3.0, 0.0], (100, 1)))


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
