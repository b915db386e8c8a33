# SPDX-License-Identifier: Apache-2.0
"""Wall, stabiliser and stretch return exactly the energy that they stored, however long the step; exact tangents."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drill_twin.core.compile.jit import as_python
from drill_twin.physics.effects import bit_stabiliser, wall
from drill_twin.physics.model import strain
from drill_twin.physics.model.strain import Point
from drill_twin.physics.model.wellbore import Wellbore

CLEARANCE, HERTZ, LINEAR, AXIAL = 0.08, 1e7, 1e6, 5e5
angles = st.floats(0.0, 2.0 * np.pi)
halves = st.floats(1e-5, 1e-2)  # of a step [s]
depths = st.floats(-1e-3, 1e-3)  # where it starts [m]
speeds = st.floats(0.01, 3.0)  # [m/s]


def law(linear: bool, damping: float = 0.0) -> wall.Parameters:
    bore = Wellbore(np.array([CLEARANCE]), None)
    return wall.Parameters(bore, np.array([0.008]), LINEAR if linear else HERTZ, float(linear), damping)


def push(
    parameters: wall.Parameters, start: np.ndarray, v: np.ndarray, half_step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Force of the wall over the step from a place, per length, and minus its derivative by the velocity."""
    x, y = start + half_step * v
    seen = dict.fromkeys(Point._fields, 0.0) | {"x": x, "y": y, "vx": v[0], "vy": v[1], "tz": 1.0, "place": 0}
    load, stiff = np.zeros(4), np.zeros((4, 4))
    as_python(wall.distributed_load)(type("All", (), {"wall": parameters}), None, Point(**seen), half_step, load, stiff)
    return load[:2], stiff[:2, :2]


def stored(linear: bool, place: np.ndarray) -> float:
    depth = max(float(np.hypot(*place)) - CLEARANCE, 0.0)
    return 0.5 * LINEAR * depth**2 if linear else 0.4 * HERTZ * depth**2.5


@given(linear=st.booleans(), angle=angles, way=angles, depth=depths, half_step=halves, speed=speeds)
def test_the_wall_gives_back_what_it_took(linear, angle, way, depth, half_step, speed):
    start = (CLEARANCE + depth) * np.array([np.cos(angle), np.sin(angle)])
    v = speed * np.array([np.cos(way), np.sin(way)])
    force, _ = push(law(linear), start, v, half_step)
    before, after = stored(linear, start), stored(linear, start + 2.0 * half_step * v)
    assert -2.0 * half_step * (force @ v) == pytest.approx(
        after - before, rel=1e-9, abs=1e-9 * max(before, after, 1e-9)
    )


@given(linear=st.booleans(), angle=angles, way=angles, depth=depths, half_step=halves, speed=speeds)
def test_a_wall_with_loss_never_gives_back_more(linear, angle, way, depth, half_step, speed):
    start = (CLEARANCE + depth) * np.array([np.cos(angle), np.sin(angle)])
    v = speed * np.array([np.cos(way), np.sin(way)])
    force, _ = push(law(linear, damping=5.0), start, v, half_step)
    before, after = stored(linear, start), stored(linear, start + 2.0 * half_step * v)
    assert -2.0 * half_step * (force @ v) >= after - before - 1e-9 * max(before, after, 1e-9)


@given(linear=st.booleans(), angle=angles, way=angles, depth=st.floats(1e-5, 1e-3), half_step=halves, speed=speeds)
def test_the_tangent_of_the_wall_is_its_derivative(linear, angle, way, depth, half_step, speed):
    start = (CLEARANCE + depth) * np.array([np.cos(angle), np.sin(angle)])
    v = speed * np.array([np.cos(way), np.sin(way)])
    assume(np.hypot(*(start + 2.0 * half_step * v)) > CLEARANCE + 1e-6)  # away from the kinks of the law
    parameters, small = law(linear, damping=0.05), 1e-6 * speed
    _, tangent = push(parameters, start, v, half_step)
    change = [
        (push(parameters, start, v - small * e, half_step)[0] - push(parameters, start, v + small * e, half_step)[0])
        / (2.0 * small)
        for e in np.eye(2)
    ]
    assert tangent == pytest.approx(np.array(change).T, abs=1e-4 * np.abs(tangent).max())


@given(
    start=st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.7, 1.2)),
    rate=st.tuples(*[st.floats(-20.0, 20.0)] * 3), half_step=halves,
)  # fmt: skip
def test_stretch_gives_back_what_it_took(start, rate, half_step):
    start, rate = np.array(start), np.array(rate)
    a, force, saa = start + half_step * rate, np.zeros(8), np.zeros((3, 3))
    end = start + 2.0 * half_step * rate
    assume(np.linalg.norm(end) > 0.3)
    s = as_python(strain.stretching)(tuple(a), tuple(rate), half_step)
    as_python(strain.stretch_forces)(AXIAL, 0.0, 0.0, tuple(a), s, half_step, force, saa)
    before, after = (0.5 * AXIAL * (np.linalg.norm(x) - 1.0) ** 2 for x in (start, end))
    assert 2.0 * half_step * (force[:3] @ rate) == pytest.approx(
        after - before, rel=1e-8, abs=1e-8 * max(before, after, 1e-6)
    )


def blades(damping: float = 0.0, friction: float = 0.0) -> bit_stabiliser.Parameters:
    memory = np.array([0.0, 0.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0])
    return bit_stabiliser.Parameters(CLEARANCE, 0.02, LINEAR, damping, friction, 0.0, 1e-3, memory)


def pushed(
    law: bit_stabiliser.Parameters, start: np.ndarray, rate: np.ndarray, half_step: float
) -> tuple[np.ndarray, ...]:
    """Force on x, y, z and spin of the bit over the step from a place, and minus its derivative by their rates."""
    u, v, which = np.zeros((1, 7)), np.zeros((1, 7)), [0, 1, 2, 6]
    u[0, :2], v[0, which] = start + half_step * rate[:2], rate
    for _ in range(2):  # at the same rate twice, so that the dual variable is that of the rate
        ends = np.zeros((2, 7, 8))
        parameters = type("All", (), {"bit_stabiliser": law})
        as_python(bit_stabiliser.end_load)(parameters, None, np.zeros(2), 0.0, half_step, u, v, v, ends)
    return -ends[0, which, 7], ends[0][np.ix_(which, which)]


@given(angle=angles, way=angles, depth=depths, half_step=halves, speed=speeds, damping=st.sampled_from([0.0, 1e3]))
def test_the_stabiliser_returns_what_it_stored(angle, way, depth, half_step, speed, damping):
    start = (CLEARANCE + depth) * np.array([np.cos(angle), np.sin(angle)])
    rate = speed * np.array([np.cos(way), np.sin(way), 0.3, 0.0])
    before, after = (
        0.5 * LINEAR * max(np.hypot(*place) - CLEARANCE, 0.0) ** 2
        for place in (start, start + 2.0 * half_step * rate[:2])
    )
    gained = -2.0 * half_step * float(pushed(blades(damping), start, rate, half_step)[0] @ rate) - (after - before)
    small = 1e-9 * max(before, after, 1e-9)
    assert gained >= -small
    assert damping > 0.0 or gained <= small
    assert (
        -2.0 * half_step * float(pushed(blades(damping, 0.5), start, rate, half_step)[0] @ rate)
        >= after - before - small
    )


@given(
    angle=angles, way=angles, depth=st.floats(1e-5, 1e-3), half_step=halves, speed=speeds,
    along=st.floats(-1.0, 1.0), spin=st.floats(-20.0, 20.0),
)  # fmt: skip
def test_the_tangent_of_the_stabiliser_is_its_derivative(angle, way, depth, half_step, speed, along, spin):
    start = (CLEARANCE + depth) * np.array([np.cos(angle), np.sin(angle)])
    rate = np.array([speed * np.cos(way), speed * np.sin(way), along, spin])
    law, small = blades(damping=20.0, friction=0.4), 1e-7
    force, tangent = pushed(law, start, rate, half_step)
    assume(np.hypot(*(start + 2.0 * half_step * rate[:2])) > CLEARANCE + 1e-6)  # away from the kinks of the law
    assume(np.linalg.norm(force) > 1.0)
    across = (start[0] * rate[1] - start[1] * rate[0]) / np.hypot(*(start + half_step * rate[:2])) + 0.02 * spin
    assume(np.hypot(across, along) > 0.02)
    change = [
        (pushed(law, start, rate - small * e, half_step)[0] - pushed(law, start, rate + small * e, half_step)[0])
        / (2.0 * small)
        for e in np.eye(4)
    ]
    assert tangent == pytest.approx(np.array(change).T, abs=1e-4 * np.abs(tangent).max())
