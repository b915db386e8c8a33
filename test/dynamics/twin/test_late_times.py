# SPDX-License-Identifier: Apache-2.0
"""A run of weeks takes the steps of a run of seconds: the rounding of late times adds none."""

import pytest

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command


@pytest.mark.parametrize("late", [5.0e4, 1.0e6, 3.1e7])
def test_a_late_frame_takes_as_many_steps_as_the_first(late):
    twin = Twin(load_scene("pa6_bench"))
    command = Command(40.0, 12.0)
    first = [twin.advance(command, 0.01).stats.steps for _ in range(10)]
    arrays = twin.checkpoint()
    clock = next(name for name, array in arrays.items() if name.endswith("clock"))
    arrays[clock][0] += late
    twin.restore(arrays)
    before = twin.time
    frames = [twin.advance(command, 0.01) for _ in range(40)]
    assert before > late
    assert {frame.stats.steps for frame in frames} <= set(first)
    assert frames[-1].time == pytest.approx(before + 0.4, abs=1e-6)
