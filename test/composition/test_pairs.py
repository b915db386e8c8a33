# SPDX-License-Identifier: Apache-2.0
"""Effects compose: sets that hold every pair of effects on and on, on and off, off and off compile and run."""

import itertools

import numpy as np
import pytest
from effect_sets import APART, SWITCHES, Choice, covering, pairs_of
from rod_scenes import rod_scene

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import EFFECTS
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

FIRST = 6
"""Sets that are long; they hold most of the pairs, each of the others only a few more."""


def test_no_effect_is_forgotten():
    assert {*SWITCHES, "torsion", "fatigue"} == set(EFFECTS)  # fatigue acts on none of them: test_fatigue.py


def scene_of(on: Choice) -> Scene:
    """The paper's rod in a narrow hole with these effects."""
    effects = {key: SWITCHES[key] for key in SWITCHES if key in on and key != "stretch"}
    return rod_scene(
        effects=effects,
        bit_end="stabilised" if "bit_stabiliser" in on else "sliding",
        elements=8,
        step=5e-3,
        radius=0.04,
        weight_on_bit=15.0,
        at="top" if on & {"rock_floor", "bit_regenerative"} else "bit",
        form="spatial" if "stretch" in on else "lateral",
    )


def followed(scene: Scene) -> tuple[np.ndarray, float]:
    """All node rows and the deepest place beyond the wall [m] over a second of turning."""
    twin = Twin(scene)
    rows, deepest = [], 0.0
    for k in range(1, 101):
        frame = twin.advance(Command(weight_on_bit=15.0, rotation=min(0.3 * k, 12.0)), 0.01)
        rows.append(np.concatenate([part.ravel() for part in twin.unknowns]))
        deepest = max(deepest, frame.wall_depth)
    return np.array(rows), deepest


@pytest.mark.slow
def test_the_sets_hold_every_pair():
    sets = covering()
    held = set().union(*(pairs_of(on) for on in sets))
    free = ["gravity", "stretch", "bow", "eccentricity", "internal_damping", "drag", "mud", "wall", "bit_mass"]
    for a, b in itertools.combinations(free, 2):
        assert {(a, x, b, y) for x in (True, False) for y in (True, False)} <= held
    assert all(scene_of(on).effect_names for on in sets if on)
    assert len(sets) <= 20
    first, every = (set().union(*map(pairs_of, part)) for part in (sets[:FIRST], sets))
    assert len(first) > 0.85 * len(every)


@pytest.mark.parametrize("number", [
    *(pytest.param(number, marks=pytest.mark.long) for number in range(-len(APART), FIRST)),
    *(pytest.param(number, marks=pytest.mark.nightly) for number in range(FIRST, 20)),
])  # fmt: skip
def test_every_set_runs_keeps_to_the_hole_and_repeats_itself(number):
    if number >= len(covering()) - len(APART):
        pytest.skip("fewer sets are enough")
    on = covering()[number]
    rows, deepest = followed(scene_of(on))
    assert np.isfinite(rows).all()
    again, _ = followed(scene_of(on))
    np.testing.assert_array_equal(rows, again)
    if "wall" in on:
        assert deepest < 1e-3
