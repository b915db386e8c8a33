# SPDX-License-Identifier: Apache-2.0
"""Numbers of a scene by their keys."""

import pytest

from drill_twin.scene import load_scene
from drill_twin.scene.schema import number_at


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("effects.wall_friction.coefficient", 0.3),
        ("string.sections.0.length", 5.0),
        ("string.sections.7.length", None),
        ("string.sections.first.length", None),
        ("effects.nothing.at_all", None),
        ("name", None),
    ],
)
def test_a_number_is_found_by_its_key(key, value):
    scene = load_scene("pa6_bench", overrides={"effects.wall_friction.coefficient": 0.3})
    assert number_at(scene, key) == value
    assert load_scene("pa6_bench", overrides={"wall_friction.coefficient": 0.3}) == scene
