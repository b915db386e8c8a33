# SPDX-License-Identifier: Apache-2.0
"""Other numbers in the middle of a run: what is remembered stays, and every bound follows."""

import numpy as np
import pytest
from rod_scenes import ROLLING, STRESSED, quiet_scene

from drill_twin.core.compile.packed_arguments import named_arrays
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command


def test_the_same_numbers_change_nothing():
    """NaN is remembered too, and differs from itself: a turning point was lost."""
    scene = quiet_scene(ROLLING, of=STRESSED, radius=0.04, step=2e-3)
    twin = Twin(scene)
    for _ in range(50):
        twin.advance(Command(30.0, 6.0), 0.01)
    before = twin.checkpoint()
    assert any(np.isnan(array).any() for _, array in named_arrays("", Twin(scene).dynamics.parameters))
    twin.change_numbers(scene)
    for name, array in twin.checkpoint().items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


@pytest.mark.parametrize("when", [0, 20])
def test_guard_and_tolerance_follow_a_stiffer_wall(when):
    other = load_scene("pa6_bench", overrides={"effects.wall.stiffness": "1e9 N/m^2.5"})
    twin, wanted = Twin(load_scene("pa6_bench")), Twin(other)
    for _ in range(when):
        twin.advance(Command(10.0, 6.0), 0.01)
    twin.change_numbers(other)
    for each in (twin, wanted):
        found = each.advance(Command(10.0, 6.0), 0.01)
    assert twin.dynamics.bound.bounds == wanted.dynamics.bound.bounds
    assert twin.dynamics.bound.bounds.stiffness == twin.dynamics.bound.wall.stiffness == 1e9
    assert twin.dynamics._control == wanted.dynamics._control
    if not when:
        np.testing.assert_array_equal(twin.unknowns[0], wanted.unknowns[0])
        assert found.time == twin.time
