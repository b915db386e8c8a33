# SPDX-License-Identifier: Apache-2.0
"""Wall and wall friction: a string that lies in a horizontal hole."""

import numpy as np
import pytest
from scenes import LINE_MASS, rod_scene

from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

LENGTH, CLEARANCE = 20.0, 0.01
EFFECTS = {
    "gravity": {"magnitude": 9.81},
    "drag": {"linear": 1.0},
    "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "wall": {"stiffness": 1e7},
    "wall_friction": {"coefficient": 0.3},
}


def lying(speed: float, elements: int) -> Twin:
    scene = rod_scene(
        effects=EFFECTS, length=LENGTH, elements=elements, radius=CLEARANCE + 0.00825, inclination=np.pi / 2,
        marks=(LENGTH / 2,), step=2e-3,
    )  # fmt: skip
    twin = Twin(scene)
    for k in range(300):
        twin.step(Command(weight_on_bit=0.0, rotation=speed * min((k + 1) / 100.0, 1.0)), 0.02)
    return twin


@pytest.mark.parametrize("elements", [40, 80])
def test_the_wall_carries_the_weight(elements: int) -> None:
    """Far from the ends the wall carries w per length at a penetration (w / K)^(2/3), whatever the mesh."""
    twin = lying(0.0, elements)
    frame = twin.step(Command(weight_on_bit=0.0, rotation=0.0), 0.02)
    weight = LINE_MASS * 9.81
    inside = slice(elements // 4, -elements // 4)
    assert frame.wall_force[inside] * elements / LENGTH == pytest.approx(weight, rel=1e-3)
    assert frame.marks.centre[0, 0] - CLEARANCE == pytest.approx((weight / 1e7) ** (2.0 / 3.0), rel=1e-2)
    assert abs(frame.marks.centre[0, 1]) < 1e-6


@pytest.mark.parametrize("speed", [6.0, -6.0])
def test_friction_makes_the_string_climb(speed: float) -> None:
    """A turning string climbs against its rotation to the friction angle: tan(phi) = mu; the drive pays mu N r."""
    frame = lying(speed, 40).step(Command(weight_on_bit=0.0, rotation=speed), 0.02)
    angle = np.arctan2(frame.marks.centre[0, 1], frame.marks.centre[0, 0])
    assert angle == pytest.approx(-np.sign(speed) * np.arctan(0.3), rel=0.01)
    torque = 0.3 * frame.wall_force.sum() * 0.00825
    assert frame.rig.top_drive_torque == pytest.approx(np.sign(speed) * torque, rel=0.02)
