# SPDX-License-Identifier: Apache-2.0
"""What physics keeps, the twin keeps; what it does not tell apart, the twin does not either."""

import numpy as np
import pytest
from exact_cases import cases_of, check
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin_evidence.verify import Case
from drill_twin_evidence.verify.case import FORMS
from drill_twin_evidence.verify.numerics.symmetry import rotated_run, whirling_scene

SHORT = 0.4  # [s]
LOADS, SPEEDS = st.floats(5.0, 60.0), st.floats(-20.0, 20.0)
FRICTION, ANGLES = st.floats(0.0, 1.0), st.floats(-np.pi, np.pi)


@cases_of("numerics.conservation", "numerics.symmetry")
def test_kept(case: Case) -> None:
    check(case)


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=15, deadline=None)
@given(angle=ANGLES, load=LOADS, speed=SPEEDS, friction=FRICTION)
def test_no_direction_across_the_hole_is_special(
    form: str, angle: float, load: float, speed: float, friction: float
) -> None:
    """Turning the start about the hole's axis turns the whole motion, whatever the load, the speed and the friction."""
    scene = whirling_scene(form, wall_friction={"coefficient": friction})
    straight = rotated_run(scene, 0.0, load=load, speed=speed, seconds=SHORT)
    assert rotated_run(scene, angle, load=load, speed=speed, seconds=SHORT) == pytest.approx(straight, abs=1e-6)


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=15, deadline=None)
@given(load=LOADS, speed=SPEEDS, friction=FRICTION)
def test_a_mirror_image_turns_the_other_way(form: str, load: float, speed: float, friction: float) -> None:
    """The mirrored start, turned the other way, gives the mirrored motion."""
    scene = whirling_scene(form, wall_friction={"coefficient": friction})
    straight = rotated_run(scene, 0.0, load=load, speed=speed, seconds=SHORT)
    mirrored = rotated_run(scene, 0.0, mirror=True, load=load, speed=speed, seconds=SHORT)
    assert mirrored == pytest.approx(straight, abs=1e-6)


def test_same_scene_same_bits() -> None:
    """Two runs of one scene agree to the last bit."""
    assert np.array_equal(rotated_run(whirling_scene(), 0.3), rotated_run(whirling_scene(), 0.3))
