# SPDX-License-Identifier: Apache-2.0
"""Regenerative cutting: memory of the rock, lifting off, standing, turning back, checkpoints, and statics."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

from drill_twin.dynamics.torque_drag.analysis import steady
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.bit_regenerative import CELLS, NEWEST
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.contact.regenerative import AXIAL, BLADES, DEPTH, drilling, scene
from drill_twin_evidence.verify.scenes import drilled

SPEED, STEP = 20.0, 1e-3


def test_a_bit_that_is_lifted_meets_the_surface_it_left():
    """Off the rock no weight and no torque; on it again it drills on from the same depth."""
    twin, command = drilling(0.0, SPEED, STEP, 0.0)
    for _ in range(5):
        twin.advance(command, 0.1)
    depth = drilled(twin)
    lift = Command(-command.weight_on_bit, SPEED)
    twin.advance(lift, 0.1)
    up = [twin.advance(lift, 0.1).rig for _ in range(5)]
    assert all(rig.bit_force == 0.0 and rig.bit_torque == 0.0 for rig in up)
    assert drilled(twin) == pytest.approx(depth, abs=0.5 * DEPTH)
    down = [twin.advance(command, 0.1).rig for _ in range(40)]
    assert max(rig.bit_force for rig in down) > 0.0
    assert drilled(twin) > depth
    surface = twin.dynamics.parameters.bit_regenerative.surface
    assert np.ptp(surface) < 10.0 * DEPTH


def test_a_standing_bit_is_carried_by_the_rock_and_writes_nothing():
    twin, command = drilling(8e3, SPEED, STEP, 0.0)
    stop = Command(command.weight_on_bit, 0.0)
    twin.dynamics.begin(twin.unknowns[0].copy(), np.zeros_like(twin.unknowns[1]), stop)
    frames = [twin.advance(stop, 0.1) for _ in range(30)]
    assert frames[-1].rig.bit_force == pytest.approx(command.weight_on_bit, rel=0.05)
    assert drilled(twin) < DEPTH / BLADES
    assert sum(frame.stats.cut_steps for frame in frames) == 0


def test_turning_back_does_not_cut():
    """The surface stays; forwards again, the bit drills once it has come back to where it had been."""
    twin, command = drilling(0.0, SPEED, STEP, 0.0)
    twin.advance(command, 0.5)
    memory = twin.dynamics.parameters.bit_regenerative.memory
    back = Command(command.weight_on_bit, -SPEED)
    twin.advance(back, 2.0)
    twin.advance(back, 0.5)
    newest, depth = memory[NEWEST], drilled(twin)
    for _ in range(5):
        rig = twin.advance(back, 0.1).rig
    assert rig.bit_speed < 0.0
    assert rig.bit_torque > 0.0
    assert (memory[NEWEST], drilled(twin)) == (newest, depth)


def test_the_rock_is_part_of_a_checkpoint(tmp_path):
    twin, command = drilling(8e3, 6.0, STEP, 0.01)
    for _ in range(40):
        twin.advance(command, 0.05)
    Checkpoint.of(twin, command).save(tmp_path / "run.npz")
    again = Checkpoint.load(tmp_path / "run.npz").twin()
    for one in (twin, again):
        one.advance(command, 0.5)
    assert np.array_equal(twin.unknowns[0], again.unknowns[0])
    assert twin.dynamics.parameters.bit_regenerative.surface.size == CELLS + 2


@pytest.mark.parametrize("step", [1e-3, 0.01])
def test_a_step_may_turn_the_bit_by_more_than_a_blade(step):
    """At 10 ms the bit turns by 0.2 a step, and 100 blades are 0.063 apart."""
    own = scene(0.0, SPEED, step).model_dump(exclude_none=True)
    own["effects"]["bit_regenerative"]["blades"] = 100
    twin = Twin(Scene.model_validate(own))
    u, v = (rows.copy() for rows in twin.unknowns)
    v[:, 6], v[:, 2] = SPEED, -SPEED * DEPTH / math.tau
    command = Command(AXIAL * DEPTH, SPEED)
    twin.dynamics.begin(u, v, command)
    twin.advance(command, 5.0)
    before = drilled(twin)
    twin.advance(command, 5.0)
    assert drilled(twin) - before == pytest.approx(5.0 * SPEED * DEPTH / math.tau, rel=0.01)


def test_statics_have_the_torque_of_the_law():
    """The rock makes place for the weight at the bit; its torque over weight is that of the law at this weight."""
    own = scene(8e3, SPEED, STEP)
    law = steady(own).effects.bit_torque_stribeck
    torque = 0.5 * 60e6 * 0.108**2 * DEPTH + 0.5 * 0.6 * 0.108 * 8e3
    assert law.radius * own.rig.weight_on_bit.value == pytest.approx(torque, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"blades": 0}, "expected a whole number from 1 to 100, found 0"),
        ({"blades": 2.5}, "expected a whole number from 1 to 100, found 2.5"),
        ({"specific_energy": 0.0}, "above 0 Pa"),
        ({"radius": "30 kg"}, "length"),
        ({"wear": 0.01, "contact_strength": 0.0}, "expected `contact_strength` with it, found none"),
    ],
)
def test_numbers_out_of_range_are_refused(change, said):
    own = scene(0.0, SPEED, STEP).model_dump(exclude_none=True)
    own["effects"]["bit_regenerative"] |= change
    with pytest.raises(ValidationError, match=said):
        Scene.model_validate(own)


def test_a_weight_at_the_bit_is_refused():
    own = scene(0.0, SPEED, STEP).model_dump(exclude_none=True)
    own["rig"]["weight_on_bit"]["at"] = "bit"
    with pytest.raises(ValidationError, match=r"expected `rig.weight_on_bit.at: top` or `block`, found bit"):
        Scene.model_validate(own)
