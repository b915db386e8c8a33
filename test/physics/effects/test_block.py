# SPDX-License-Identifier: Apache-2.0
"""The travelling block: bad gains of the auto-driller, limits, checkpoints, commands, contradictions."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

import drill_twin as dt
from drill_twin.api import Simulation
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.solver.boundary import FEED
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.metadata import contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.rig_messages import CommandEncoder, read_command
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.runs.recorded_commands import recorded_commands
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Schedule
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.statics.block import rig

RATE, WEIGHT = 0.02, 20e3


def drilling(**driller) -> Scene:
    return rig({
        "weight_on_bit": {"at": "block", "shape": "ramp", "initial": 0.0, "value": WEIGHT, "duration": 1.0},
        "rotation": {"shape": "ramp", "value": 20.0, "duration": 5.0},
        "block": {"off_bottom": 0.05, "auto_driller": {"rate": RATE, **driller}},
    })  # fmt: skip


@pytest.mark.parametrize("response", [0.01, 0.1, 1e4])
def test_bad_gains_move_the_block_no_faster_than_its_rate(response):
    """Far too fast it hunts about the set-point, far too slow it has not come there: neither runs away."""
    own = drilling(response=response)
    twin, planned = Twin(own), Schedule.from_scene(own)
    memory, weights = twin.dynamics.parameters.drive.memory, []
    for frame in range(1, 121):
        weights.append(twin.advance(planned.at(0.5 * frame), 0.5).rig.bit_force)
        assert abs(memory[FEED]) <= RATE
    assert all(np.isfinite(weights))
    assert max(weights) < 3.0 * WEIGHT
    assert (np.mean(weights[60:]) > 0.5 * WEIGHT) == (response < 1.0)


def test_block_and_auto_driller_are_part_of_a_checkpoint(tmp_path):
    own = drilling()
    twin, planned = Twin(own), Schedule.from_scene(own)
    for frame in range(1, 21):
        twin.advance(planned.at(0.5 * frame), 0.5)
    Checkpoint.of(twin, planned.at(10.0)).save(tmp_path / "run.npz")
    again = Checkpoint.load(tmp_path / "run.npz").twin()
    found = [one.advance(planned.at(10.5), 0.5).rig for one in (twin, again)]
    assert found[0] == found[1]


def test_a_schedule_moves_the_block_in_single_runs_and_ensembles():
    own = rig({"weight_on_bit": {"at": "block"}, "block": {"shape": "ramp", "value": 0.2, "duration": 2.0}})
    planned = Schedule.from_scene(own)
    assert planned.at(1.0) == Command(0.0, 0.0, 0.1)
    one, other = Twin(own), Twin(own)
    rows = other.record(4, nodes=False)
    commands = np.array([planned.at(0.5 * frame).array() for frame in range(1, 5)])
    other.advance_frames(commands, 0.5, rows)
    for frame in range(1, 5):
        rigs = one.advance(planned.at(0.5 * frame), 0.5).rig
    assert np.array_equal(one.unknowns[0], other.unknowns[0])
    assert rigs.block_position == pytest.approx(0.2, rel=0.05)


@pytest.mark.parametrize(
    "block",
    [
        {"off_bottom": 0.005, "shape": "ramp", "value": -0.02, "duration": 0.5},
        {"off_bottom": 0.005, "auto_driller": {"rate": RATE}},
    ],
)
def test_a_member_of_an_ensemble_has_the_bits_of_its_single_run(block):
    """Moved by speed, and by an auto-driller; the bit comes to the rock within the run."""
    load = {"at": "block", "value": WEIGHT if "auto_driller" in block else 0.0}
    own = rig({"weight_on_bit": load, "rotation": {"value": 10.0}, "block": block})
    key, values = ("rig.rotation.value", [8.0, 12.0])
    found = dt.Ensemble(own, {key: values}).run(1.5, outputs=("channels", "extremes"), mark_rate=100, workers=2)
    assert found.failed == {}
    for number, value in enumerate(values):
        single = dt.Simulation(own, {key: value}).run(1.5).rig
        assert single.bit_force.min() == 0.0 < single.bit_force.max()
        assert np.array_equal(found["hookload"][number], single.hookload)
        assert np.array_equal(found["bit_force"][number], single.bit_force)
        assert found["bit_torque_max"][number] == single.bit_torque.max()


def test_a_bag_without_commands_tells_the_speed_of_the_block(tmp_path):
    """As measured; where a scene has no block, or an auto-driller moves it, that speed is no set-point."""
    simulation = dt.Simulation(rig({"weight_on_bit": {"at": "block"}, "block": {}}))
    simulation.advance(block=0.02, seconds=2.0)
    bag = Bag(simulation.result().to_bag(tmp_path / "bag_0"))
    rested = Bag(_without(bag, RIG_COMMAND, WOB_COMMAND, RPS_COMMAND, folder=tmp_path / "less_0"))
    for block, wanted in ((True, pytest.approx(0.02, rel=0.1)), (False, 0.0)):
        found = recorded_commands(rested, lambda _: Command(0.0, 0.0), block=block)
        assert found.source == "/rig/state, as measured"
        assert found.commands[-1].block == wanted


def _without(bag: Bag, *left_out: str, folder: Path) -> Path:
    topics = [topic for topic in bag.topics if topic not in left_out]
    with BagWriter(folder, topics=[contract_topic(topic) for topic in topics]) as writer:
        for topic, stamp, raw in bag.messages(topics):
            writer.write(topic, stamp, raw)
    return folder


def test_a_command_has_the_block_as_a_joint():
    """Every command has the joint, of a block at rest too: templates stay."""
    reader, encoder = JointStateReader(), CommandEncoder()
    for command in (Command(0.0, 2.0, -0.3), Command(5.0, 1.0)):
        state = reader.read(encoder.command(1, command))
        assert read_command(state) == command
        assert "block" in state.names


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"weight_on_bit": {"at": "top", "value": 0.0}}, "at: block` and `rig.block` together"),
        ({"weight_on_bit": {"at": "block", "value": 5.0}}, "which holds a weight, found one"),
        ({"block": {"auto_driller": {"rate": 0.0}}}, "above 0 m/s"),
        ({"block": {"auto_driller": {"rate": 0.01, "torque": 5.0}}}, "a top drive with a motor"),
        ({"block": {"value": 100.0}}, "no block moves faster"),
        ({"block": {"value": 0.1, "auto_driller": {"rate": 0.01}}}, "either a speed or `auto_driller`"),
        ({"start": "equilibrium"}, 'expected "axis" or "rotating" with a block'),
    ],
)
def test_contradictions_are_told(change, said):
    with pytest.raises(ValidationError, match=said):
        rig({"weight_on_bit": {"at": "block"}, "block": {}, **change})


def test_the_block_of_the_page_is_read_from_yaml(tmp_path):
    """Speed left out: it rests, or the auto-driller moves it."""
    page = (Path(__file__).parents[3] / "docs" / "rig.md").read_text("utf-8")
    block = page.split("```yaml\nrig:")[1].split("```")[0].replace("at: block,", "at: block, initial: ~, start: ~,")
    (tmp_path / "page.yaml").write_text(f"base: bha_stress\nrig:{block}", "utf-8")
    own = load_scene(tmp_path / "page.yaml").rig.block
    assert own is not None
    assert (own.value, own.off_bottom) == (0.0, 0.5)


def test_the_speed_of_a_block_that_is_not_there_is_refused():
    with pytest.raises(ArgumentError, match=r"expected a scene with rig\.block, found none in two_mass"):
        Simulation("two_mass").advance(block=0.1)


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ({}, "block: expected -10 to 10 m/s, found 30 m/s"),
        ({"off_bottom": 0.005, "auto_driller": {"rate": RATE}}, "found a block that an auto-driller moves"),
    ],
)
def test_a_speed_that_no_block_follows_is_refused(block, said):
    load = {"at": "block", "value": WEIGHT if block else 0.0}
    with pytest.raises(ArgumentError, match=said):
        Simulation(rig({"weight_on_bit": load, "block": block})).advance(block="30 m/s")
