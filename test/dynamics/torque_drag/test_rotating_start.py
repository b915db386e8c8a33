# SPDX-License-Identifier: Apache-2.0
"""Runs of wells that begin at speed and in balance (`rig.start: rotating`)."""

import numpy as np
import pytest
from variants import long_one_of

from drill_twin.core.errors import RunError
from drill_twin.dynamics.audit.energy import rows_at
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.dynamics.torque_drag.sliding_balance import SlidingBalance
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command, Schedule

JOINED = {"numerics.lateral_from": "auto"}
SOFT = {"rig.top_drive": "{model: impedance, inertia: 3000 kg m^2}"}

BLOCK = {"rig.weight_on_bit": "{at: block, value: 100 kN}", "rig.block": "{auto_driller: {rate: 0.01 m/s}}",
         "effects.rock_floor": "{stiffness: 1e8 N/m}"}  # fmt: skip


def first_seconds(changes, seconds=4.0, name="wells/s_shaped"):
    """Rig of each frame, and the twin."""
    scene = load_scene(name, overrides=changes)
    twin, schedule, period = Twin(scene), Schedule.from_scene(scene), scene.numerics.frame_period
    frames: list[RigState] = [
        twin.advance(schedule.at(k * period), period).rig for k in range(1, round(seconds / period))
    ]
    return frames, twin


@pytest.mark.parametrize(
    ("changes", "torque"),
    long_one_of(2, [
        (JOINED, 21900.0), (JOINED | SOFT, 21900.0), ({"numerics.lateral_from": "0 m"}, 21750.0),
        (JOINED | BLOCK, 21900.0), (JOINED | {"rpm": "-120"}, -21900.0), (JOINED | {"wob": "0 N"}, 20240.0),
    ], short=1),
)  # fmt: skip
def test_a_well_drills_from_the_first_frame(changes, torque):
    """Within 2 % of its later means, which runs of 60 s gave; from rest a run takes over 15 s even to load its bit."""
    frames, twin = first_seconds(changes)
    speed = twin.scene.rig.rotation.value
    assert np.allclose([frame.bit_speed for frame in frames], speed, rtol=0.03)
    assert np.allclose([frame.top_drive_torque for frame in frames], torque, rtol=0.02)
    assert np.ptp([frame.hookload for frame in frames]) < 1e-3 * frames[0].hookload
    assert np.allclose([frame.top_drive_speed for frame in frames], speed, rtol=0.01)  # a soft drive has no dip


def test_a_schedule_from_rest_begins_at_rest_on_the_low_side():
    ramp = {"rig.rotation.shape": "step", "rig.rotation.duration": "10 s"}
    scene = load_scene("wells/s_shaped", overrides=JOINED | ramp)
    twin = Twin(scene)
    u, v = twin.unknowns
    assert scene.rig.first == (scene.rig.weight_on_bit.value, 0.0)
    assert not v.any()
    assert Schedule.from_scene(scene).at(5.0).rotation == pytest.approx(0.5 * scene.rig.rotation.value)
    below = (twin.rod.arc > 40.0) & (twin.rod.arc < joint_of(scene))
    axis = Twin(scene.model_copy(update={"rig": scene.rig.model_copy(update={"start": "axis"})})).unknowns[0]
    assert np.linalg.norm(u - axis, axis=1)[below].min() > 0.03


def test_a_record_begins_at_rest(tmp_path):
    """A scene of a well plays the record of a stranger without another word on its start."""
    (tmp_path / "rig.csv").write_text("time [s],wob [kN],rpm [rpm]\n0,90,118\n60,90,118\n")
    table = {"rig.table.file": str(tmp_path / "rig.csv"), "rig.weight_on_bit": "{shape: table}",
             "rig.rotation": "{shape: table}"}  # fmt: skip
    twin = Twin(load_scene("wells/s_shaped", overrides=JOINED | table))
    assert twin.scene.rig.first == (0.0, 0.0)
    assert not twin.unknowns[1].any()


def test_pipe_without_a_balance_turns_on_the_axis(monkeypatch):
    """A run must not fail for what the search cannot find."""

    def none(*_):
        raise RunError

    monkeypatch.setattr(SlidingBalance, "solve", none)
    frames, _ = first_seconds(JOINED | {"rpm": "121"}, 0.2)
    assert np.allclose([frame.top_drive_torque for frame in frames], 20450.0, rtol=0.02)


def test_a_second_twin_of_a_scene_starts_from_the_same_state_without_a_search(monkeypatch):
    scene = load_scene("wells/s_shaped", overrides=JOINED)
    twin = Twin(scene)
    begun = twin.unknowns[0].copy()
    twin.advance(Command(*scene.rig.first), 0.02)
    monkeypatch.setattr(SlidingBalance, "__init__", None)
    assert np.array_equal(Twin(scene).unknowns[0], begun)


def test_a_string_on_another_mesh_begins_in_its_own_balance(monkeypatch):
    """The balance is of the mesh that the dynamics has, and is found once for each."""
    scene = load_scene("wells/s_shaped", overrides=JOINED)
    usual = Dynamics(scene)
    rods = [mesh(scene, usual.rod.length.size + 40) for _ in range(2)]
    own = Dynamics(scene, rods[0])
    assert own.unknowns[0].shape == (rods[0].arc.size, 7)
    below = usual.rod.arc < joint_of(scene)
    apart = rows_at(rods[0], own.unknowns[0], usual.rod.arc)[below] - usual.unknowns[0][below]
    assert np.abs(apart[:, :3]).max() < 0.02
    assert rods[0] is not rods[1]
    monkeypatch.setattr(SlidingBalance, "__init__", None)
    assert np.array_equal(Dynamics(scene, rods[1]).unknowns[0], own.unknowns[0])
