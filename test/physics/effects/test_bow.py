# SPDX-License-Identifier: Apache-2.0
"""Bow: a stress-free shape that turns with the string."""

import numpy as np
import pytest
from rod_scenes import AT_REST, LENGTH, quiet_scene

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.random_draws import generator, random_line

DAMPING = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}
AMPLITUDE, ANGLE, DRAG = 4e-3, 0.6, 0.4


def hanging_bit(block: dict, elements: int = 24) -> complex:
    """Where the free bit of a bowed string comes to rest [m]; nothing but the bow bends it."""
    effects = {"bow": block, "drag": {"linear": 0.3}, "internal_damping": DAMPING}
    twin = Twin(quiet_scene(effects, form="lateral", bit_end="free", step=0.01, elements=elements))
    for _ in range(500):
        frame = twin.advance(AT_REST, 0.05)
    return complex(*frame.positions[0, :2])


@pytest.mark.parametrize("elements", [24, 48])
def test_a_crooked_string_takes_its_stress_free_shape(elements: int) -> None:
    """w(0) - w(L) + L w'(L) for the line w of that seed, whatever the mesh."""
    bit = hanging_bit({"amplitude": 1e-3, "shape": "random", "correlation_length": 1.5, "seed": 4}, elements)
    model = Twin(quiet_scene({})).model
    ends = np.array([0.0, LENGTH])
    line, slope = (random_line(ends, 1.5, generator(model, 4, "bow"), derivative=d) for d in (0, 1))
    assert bit == pytest.approx(1e-3 * (line[0] - line[1] + LENGTH * slope[1]), rel=1e-3)
