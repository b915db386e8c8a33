# SPDX-License-Identifier: Apache-2.0
"""Stick-slip: the two-mass model of Navarro-Lopez, and when a smooth law of the bit makes steady turning unstable."""

import numpy as np
import pytest
from end_scenes import steel, two_mass

from drill_twin.core.compile.jit import as_python
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import bit_torque_tanh
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

INTERVAL = 0.02


def turned(weight: float, *, start: float = 0.0, seconds: float = 120.0) -> np.ndarray:
    """Speed of bit and top [rad/s] every 20 ms of a run that begins with everything turning at `start`."""
    twin = Twin(two_mass(weight))
    twin.unknowns[1][:, 6] = start
    command = Command(weight, 100.0)
    rows = (twin.advance(command, INTERVAL).rig for _ in range(round(seconds / INTERVAL)))
    return np.array([(rig.bit_speed, rig.top_drive_speed) for rig in rows])


def test_the_stuck_bit_stands_still():
    """Held at a share x of R W mu_s it creeps at x / sqrt(1 - x^2) of 1e-4 rad/s, and the rock holds the drive."""
    twin = Twin(two_mass(58.5e3))
    for _ in range(300):
        rig = twin.advance(Command(58.5e3, 100.0), 0.2).rig
    angle = rig.bit_angle
    rig = twin.advance(Command(58.5e3, 100.0), 10.0).rig
    share = 6000.0 / (0.155575 * 58.5e3 * 0.8)
    assert rig.bit_angle - angle == pytest.approx(10.0 * 1e-4 * share / np.sqrt(1.0 - share**2), rel=0.02)
    assert rig.bit_torque == pytest.approx(-6000.0, rel=1e-3)


def smooth(weight: float) -> Scene:
    """A heavy bit under the smooth law, on rock that carries a weight set at the top [N]."""
    effects = {
        "bit_torque_tanh": {}, "bit_mass": {"inertia": 400.0, "damping": 30.0},
        "rock_floor": {"stiffness": 1e8, "damping": 1e5},
    }  # fmt: skip
    return steel(effects, at="top", weight_on_bit=weight)


@pytest.mark.long
def test_rock_that_is_not_drilled():
    """It carries what is set at the top at a depth W / K, gives the bit its torque, and lets it go when pulled."""
    law = bit_torque_tanh.Parameters(**dict(bit_torque_tanh.BitTorqueTanh()))
    twin = Twin(smooth(2e4))
    began = twin.unknowns[0][0, 2]
    for _ in range(60):
        rig = twin.advance(Command(5e4, 10.0), 0.1).rig
    assert rig.bit_force == pytest.approx(5e4, rel=1e-4)
    assert began - twin.unknowns[0][0, 2] == pytest.approx(3e4 / 1e8, rel=1e-3)
    assert rig.bit_torque == pytest.approx(-as_python(bit_torque_tanh.torque)(law, 5e4, 10.0)[0], rel=1e-3)
    twin.advance(Command(-1e3, 10.0), 0.1)
    rig = twin.advance(Command(-1e3, 10.0), 0.1).rig
    assert (rig.bit_force, rig.bit_torque) == (0.0, 0.0)
    assert twin.unknowns[0][0, 2] > began
