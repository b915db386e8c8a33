# SPDX-License-Identifier: Apache-2.0
"""Set-points over time: constant, STEP of ADAMS, ramp, and what holds before and after."""

import math
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Command, Schedule
from drill_twin.scene.set_points.schedule import ramp, step


def scene(overrides: Mapping[str, str]) -> Scene:
    return load_scene("pa6_bench", overrides=overrides)


def test_the_paper_scene_ramps_up_and_then_holds():
    schedule = Schedule.from_scene(load_scene("pa6_bench"))
    assert schedule.duration == 30.0
    assert schedule.record is None
    assert schedule.at(0.0) == Command(weight_on_bit=0.0, rotation=0.0)
    assert schedule.at(4.3).weight_on_bit == pytest.approx(20.0)
    assert schedule.at(2.0).rotation == pytest.approx(math.pi)
    for time in (8.6, 30.0, 1e6):
        assert schedule.at(time) == Command(weight_on_bit=40.0, rotation=pytest.approx(4.0 * math.pi))


def test_constant_is_there_from_the_start():
    schedule = Schedule.from_scene(
        scene({"rig.weight_on_bit": "{value: 100 N}", "rig.rotation": "{shape: constant, value: -1 rev/s}"})
    )
    for time in (0.0, 3.0, 100.0):
        assert schedule.at(time) == Command(weight_on_bit=100.0, rotation=pytest.approx(-2.0 * math.pi))


def test_a_ramp_starts_late_from_another_value():
    change = "{shape: ramp, initial: 10 N, value: -30 N, start: 2 s, duration: 4 s}"
    schedule = Schedule.from_scene(scene({"rig.weight_on_bit": change}))
    loads = [schedule.at(time).weight_on_bit for time in (0.0, 2.0, 3.0, 4.0, 6.0, 9.0)]
    assert loads == pytest.approx([10.0, 10.0, 0.0, -10.0, -30.0, -30.0])


@pytest.mark.parametrize("shape", ["step", "ramp"])
def test_a_change_without_duration_happens_at_once(shape):
    change = f"{{shape: {shape}, value: 30 N, start: 2 s}}"
    schedule = Schedule.from_scene(scene({"rig.weight_on_bit": change}))
    assert [schedule.at(time).weight_on_bit for time in (1.999, 2.0)] == [0.0, 30.0]


def test_step_is_the_cubic_of_adams():
    """STEP(x, x0, h0, x1, h1) = h0 + (h1 - h0) d^2 (3 - 2 d), d = (x - x0)/(x1 - x0)."""
    assert step(1.25, 1.0, 10.0, 2.0, 50.0) == pytest.approx(10.0 + 40.0 * (3.0 / 16.0 - 2.0 / 64.0))
    small = 1e-5
    for end in (1.0, 2.0):  # level where it begins and ends
        slope = (step(end + small, 1.0, 0.0, 2.0, 1.0) - step(end - small, 1.0, 0.0, 2.0, 1.0)) / (2.0 * small)
        assert abs(slope) < 1e-4
    middle = (step(1.5 + small, 1.0, 0.0, 2.0, 1.0) - step(1.5 - small, 1.0, 0.0, 2.0, 1.0)) / (2.0 * small)
    assert middle == pytest.approx(1.5, rel=1e-6)


TIMES = st.floats(0.0, 1e6)
VALUES = st.floats(-1e8, 1e8)


@settings(deadline=None)
@given(TIMES, TIMES, TIMES, VALUES, VALUES)
def test_no_change_overshoots(time, start, duration, before, after):
    low, high = min(before, after), max(before, after)
    margin = 1e-12 * (abs(low) + abs(high))
    for shape in (step, ramp):
        assert low - margin <= shape(time, start, before, start + duration, after) <= high + margin
