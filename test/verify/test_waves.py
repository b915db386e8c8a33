# SPDX-License-Identifier: Apache-2.0
"""Axial and torsional waves: arrival after L / c, doubling at a free end, sign change at a held one."""

import numpy as np
import pytest
from scenes import DENSITY, DIAMETER, GJ, LENGTH, POISSON, YOUNG, rod_scene

from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

INTERVAL = 2e-5


def arrival(signal: np.ndarray, plateau: float) -> float:
    """When a front of this height passed [s]: where the signal's integral, extended backwards, meets zero.

    A mesh smears a front over a few elements; its integral is not fooled by that.
    """
    time = INTERVAL * np.arange(1, signal.size + 1)
    behind = slice(300, 480)
    return float(np.mean((time - np.cumsum(signal) * INTERVAL / plateau)[behind]))


def test_axial_wave() -> None:
    """One newton at the bit reaches the top after L sqrt(rho / E) = 3.458 ms and doubles at the clamp."""
    twin = Twin(rod_scene(effects={}, elements=100, step=INTERVAL))
    load = Command(weight_on_bit=1.0, rotation=0.0)
    push = -np.array([twin.step(load, INTERVAL).rig.hookload for _ in range(900)])
    assert arrival(push, 2.0) == pytest.approx(LENGTH * np.sqrt(DENSITY / YOUNG), rel=5e-3)
    assert push[300:480].mean() == pytest.approx(2.0, rel=2e-3)


def test_torsional_wave() -> None:
    """One radian per second at the top reaches the bit after L sqrt(rho / G) = 5.774 ms and doubles at the free end."""
    twin = Twin(rod_scene(effects={}, elements=100, step=INTERVAL))
    turn = Command(weight_on_bit=0.0, rotation=1.0)
    frames = [twin.step(turn, INTERVAL) for _ in range(900)]
    speed = np.array([frame.rig.bit_speed for frame in frames])
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    assert arrival(speed, 2.0) == pytest.approx(LENGTH * np.sqrt(DENSITY / shear), rel=5e-3)
    assert speed[400:560].mean() == pytest.approx(2.0, rel=2e-3)
    # until the echo returns the drive turns a semi-infinite string: torque J sqrt(G rho) per rad/s
    polar = np.pi / 32 * DIAMETER**4
    torque = np.array([frame.rig.top_drive_torque for frame in frames])
    assert torque[100:500].mean() == pytest.approx(polar * np.sqrt(shear * DENSITY), rel=5e-3)
    assert pytest.approx(shear * polar) == GJ
