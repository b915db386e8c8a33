# SPDX-License-Identifier: Apache-2.0
"""What physics keeps, the twin keeps."""

import numpy as np
import pytest
from scenes import BARE, LINE_MASS, ROLLING, rod_scene

from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.solve.energy import angular_momentum, energy, gauss_positions
from drill_twin.twin import Twin

AT_REST = Command(weight_on_bit=0.0, rotation=0.0)


def test_energy_of_an_undamped_swing() -> None:
    """Thirty seconds of swinging without damping: the energy drifts by less than 1e-4 of what was put in."""
    effects = {"gravity": {}, "lateral_kick": {"velocity": 0.5}}
    twin = Twin(rod_scene(effects=effects, bit_end="free", step=2e-3))

    def total() -> float:
        u, v = twin.unknowns
        height = gauss_positions(twin.rod, u)[:, 2].reshape(-1, 2)
        weight = 0.5 * twin.rod.length[:, None] * LINE_MASS * 9.81
        return energy(twin.rod, u, v).total + float(np.sum(weight * height))

    start, put_in = total(), energy(twin.rod, *twin.unknowns).kinetic
    worst = 0.0
    for _ in range(600):
        twin.step(AT_REST, 0.05)
        worst = max(worst, abs(total() - start) / put_in)
    assert np.abs(twin.unknowns[0][0, 0]) > 1e-3, "the rod must be swinging"
    assert worst < 1e-4


def test_angular_momentum_of_a_free_end() -> None:
    """A conical swing about the hole's axis keeps its angular momentum but for the clamp's torque, which has no moment
    about the axis as long as nothing is twisted."""
    twin = Twin(rod_scene(effects={}, bit_end="free", step=1e-3))
    u, v = twin.unknowns
    arc = twin.rod.arc
    shape = (1.0 - arc / arc[-1]) ** 2
    slope = -2.0 * (1.0 - arc / arc[-1]) / arc[-1]
    u[:, 0], u[:, 3] = 0.05 * shape, 0.05 * slope
    v[:, 1], v[:, 4] = 0.03 * shape, 0.03 * slope
    before = angular_momentum(twin.rod, u, v)
    impulse = 0.0
    for _ in range(500):
        impulse += twin.step(AT_REST, 1e-3).rig.top_drive_torque * 1e-3
    assert angular_momentum(twin.rod, *twin.unknowns) - before == pytest.approx(impulse, abs=1e-6 * before)


def turned(scene: Scene, angle: float, mirror: bool = False) -> np.ndarray:
    """Centre line after a second of a kicked, loaded, turning rod, started at an angle about the hole's axis."""
    twin = Twin(scene)
    u, v = twin.unknowns
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    if mirror:
        turn = turn @ np.diag([1.0, -1.0])
    for rows in (u, v):
        rows[:, 0:2] = rows[:, 0:2] @ turn.T
        rows[:, 3:5] = rows[:, 3:5] @ turn.T
    u[:, 6] += angle
    sense = -1.0 if mirror else 1.0
    for k in range(100):
        frame = twin.step(Command(weight_on_bit=0.4 * (k + 1), rotation=sense * 0.12 * (k + 1)), 0.01)
    return frame.positions[:, :2] @ turn


@pytest.fixture
def lively() -> Scene:
    """A scene that whirls into the wall within a second."""
    return rod_scene(effects=ROLLING, radius=0.04, step=2e-3)


@pytest.mark.parametrize("angle", [0.7, 2.5, -1.2])
def test_no_direction_across_the_hole_is_special(lively: Scene, angle: float) -> None:
    """Turning the start about the hole's axis turns the whole motion."""
    assert turned(lively, angle) == pytest.approx(turned(lively, 0.0), abs=1e-7)


def test_mirror_image(lively: Scene) -> None:
    """A mirrored start turned the other way gives the mirrored motion."""
    assert turned(lively, 0.0, mirror=True) == pytest.approx(turned(lively, 0.0), abs=1e-7)


def test_same_scene_same_bits(lively: Scene) -> None:
    """Two runs of one scene agree to the last bit."""
    assert np.array_equal(turned(lively, 0.3), turned(lively, 0.3))
    assert lively.effects.names[:2] == list(BARE)
