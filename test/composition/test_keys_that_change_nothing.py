# SPDX-License-Identifier: Apache-2.0
"""A key of an effect's block changes something that a run is given, or is refused beside what it would not change."""

import inspect
from functools import cache
from typing import Any

import numpy as np
import pytest
from effect_sets import SWITCHES
from pydantic import ValidationError
from rod_scenes import FATIGUE, rod_scene

from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.physics.effects import EFFECTS, effect_module, parameters_of
from drill_twin.physics.effects.eccentricity import Eccentricity
from drill_twin.physics.effects.mud import lateral_force
from drill_twin.physics.effects.wall_friction import WallFriction
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

LAW = {"coefficient": 0.3, "sliding": 0.1, "decay": 2.0}
STEP = {"coefficient": 0.3, "sliding": 0.1, "static_speed": 0.1, "dynamic_speed": 1.0}
DRAG_BIT = {"radius": 8e-3, "specific_energy": 1e6, "wear": 1e-4, "contact_strength": 1e6}
STATES: dict[str, list[dict[str, Any]]] = {
    **{key: [block] for key, block in SWITCHES.items()}, "torsion": [{}],
    "fatigue": [FATIGUE, {"sections": FATIGUE["sections"]}],
    "bow": [{"amplitude": 2e-3}, {"amplitude": 2e-3, "shape": "random", "correlation_length": 1.0}],
    "eccentricity": [{"offset": 1e-4}, {"offset": 1e-4, "rms": 1e-4, "correlation_length": 1.0},
                     {"rms": 1e-4, "correlation_length": 1.0}, {"sections": [{"offset": 1e-4}]}],
    "wall": [{"stiffness": 1e7}, {"linear_stiffness": 1e5}],
    "wall_friction": [{"coefficient": 0.3}, LAW, {**LAW, "sign": "arctan"}, {**LAW, "exponent": 2.0}, STEP],
    "bit_torque_stribeck": [SWITCHES["bit_torque_stribeck"], {**SWITCHES["bit_torque_stribeck"], "exponent": 1.2}],
    "bit_cutting": [SWITCHES["bit_cutting"], {**SWITCHES["bit_cutting"], "dispersion": 0.3}],
    "bit_regenerative": [DRAG_BIT, {**DRAG_BIT, "regeneration": False}],
    "bit_side_force": [{"force": 0.1, "moment": 0.1}],
    "lateral_kick": [{"velocity": 0.2, "offset": 1e-3}],
    "top_shake": [{"amplitude": 1e-4, "frequency": 3.0}, {"amplitude": 1e-4, "frequency": 3.0, "bandwidth": 0.5}],
}  # fmt: skip
"""Blocks of each effect, one for each of its shapes, in which no size is zero."""
OTHERS: dict[str, Any] = {
    "shape": "hump", "bow.shape": "uniform", "turns": "with_bit", "inside": "air", "curve": "dnv_b1", "sign": "arctan",
    "mean_stress": "none", "correlation_length": 2.0, "bow.amplitude": 1e-3, "seed": 7, "angle": 0.3,
    "restitution": 0.7,
    "mud.frequency": 3.0, "fatigue.line": {"stress_range": 2e6, "slope": 3.0},
    "fatigue.sections": [{"name": "a", "distance_from_bit": 1.0}],
    "eccentricity.sections": [{"offset": 2e-4}], "blades": 6, "bit": "pdc", "dynamic_speed": 2.0, "static_speed": 0.05,
    "exponent": 3.0, "wall_friction.sliding": 0.2, "offset": 2e-3, "eccentricity.offset": 2e-4, "gauge": 0.08,
    "intervals": [{"top": 0.0, "bottom": 3.0, "coefficient": 0.1}], "smallest_range": 2e4, "thrust": 0.8,
    "rock_stiffness": 1e6, "dispersion": 0.2, "bandwidth": 0.7, "direction": 0.4, "ramp": 0.5,
}  # fmt: skip
"""Another value of a key, where twice the one in force is none."""
BACK = {"sign": "root", "mean_stress": "goodman"}
"""Value of a key where that of `OTHERS` is in force."""
TOLD = {
    ("bit_regenerative", "blades"): "without regeneration their number changes nothing",
    ("rock_floor", "lobes"): "without a `lobe_height` their number changes nothing",
    ("bit_torque_stribeck", "bit"): "`sticking` and `decay`, unless they are given",
}
"""Keys that change nothing beside another one, and what their description says of it."""


def scene_of(mud: dict[str, Any]) -> Scene:
    return rod_scene(effects={"stretch": {}, "torsion": {}, "mud": mud})


@cache
def model() -> DiscreteModel:
    scene = scene_of({"density": 1000.0, "viscosity": 1e-3})
    return discretise(scene, mesh(scene, 24))


def given(key: str, data: dict[str, Any]) -> bytes:
    """Everything that a run takes from a block: variant, parameters, properties of the mud, state that it begins with.

    Raises:
        ValidationError: The block is refused.
    """
    block, module = EFFECTS[key].model_validate(data), effect_module(key)
    found: list[Any] = [*block.variant.encode()]
    if key == "mud":
        in_mud = discretise(scene_of(data), model().rod)
        found += [*_flat(tuple(in_mud)), *lateral_force(in_mud)]
    if hasattr(module, "Parameters"):
        found += _flat(parameters_of(key, block, model()))
    if hasattr(module, "initial_state"):
        u, v = np.zeros((25, 7)), np.zeros((25, 7))
        u[:, 2], u[:, 5] = model().rod.arc, 1.0
        module.initial_state(block, model(), u, v)
        found += [u, v]
    return b"".join(np.asarray(value, dtype=float).tobytes() for value in found)


def _flat(values: Any) -> list[Any]:
    """Numbers and arrays in tuples of tuples."""
    if isinstance(values, tuple):
        return [part for value in values for part in _flat(value)]
    return [values] if isinstance(values, (int, float, np.ndarray)) else []


def refused(key: str, data: dict[str, Any]) -> list[str]:
    """Words against a block, by itself and in a scene."""
    try:
        block = EFFECTS[key].model_validate(data)
    except ValidationError as error:
        return [str(error)]
    return [text for _, text in block.check_against(scene_of({"density": 1000.0}))]


def another(key: str, name: str, data: dict[str, Any]) -> Any:
    """A valid value of a key other than that in force."""
    field = EFFECTS[key].model_fields[name]
    now = data.get(name, field.default)
    if (wanted := OTHERS.get(f"{key}.{name}", OTHERS.get(name))) is not None:
        return wanted if wanted != now else BACK[name]
    return not now if isinstance(now, bool) else 2.0 * (now or 0.5)


CASES = [
    (key, number, name) for key, blocks in STATES.items() for number in range(len(blocks))
    for name in EFFECTS[key].model_fields
]  # fmt: skip


def test_all_effects_are_looked_at():
    assert set(STATES) == set(EFFECTS)


@pytest.mark.parametrize(("key", "number", "name"), CASES, ids=str)
def test_a_key_changes_something_or_is_refused(key, number, name):
    data = STATES[key][number]
    changed = {**data, name: another(key, name, data)}
    words = [text for text in refused(key, changed) if text not in refused(key, data)]
    assert all("expected" in text for text in words)
    if not words and given(key, data) == given(key, changed):
        lines = inspect.getsource(EFFECTS[key])
        assert TOLD[key, name] in " ".join(lines.split())


@pytest.mark.parametrize(
    ("block", "data", "said"),
    [
        (Eccentricity, {"sections": [{"offset": 1e-4}], "angle": 1.5}, "expected `angle` with `offset` only"),
        (Eccentricity, {"rms": 1e-4, "correlation_length": 1.0, "angle": 1.5}, "found it beside `rms`"),
        (Eccentricity, {"offset": 1e-4, "seed": 2}, "expected a `seed` with `rms` only, found 2"),
        (WallFriction, {"coefficient": 0.3, "sliding": 0.1}, "expected a `decay` with `sliding` or `exponent`"),
        (WallFriction, {"coefficient": 0.3, "exponent": 2.0}, "expected a `decay` with `sliding` or `exponent`"),
        (WallFriction, {**STEP, "accuracy": 1e5}, "`accuracy` beside `static_speed`"),
    ],
)  # fmt: skip
def test_what_was_ignored_is_refused_in_words(block, data, said):
    with pytest.raises(ValidationError, match=said):
        block.model_validate(data)


def test_a_size_of_zero_is_a_limit_and_no_mistake():
    """A sweep of a size that begins at zero keeps the other keys."""
    Eccentricity.model_validate({"offset": 1e-4, "rms": 0.0, "seed": 2})
    WallFriction.model_validate({"coefficient": 0.3, "sliding": 0.1, "decay": 0.0})
    for block in (Eccentricity(offset=1e-4, angle=0.2), WallFriction(coefficient=0.3, sliding=0.1, decay=1.0)):
        assert type(block).model_validate(block.model_dump(exclude_none=True)) == block
