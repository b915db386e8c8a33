# SPDX-License-Identifier: Apache-2.0
"""A run that called for an effect which its scene leaves out says so, in the bag's diagnostics and in the summary."""

import pytest
from summaries import summarise

from drill_twin.runs import Session
from drill_twin.scene import load_scene

OFF = (
    "wall",
    "wall_friction",
    "bow",
    "eccentricity",
    "bit_friction",
)  # the kernel of test/physics/effects/test_hole.py
SLIDING = dict.fromkeys((f"effects.{key}" for key in OFF), "off") | {"numerics.elements": "8"}


def notes(tmp_path, changes: dict[str, str]) -> list[str]:
    outcome = Session(load_scene("pa6_bench", overrides=changes)).run(tmp_path / "bag_0")
    return summarise(outcome.bag)["notes"]


def test_a_string_that_passes_through_the_wall_is_noted(tmp_path):
    said = notes(tmp_path, SLIDING | {"duration": "1.2 s", "wob": "1 N", "effects.lateral_kick.velocity": "0.5 m/s"})
    passed = [note for note in said if "passed through the wall" in note]
    assert len(passed) == 1
    assert "list the effect `wall`" in passed[0]
    assert " s the string" in passed[0]
    assert " m from the bit" in passed[0]


def test_a_string_that_keeps_clear_is_not(tmp_path):
    assert not any("wall" in note for note in notes(tmp_path, SLIDING | {"duration": "1.2 s", "wob": "1 N"}))


@pytest.mark.parametrize(("weight", "lifted"), [("-30 N", True), ("30 N", False)])
def test_a_bit_that_is_pulled_off_the_bottom_is_noted(tmp_path, weight, lifted):
    load = {"value": weight, "duration": "0.5 s", "at": "top"}
    changes = {"duration": "1.2 s", **{f"rig.weight_on_bit.{key}": value for key, value in load.items()}}
    said = notes(tmp_path, SLIDING | changes)
    assert any("would have lifted off" in note and "`rock_floor`" in note for note in said) == lifted
