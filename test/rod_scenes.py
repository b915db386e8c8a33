# SPDX-License-Identifier: Apache-2.0
"""Scenes of the paper's rod with few effects, and what is read off their motion. Plain numbers are SI."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

FORMS = ("spatial", "lateral")
AT_REST = Command(weight_on_bit=0.0, rotation=0.0)
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
EULER_LOAD = 4.0 * pi**2 * EI / LENGTH**2
"""Between clamps [N]."""

BARE: dict[str, Any] = {"stretch": {}, "torsion": {}}
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
FATIGUE: dict[str, Any] = {
    "sections": [{"name": "middle", "distance_from_bit": 0.5 * LENGTH}],
    "line": {"stress_range": 1e6, "slope": 3.0}, "mean_stress": "none", "smallest_range": 1e4,
}  # fmt: skip
STRESSED = {**WALLED, "fatigue": FATIGUE}
"""Set of effects with a wall, and the stress at mid-span."""


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
    """The rod with the effects given; the other effects of the set `of` are listed too, with nothing to do.

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


def in_equilibrium(scene: Scene) -> Scene:
    """The scene with its string in static equilibrium at time zero."""
    return scene.model_copy(update={"rig": scene.rig.model_copy(update={"start": "equilibrium"})})


def rates(signal: NDArray[Any], interval: float, order: int = 2) -> ComplexArray:
    """Complex rates lambda [1/s] of a sum of exp(lambda t), by linear prediction (Prony's method)."""
    history = np.stack([signal[k : k - order] for k in range(order)], -1)
    combination = np.linalg.lstsq(history, signal[order:], rcond=1e-10)[0]
    found: ComplexArray = np.log(np.roots(np.append(1.0, -combination[::-1])).astype(complex)) / interval
    return found


def first_mode(arc: Array) -> tuple[Array, Array]:
    """First mode of the clamped-clamped rod and its slope, unscaled (Blevins 1979)."""
    x, ratio = 4.730040745 / LENGTH * arc, 0.9825022158
    shape = np.cosh(x) - np.cos(x) - ratio * (np.sinh(x) - np.sin(x))
    return shape, 4.730040745 / LENGTH * (np.sinh(x) + np.sin(x) - ratio * (np.cosh(x) - np.cos(x)))


def rotating_frame_response(
    scene: Scene, speed: float, seconds: float, interval: float = 0.02
) -> tuple[complex, float, float]:
    """Steady position of the first mark in the frame that rotates with the string, its scatter [m], and torque [N m].

    Means over the last second of a run whose rotation rises to `speed` within the first second.
    """
    twin = Twin(scene)
    places, torques = [], []
    for k in range(round(seconds / interval)):
        frame = twin.advance(Command(weight_on_bit=0.0, rotation=speed * min((k + 1) * interval, 1.0)), interval)
        places.append(complex(*frame.marks.centre[0, :2]) * np.exp(-1j * frame.marks.spin[0]))
        torques.append(frame.rig.top_drive_torque)
    last = slice(-round(1.0 / interval), None)
    return complex(np.mean(places[last])), float(np.std(places[last])), float(np.mean(torques[last]))
