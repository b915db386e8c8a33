# SPDX-License-Identifier: Apache-2.0
"""A force that is not a number, in a real simulator: the guard's action is reported, and the node ends in order."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from rod_scenes import rod_scene
from std_msgs.msg import Float64
from summaries import summarise

from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointStateReader, read_pose_array
from drill_twin.io.messages.diagnostics import Level, decode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, RIG_STATE, STRING_POSES, WOB_COMMAND

POISON = Path(__file__).parents[1] / "faults" / "poison.py"


def start_poisoned(bench, dose, **parameters):
    scene = bench.folder / "scene.yaml"
    effects = {"drag": {"linear": 0.01}, "lateral_kick": {"velocity": 0.1, "shape": "hump"}}
    scene.write_text(rod_scene(effects=effects, elements=8, step=5e-3, form="lateral").to_yaml(), encoding="utf-8")
    given = {"scene": str(scene), **parameters}
    words = [f"{name}:={str(value).lower() if isinstance(value, bool) else value}" for name, value in given.items()]
    ros = [part for word in words for part in ("-p", word)]
    process = bench.command(
        "simulator", [sys.executable, str(POISON), *map(str, dose), "simulator", "--ros-args", *ros]
    )
    bench.until_ready("simulator", "recorder")  # time stands still until the first command: no reader misses a frame
    bench.publisher(WOB_COMMAND).publish(Float64(data=0.0))
    return process


@pytest.mark.fault("an effect that gives NaN", "nothing of it is published; the last good state is kept, exit code 1")
def test_a_poisoned_simulator_stops_with_its_state_kept_and_a_readable_bag(bench):
    states, poses = bench.collect(RIG_STATE), bench.collect(STRING_POSES)
    recorder = bench.start("recorder", bag=str(bench.folder / "bag_0"))
    bench.until_ready("recorder")
    simulator = start_poisoned(bench, (2.0, math.inf, 0.0, math.nan), checkpoint=bench.folder / "run.npz")
    assert simulator.wait() == 1, simulator.text
    assert "Traceback" not in simulator.text
    assert "past t = 2 s" in simulator.text
    assert "poison gives no number" in simulator.text
    bench.drain()
    assert recorder.end() == 0, recorder.text
    assert any(status.level == Level.ERROR and "past t = 2 s" in status.text for status in bench.history)
    (folder,) = bench.folder.glob("simulator_stop_*")
    assert Checkpoint.load(folder / "checkpoint.npz").time == pytest.approx(2.0)
    with np.load(folder / "last_second.npz") as kept:
        assert kept["time"].shape == (100,)
        assert np.isfinite(kept["u"]).all()
    assert len(states) == 200
    for raw in states:
        state = JointStateReader().read(bytes(raw))
        assert np.isfinite([state.position, state.velocity, state.effort]).all()
    assert all(np.isfinite(read_pose_array(bytes(raw)).position).all() for raw in poses)
    bag = Bag(bench.folder / "bag_0")
    assert not bag.truncated
    assert bag.topics[RIG_STATE].count == 200
    assert "past t = 2 s" in summarise(bag)["guard"]["stopped"]


@pytest.mark.long
@pytest.mark.fault("a law that fails in too large a step", "the frame is done again in smaller steps; the run goes on")
def test_a_simulator_whose_step_was_too_large_goes_on(bench):
    recorder = bench.start("recorder", bag=str(bench.folder / "bag_0"))
    bench.until_ready("recorder")
    simulator = start_poisoned(bench, (1.0, 1.1, 1e-3, 1e8), duration=4.0)
    assert simulator.wait() == 0, simulator.text
    bench.drain()
    assert recorder.end() == 0, recorder.text
    told = [status.values["guard"] for status in bench.history if "guard" in status.values]
    assert len(told) == 1
    assert "taken back and done again with a step of 0.000625 s" in told[0]
    messages = Bag(bench.folder / "bag_0").messages((DIAGNOSTICS,))
    recorded = [s for *_, raw in messages for s in decode_diagnostics(raw)[1] if s.name == "simulator"]
    assert recorded[-1].values["guard_interventions"] == "1"
    assert summarise(bench.folder / "bag_0")["guard"]["interventions"] == 1
