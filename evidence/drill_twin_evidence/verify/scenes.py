# SPDX-License-Identifier: Apache-2.0
"""Scenes of the cases, and of tests: the paper's rod with only the effects of the reference. Plain numbers are SI."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import Any

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model.bit import DRILLED
from drill_twin.scene import Scene

LENGTH, DIAMETER = 5.0, 0.0165
YOUNG, POISSON, DENSITY = 2.3e9, 0.394, 1100.0
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
AREA = pi / 4 * DIAMETER**2
EI = YOUNG * pi / 64 * DIAMETER**4
EA = YOUNG * AREA
GJ = SHEAR * pi / 32 * DIAMETER**4
LINE_MASS = DENSITY * AREA
FIRST = 4.730040745**2 / LENGTH**2 * sqrt(EI / LINE_MASS)
"""First natural frequency between clamps [rad/s] (Blevins 1979, table 8-1)."""

BARE: dict[str, Any] = {"stretch": {}, "torsion": {}}
KICK: dict[str, Any] = {"lateral_kick": {"velocity": 1e-6, "shape": "hump"}}
"""Initial velocity small enough for linear motion, zero at both ends."""
WAVE: dict[str, Any] = {"lateral_kick": {"velocity": 1e-6, "shape": "half_wave"}}
"""Initial velocity for ends that are free to rotate."""
QUIET: dict[str, dict[str, Any]] = {
    "gravity": {"magnitude": 0.0},
    "bow": {"amplitude": 0.0},
    "eccentricity": {"offset": 0.0},
    "internal_damping": {"bending_time": 0.0},
    "drag": {"linear": 0.0},
    "mud": {"density": 1e-9, "viscosity": 1e-12},
    "quadratic_drag": {"coefficient": 0.0},
    "added_mass": {"coefficient": 0.0},
    "rotation_drag": {},
    "lateral_kick": {"velocity": 0.0, "shape": "hump"},
    "random_force": {"rms": 0.0, "correlation_time": 1.0, "correlation_length": 1.0},
    "top_shake": {"amplitude": 0.0, "frequency": 0.0},
}
"""One set of effects for many cases, so that one kernel serves all of them; the parameters make each effect zero."""
WALLED: dict[str, dict[str, Any]] = {
    **{key: QUIET[key] for key in ("gravity", "bow", "eccentricity", "internal_damping", "drag")},
    "wall": {"stiffness": 1e7},
    "wall_friction": {"coefficient": 0.0},
}
"""Set of effects with a wall: those of the scene pa6_bench."""
ROLLING: dict[str, Any] = {
    "bow": {"amplitude": 2e-3},
    "drag": {"linear": 0.02},
    "internal_damping": {"bending_time": 2e-3, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "wall": {"stiffness": 1e7},
    "wall_friction": {"coefficient": 0.5},
    "lateral_kick": {"velocity": 0.05, "shape": "hump"},
}
"""Effects under which the rod whirls into the wall of a 40 mm hole under a few newtons, and rolls there."""


def rod_scene(
    *,
    effects: dict[str, Any],
    bit_end: str = "guided",
    length: float = LENGTH,
    sections: Sequence[dict[str, float]] = ({},),
    elements: int = 24,
    step: float | str = "auto",
    radius: float = 5.0,
    inclination: float = 0.0,
    hole: dict[str, Any] | None = None,
    weight_on_bit: float = 0.0,
    at: str = "bit",
    marks: Sequence[float] = (2.5,),
    frame_rate: float = 100.0,
    form: str = "spatial",
    tolerance: float = 1e-5,
) -> Scene:
    """The PA6 rod with the given effects; `weight_on_bit` acts from the first instant.

    Args:
        effects: Fields of each effect by its key.
        bit_end: Boundary condition at the bit.
        length: Of a section [m].
        sections: Changes to the rod that make each section, from the bit up.
        elements: Of the whole string.
        step: Time step [s].
        radius: Of the hole [m].
        inclination: Of the hole [rad].
        hole: The whole block, in place of `radius` and `inclination`.
        weight_on_bit: Load [N].
        at: Place where the load is applied and measured.
        marks: Distances from the bit of marks on the centre line [m].
        frame_rate: Published frames [Hz]; at least one step each.
        form: "spatial", or "lateral": without stretch and torsion.
        tolerance: Tolerance of Newton's method; invariants of the scheme hold to this tolerance.
    """
    rod = {
        "name": "rod", "length": length, "outer_diameter": DIAMETER, "inner_diameter": 0.0,
        "youngs_modulus": YOUNG, "poisson_ratio": POISSON, "density": DENSITY,
    }  # fmt: skip
    return Scene.model_validate({
        "name": "check",
        "string": {
            "sections": [rod | section for section in sections],
            "marks": [
                {"name": f"mark_{i + 1}", "distance_from_bit": place, "on": "centre"} for i, place in enumerate(marks)
            ],
            "bit_end": bit_end,
        },
        "hole": hole or {"radius": radius, "inclination": inclination},
        "rig": {
            "weight_on_bit": {
                "shape": "step", "initial": weight_on_bit, "value": weight_on_bit, "duration": 1.0, "at": at,
            },
            "rotation": {"shape": "constant", "value": 0.0},
            "duration": 10.0,
        },
        "effects": (BARE if form == "spatial" else {}) | effects,
        "numerics": {"elements": elements, "step": step, "frame_rate": frame_rate, "tolerance": tolerance},
    })  # fmt: skip


def quiet_scene(effects: dict[str, Any], *, of: dict[str, dict[str, Any]] = QUIET, **scene: Any) -> Scene:
    """The rod with the effects given; the other effects of the set `of` are listed too, at zero.

    Args:
        effects: Fields of effects, by key.
        of: Set of effects.
        scene: Arguments of `rod_scene`.
    """
    more = {key: block for key, block in effects.items() if key not in of}
    listed = {key: block | effects.get(key, {}) for key, block in of.items()} | more
    if effects.get("eccentricity", {}).keys() & {"sections", "rms"}:  # in place of one offset
        listed["eccentricity"] = effects["eccentricity"]
    return rod_scene(effects=listed, **scene)


def steel(effects: dict[str, Any], *, at: str = "bit", weight_on_bit: float = 0.0, step: float = 1e-3) -> Scene:
    """A short stiff steel pipe above a drill bit, turned at a constant rate."""
    return Scene.model_validate({
        "name": "steel",
        "string": {
            "sections": [{
                "length": 10.0, "outer_diameter": 0.2, "inner_diameter": 0.1,
                "youngs_modulus": 210e9, "poisson_ratio": 0.3, "density": 7850.0,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.2},
        "rig": {
            "weight_on_bit": {"shape": "step", "initial": weight_on_bit, "value": weight_on_bit, "at": at},
            "rotation": {"value": 10.0},
            "duration": 10.0,
        },
        "effects": {
            "stretch": {}, "torsion": {},
            "internal_damping": {"bending_time": 1e-3, "stretch_time": 2e-3, "torsion_time": 2e-3}, **effects,
        },
        "numerics": {"elements": 8, "step": step},
    })  # fmt: skip


def drilled(twin: Twin) -> float:
    """Depth drilled since the start [m]; 0 without a bit that cuts."""
    return float(twin.dynamics.parameters.drive.bit.impulse[DRILLED])
