# SPDX-License-Identifier: Apache-2.0
"""Boundary of stick-slip by type of bit: the twin beside two masses on a spring."""

import math

import pytest

from drill_twin_evidence.validation import bit_types, soft_drive


@pytest.mark.parametrize(("kind", "below", "above"), [("roller_cone", 60.0, 110.0), ("hybrid", 120.0, 190.0)])
def test_two_masses_and_twin_stick_and_turn_on_the_same_sides(kind, below, above):
    for rpm, sticks in ((below, True), (above, False)):
        assert bit_types.sticks_on_a_spring(kind, rpm) is sticks
        assert bit_types.sticks_in_the_twin(kind, rpm) is sticks


def test_small_motion_decays_where_the_fall_of_the_torque_is_the_damping_of_the_spring():
    speed, step = bit_types.linear_boundary("pdc") * math.pi / 30.0, 1e-4
    torque = bit_types.torque_of("pdc")
    fall = (torque(speed - step) - torque(speed + step)) / (2.0 * step)
    assert fall == pytest.approx(bit_types.STIFFNESS * bit_types.RETARDATION, rel=1e-4)


def test_a_boundary_is_found_within_its_width_and_not_beyond_the_range():
    assert bit_types.boundary(lambda rpm: rpm < 123.0) == pytest.approx(123.0, abs=bit_types.APART)
    assert math.isnan(bit_types.boundary(lambda _: True))


def test_a_soft_drive_ends_the_stick_slip_that_a_prescribed_speed_keeps():
    kept, ended = (soft_drive.late_speeds(soft_drive.DRIVES[name], 120.0) for name in ("prescribed speed", "soft"))
    assert kept[:, 0].min() < 1.0
    assert ended[:, 0].min() > 100.0
    assert ended[:, 1].mean() == pytest.approx(120.0, rel=0.01)
