# SPDX-License-Identifier: Apache-2.0
"""The real-time factor is simulated over wall time, whatever the physics could do; pauses are left out of it."""

from types import SimpleNamespace

import pytest

from drill_twin.dynamics.twin.frame import StepStats
from drill_twin.runs import monitor
from drill_twin.runs.monitor import RunTiming

STATS = StepStats(steps=1, iterations=2, cut_steps=0, steps_above_tolerance=0, wall_seconds=0.001)


@pytest.fixture
def wall(monkeypatch):
    wall = SimpleNamespace(now=50.0)
    wall.monotonic = lambda: wall.now
    monkeypatch.setattr(monitor, "time", wall)
    return wall


def frames(timing, wall, count, waits=0.008):
    """Frames of 10 ms that take 1 ms to compute, 1 ms to publish, and wait."""
    for _ in range(count):
        wall.now += 0.002
        timing.update(0.01, 0.001, STATS)
        wall.now += waits


def test_a_run_held_to_real_time_has_a_factor_of_one_and_faster_physics(wall):
    timing = RunTiming()
    frames(timing, wall, 1000)
    assert timing.realtime_factor == pytest.approx(1.0, rel=1e-3)
    assert timing.recent_realtime_factor == pytest.approx(1.0, rel=1e-3)
    assert timing.physics_speed == pytest.approx(10.0)


def test_a_run_that_waits_for_nothing_has_a_factor_below_the_speed_of_its_physics(wall):
    timing = RunTiming()
    frames(timing, wall, 100, waits=0.0)
    assert timing.realtime_factor == pytest.approx(5.0)
    assert timing.physics_speed == pytest.approx(10.0)


def test_a_pause_is_left_out_of_the_run_and_is_zero_meanwhile(wall):
    timing = RunTiming()
    frames(timing, wall, 100)
    timing.pause()
    timing.start_window()
    wall.now += 60.0
    assert timing.recent_realtime_factor == 0.0
    frames(timing, wall, 100)
    assert timing.realtime_factor == pytest.approx(1.0, rel=0.01)


def test_a_wait_for_commands_counts(wall):
    timing = RunTiming()
    frames(timing, wall, 100)
    wall.now += 9.0
    frames(timing, wall, 100)
    assert timing.realtime_factor == pytest.approx(2.0 / 11.0, rel=0.01)


def test_a_window_that_has_just_begun_repeats_the_one_before(wall):
    timing = RunTiming()
    frames(timing, wall, 100)
    timing.start_window()
    frames(timing, wall, 1)
    assert timing.recent_realtime_factor == pytest.approx(1.0, rel=0.01)
    frames(timing, wall, 50, waits=0.018)
    assert timing.recent_realtime_factor == pytest.approx(0.5, rel=0.02)


def test_nothing_is_known_before_the_first_frame(wall):
    timing = RunTiming()
    assert (timing.realtime_factor, timing.recent_realtime_factor, timing.physics_speed) == (0.0, 0.0, 0.0)
    assert timing.text() == "nothing simulated yet"
