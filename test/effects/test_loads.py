# SPDX-License-Identifier: Apache-2.0
"""Gravity, drag and bit friction against closed forms."""

import numpy as np
import pytest
from modes import free_motion
from scenes import EI, LENGTH, LINE_MASS, rod_scene

from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

AT_REST = Command(weight_on_bit=0.0, rotation=0.0)
LOSSY = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}


def settle(scene: Scene, seconds: float, command: Command = AT_REST) -> Twin:
    twin = Twin(scene)
    for _ in range(round(seconds / 0.05)):
        twin.step(command, 0.05)
    return twin


def test_gravity_hangs_from_the_hook() -> None:
    """The hook carries weight less weight on bit, from the first step on: nothing is dropped at t = 0."""
    twin = Twin(rod_scene(effects={"gravity": {"magnitude": 9.81}}, weight_on_bit=3.0))
    loads = [twin.step(Command(weight_on_bit=3.0, rotation=0.0), 1e-3).rig.hookload for _ in range(50)]
    assert loads == pytest.approx([LINE_MASS * LENGTH * 9.81 - 3.0] * 50, rel=1e-3)


def test_gravity_points_to_the_low_side() -> None:
    """In a hole tilted by 90 deg the free rod sags towards +x by w L^4 / (8 EI), small-slope cantilever."""
    effects = {"gravity": {"magnitude": 0.02}, "drag": {"linear": 0.3}, "internal_damping": LOSSY}
    twin = settle(rod_scene(effects=effects, bit_end="free", inclination=np.pi / 2), 30.0)
    sag = LINE_MASS * 0.02 * LENGTH**4 / (8.0 * EI)
    assert twin.unknowns[0][0, :2] == pytest.approx([sag, 0.0], rel=2e-3, abs=1e-9)


def test_linear_drag_decays_a_mode() -> None:
    """Amplitude falls as exp(-c t / (2 m)), whatever the mode."""
    drag = 0.05
    effects = {"drag": {"linear": drag}, "lateral_kick": {"velocity": 1e-3, "shape": "hump"}}
    motion = free_motion(rod_scene(effects=effects, step=1e-3), seconds=10.0, interval=0.01)
    middle = np.abs(motion[:, motion.shape[1] // 2])
    early, late = middle[:250].max(), middle[-250:].max()
    assert late / early == pytest.approx(np.exp(-drag * 7.5 / (2.0 * LINE_MASS)), rel=0.15)


def test_rotary_drag_needs_torque() -> None:
    """At steady speed the drive gives c_r Omega L."""
    effects = {"drag": {"linear": 0.0, "rotary": 1e-3}, "internal_damping": LOSSY}
    twin = settle(rod_scene(effects=effects), 3.0, Command(weight_on_bit=0.0, rotation=10.0))
    torque = twin.step(Command(weight_on_bit=0.0, rotation=10.0), 0.05).rig.top_drive_torque
    assert torque == pytest.approx(1e-3 * 10.0 * LENGTH, rel=2e-3)


def test_bit_friction_needs_torque() -> None:
    """At steady speed the drive gives mu W r to the bit, and the rock takes it."""
    effects = {"bit_friction": {"coefficient": 0.4, "radius": 0.02}, "internal_damping": LOSSY}
    command = Command(weight_on_bit=2.0, rotation=10.0)
    twin = settle(rod_scene(effects=effects, bit_end="sliding", weight_on_bit=2.0), 3.0, command)
    rig = twin.step(command, 0.05).rig
    assert rig.top_drive_torque == pytest.approx(0.4 * 2.0 * 0.02, rel=1e-3)
    assert rig.bit_torque == pytest.approx(-0.4 * 2.0 * 0.02, rel=1e-3)
