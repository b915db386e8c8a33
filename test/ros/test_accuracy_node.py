# SPDX-License-Identifier: Apache-2.0
"""The simulator takes an accuracy in place of elements and step, and says what to expect."""

import yaml

from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.topics import TWIN_SCENE
from drill_twin.scene import load_scene
from drill_twin.studies.accuracy import resolve

CHANGES = {"duration": "2 s", "rig.weight_on_bit.value": "1 N"}


def test_the_simulator_chooses_what_was_asked_for(bench, compiled):
    compiled("pa6_bench")
    numerics = resolve(load_scene("pa6_bench", overrides={**CHANGES, "accuracy": "2 %"})).scene.numerics
    scenes = bench.collect(TWIN_SCENE, latched=True)
    overrides = "; ".join(f"{key}={value}" for key, value in CHANGES.items())
    options = {"pace": "fast", "wait_for_command": False, "duration": 2.0}
    node = bench.start("simulator", accuracy="2 %", overrides=overrides, **options)
    assert node.wait() == 0
    bench.drain()
    run = yaml.safe_load(read_string(scenes[-1]))["run"]
    assert (run["elements"], run["step_s"]) == (numerics.elements, numerics.step)
    assert run["elements"] != 16  # as auto has it
    assert f"accuracy 2 %: {numerics.elements} elements" in node.text
