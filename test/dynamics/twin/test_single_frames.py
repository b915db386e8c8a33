# SPDX-License-Identifier: Apache-2.0
"""Frames made one at a time are those of a block, and stay as they are."""

import numpy as np
import pytest

from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command

PERIOD, COUNT = 0.01, 40
FAST = Command(300.0, 40.0)  # touches the wall within the run


@pytest.fixture(scope="module")
def scene():
    return load_scene("pa6_bench", overrides={"numerics.elements": "8", "numerics.step": "10 ms"})


def test_frames_one_at_a_time_are_those_of_a_block(scene):
    one, many = Twin(scene), Twin(scene)
    singles = [one.advance(FAST, PERIOD) for _ in range(COUNT)]
    frames, error = many.fill(many.record(COUNT), np.array([FAST.array()] * COUNT), PERIOD)
    assert error is None
    assert max(frame.wall_depth for frame in singles) > 0.0
    for name in ("time", "positions", "tangents", "spin", "wall_force", "wall_depth", "wall_depth_at", "rig"):
        np.testing.assert_array_equal([getattr(frame, name) for frame in singles], getattr(frames, name), name)
    for name in frames.marks._fields:
        found = [getattr(frame.marks, name) for frame in singles]
        np.testing.assert_array_equal(found, getattr(frames.marks, name), name)
    np.testing.assert_array_equal([frame.velocities for frame in singles], frames.v[..., 0:3])
    np.testing.assert_array_equal([frame.spin_rate for frame in singles], frames.v[..., 6])
    assert sum(frame.stats.iterations for frame in singles) == frames.stats.iterations
    for mine, other in zip(one.last_second(), many.last_second(), strict=True):
        np.testing.assert_array_equal(mine, other)


def test_a_frame_stays_as_it_is(scene):
    twin = Twin(scene)
    first = twin.advance(FAST, PERIOD)
    kept = first.positions.copy(), first.marks.centre.copy(), first.rig
    twin.advance(FAST, PERIOD)
    np.testing.assert_array_equal(first.positions, kept[0])
    np.testing.assert_array_equal(first.marks.centre, kept[1])
    assert first.rig == kept[2]


@pytest.mark.parametrize("shape", [(COUNT, 2), (COUNT, 4), (3,), (COUNT + 1, 3)])
def test_set_points_of_another_shape_are_refused(scene, shape):
    """Compiled code would read or write beyond them."""
    twin = Twin(scene)
    with pytest.raises(ArgumentError, match=r"set-points of shape \(F, 3\)"):
        twin.advance_frames(np.zeros(shape), PERIOD, twin.record(COUNT))
    assert twin.time == 0.0
