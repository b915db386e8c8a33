# SPDX-License-Identifier: Apache-2.0
"""Functions of effects where nothing has a direction: on the axis, at rest, without load, without curvature, as finite.

Each function is called as Python, so a division by zero is an error here, and no kernel is compiled.
"""

from collections.abc import Iterator
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from effect_sets import SWITCHES
from hole_scenes import bend, with_parts
from rod_scenes import FATIGUE

from drill_twin.core.compile.jit import as_python
from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.kernel_arguments import make_drive
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.physics.effects import EFFECTS, Effect, effect_module, parameters_of
from drill_twin.physics.effects.config import HOOKS
from drill_twin.physics.model.section import RESULTANTS
from drill_twin.physics.model.strain import Point, strain_at
from drill_twin.scene import Scene

PLACE, CLEARANCE, STEP = 17, 0.0118, 2e-3
FRICTION: list[dict[str, Any]] = [
    {"coefficient": 0.2, "decay": 0.8}, {"coefficient": 0.0}, {"coefficient": 0.2, "sign": "arctan"},
    {"coefficient": 0.3, "sliding": 0.1, "decay": 2.0}, {"coefficient": 0.3, "sliding": 0.3, "decay": 0.0},
    {"coefficient": 0.3, "sliding": 0.1, "decay": 2.0, "sign": "arctan"},
    {"coefficient": 0.3, "decay": 2.0, "exponent": 1.0}, {"coefficient": 0.3, "decay": 0.0, "exponent": 3.0},
    {"coefficient": 0.3, "decay": 2.0, "exponent": 2.5, "sign": "arctan"},
    {"coefficient": 0.3, "sliding": 0.1, "static_speed": 0.1, "dynamic_speed": 1.0},
]  # fmt: skip
"""A block of each variant, and limits of them."""
STRIBECK = SWITCHES["bit_torque_stribeck"]
BLOCKS: list[tuple[str, dict[str, Any]]] = [
    *SWITCHES.items(), ("torsion", {}), ("fatigue", FATIGUE), *(("wall_friction", block) for block in FRICTION),
    ("wall", {"linear_stiffness": 1e5}), ("wall", {"stiffness": 1e7, "restitution": 1.0}),
    ("bit_torque_stribeck", {**STRIBECK, "exponent": 1.2}), ("bit_torque_stribeck", {**STRIBECK, "decay": 0.0}),
    ("bit_torque_stribeck", {**STRIBECK, "exponent": 1.2, "decay": 0.0}),
    ("bit_regenerative", {**SWITCHES["bit_regenerative"], "regeneration": False}),
    ("bit_cutting", {**SWITCHES["bit_cutting"], "rock_stiffness": 1e6}),
    ("bit_cutting", {**SWITCHES["bit_cutting"], "dispersion": 0.3, "rubbing": 0.0, "digging": 0.0}),
    ("bit_cutting", {**SWITCHES["bit_cutting"], "dispersion": 0.3, "threshold": 0.0, "advance": 0.0}),
    ("bit_stabiliser", {"gauge": 0.04, "stiffness": 1e5, "damping": 10.0, "friction": 0.3}),
    ("bit_stabiliser", {"gauge": 0.042, "stiffness": 1e5, "friction": 0.3}),
    ("bit_side_force", {"moment": 2.0, "turns": "with_bit", "ramp": 0.0}),
    ("top_shake", {"amplitude": 1e-3, "frequency": 0.0, "bandwidth": 0.5}),
    ("eccentricity", {"rms": 1e-4, "correlation_length": 1.0}),
    ("bow", {"amplitude": 1e-3, "shape": "random", "correlation_length": 1.0}),
]  # fmt: skip


def scene_of(hole: str) -> Scene:
    radius = CLEARANCE + 0.0165 / 2
    holes = {"straight": {"radius": radius}, "curved": bend(40.0, 20.0, 0.3, 0.8, hole=radius)}
    return with_parts(
        effects={"stretch": {}, "torsion": {}, "mud": {"density": 1000.0, "viscosity": 1e-3}},
        length=20.0, elements=20, step=STEP, hole=holes[hole],
    )  # fmt: skip


def places(model: Any) -> Iterator[Point]:
    """On the axis, a hair off it, and on the wall; at rest, in motion, and through the whole hole within the step."""
    axis = model.wellbore.axis
    centre, t = (np.zeros(3), np.array([0.0, 0.0, 1.0])) if axis is None else (axis.centre[PLACE], axis.tangent[PLACE])
    across = np.cross(t, [0.0, 1.0, 0.0]) / np.linalg.norm(np.cross(t, [0.0, 1.0, 0.0]))
    through = 2.0 * CLEARANCE / STEP * 1.2
    for off, fast, along, turn in product(
        (0.0, 1e-320, 1e-13, CLEARANCE, CLEARANCE + 1e-4), (0.0, 1e-320, -0.1, through), (0.0, 0.3), (0.0, 5.0)
    ):
        x, v = centre + off * across, fast * across + along * t
        yield Point(PLACE // 2, PLACE, 0.0, *x.tolist(), *v.tolist(), 0.0, 0.0, 0.0, *t.tolist(), 0.0, turn, 0.0,
                    1.0, 0.0, True, 0.0)  # fmt: skip


@pytest.mark.parametrize("hole", ["straight", "curved"])
@pytest.mark.parametrize(("key", "data"), BLOCKS, ids=[f"{number}-{key}" for number, (key, _) in enumerate(BLOCKS)])
def test_every_function_gives_finite_numbers(hole: str, key: str, data: dict[str, Any]) -> None:
    scene = scene_of(hole)
    model, block = discretise(scene, mesh(scene, 20)), EFFECTS[key].model_validate(data)
    module, law = effect_module(key), Effect.of(key, block)
    functions = {
        hook: as_python(getattr(module, name)) for hook in (*HOOKS, "dissipated_power") if (name := law.function(hook))
    }
    if not functions:
        return
    walled = {"wall": parameters_of("wall", EFFECTS["wall"](stiffness=1e7), model)}
    drive = make_drive(scene, 0.0)
    given = SimpleNamespace(**walled | {key: parameters_of(key, block, model)}, drive=drive)
    seen: list[Any] = []
    for here in places(model):
        load, stiff, out = np.zeros(4), np.zeros((4, 4)), np.zeros(RESULTANTS)
        if "distributed_load" in functions:
            for count in range(3):
                again = here._replace(first_iteration=count == 0, iteration=float(count))
                functions["distributed_load"](given, model.rod, again, 0.5 * STEP, load, stiff)
        if "dissipated_power" in functions:
            seen.append(functions["dissipated_power"](given, here, 0.5 * STEP))
        zero, t = (0.0, 0.0, 0.0), (here.tx, here.ty, here.tz)
        strain = as_python(strain_at)(here.element, PLACE, t, zero, zero, zero, 0.0, 1.0, 0.0, 0.0, here.spin_rate, 0.0)
        if "section_stress" in functions:
            functions["section_stress"](given, model.rod, strain, 0.5 * STEP, out)
        seen += [load, stiff, out]
    if "axial_damping" in functions:
        seen.append(functions["axial_damping"](given, 0, 0.0, 0.0))
    for weight, speed, slide in product((0.0, -5.0, 1e-320, 100.0), (0.0, 1e-320, -3.0, 3.0), (0.0, 1e-320, 0.1)):
        drive.bit.now[0] = weight
        u, v, ends, trial = np.zeros((21, 7)), np.zeros((21, 7)), np.zeros((2, 7, 8)), np.zeros((21, 7))
        u[:, 2], u[:, 5], v[0, 6], v[0, 0] = model.rod.arc, 1.0, speed, slide
        drive.bit.start[:], drive.bit.rate[:] = u[0], v[0]
        for _ in range(3):
            if "end_load" in functions:
                functions["end_load"](given, model.rod, np.zeros(3), 0.0, 0.5 * STEP, u, v, v, ends)
        if "prescribed_motion" in functions:
            functions["prescribed_motion"](given, model.rod, 0.0, trial)
        if "after_step" in functions:
            functions["after_step"](given, model.rod, np.zeros(3), STEP, STEP, u, v)
        seen += [ends, trial, u, v, drive.bit.impulse.copy()]
    seen += [given.fatigue.seen] if key == "fatigue" else []
    assert all(np.isfinite(values).all() for values in seen)


@pytest.mark.parametrize("data", FRICTION, ids=str)
def test_friction_above_a_joint_without_load_and_slip(data: dict[str, Any]) -> None:
    """No load across the hole, no speed: the wall carries nothing and no slope is without a bound."""
    scene = scene_of("curved")
    model, block = discretise(scene, mesh(scene, 20)), EFFECTS["wall_friction"].model_validate(data)
    blocks = {"wall": EFFECTS["wall"](stiffness=1e7), "wall_friction": block}
    given = SimpleNamespace(**{key: parameters_of(key, other, model) for key, other in blocks.items()})
    name = Effect.of("wall_friction", block).function("side_friction")
    rub = as_python(getattr(effect_module("wall_friction"), name))
    for here, across, along in product(places(model), (0.0, 1e-320, 10.0), (0.0, 1e-320, 0.2)):
        assert np.isfinite(rub(given, here, along, across)).all()
