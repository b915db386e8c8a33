# SPDX-License-Identifier: Apache-2.0
"""The bare rod, and each effect as it is switched on alone on top of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL, SPATIAL
from drill_twin.physics.effects import EFFECTS
from drill_twin.scene import Scene, load_scene

ROD = Path(__file__).resolve().parent.parent / "scenes" / "peers.yaml"

EXAMPLES: dict[str, Mapping[str, str]] = {
    "gravity": {"gravity": "on"},
    "bow": {"bow": "{amplitude: 2 mm}"},
    "eccentricity": {"eccentricity": "{offset: 0.1 mm}"},
    "internal_damping": {"internal_damping": "{bending_time: 2 ms, stretch_time: 1 ms, torsion_time: 1 ms}"},
    "drag": {"drag": "{linear: 0.1 N s/m^2}"},
    "mud": {"mud": "{density: 1000 kg/m^3, viscosity: 1 mPa s}"},
    "mud and quadratic_drag": {"mud": "{density: 1000 kg/m^3, viscosity: 1 mPa s}", "quadratic_drag": "on"},
    "mud and added_mass": {"mud": "{density: 1000 kg/m^3, viscosity: 1 mPa s}", "added_mass": "{coefficient: 1}"},
    "mud and rotation_drag": {"mud": "{density: 1000 kg/m^3, viscosity: 1 mPa s}", "rotation_drag": "on"},
    "mud and viscous_drag": {"mud": "{density: 1000 kg/m^3, viscosity: 1 mPa s}", "viscous_drag": "on"},
    "wall, far": {"wall": "{stiffness: 1e7 N/m^2.5}"},
    "wall, touched": {"wall": "{stiffness: 1e7 N/m^2.5}"},
    "wall and wall_friction, far": {"wall": "{stiffness: 1e7 N/m^2.5}", "wall_friction": "{coefficient: 0.2}"},
    "wall and wall_friction, touched": {"wall": "{stiffness: 1e7 N/m^2.5}", "wall_friction": "{coefficient: 0.2}"},
    "bit_friction": {"bit_friction": "{coefficient: 0.3, radius: 8 mm}"},
    "bit_torque_tanh": {"bit_torque_tanh": "{arm: 1 mm}"},
    "bit_torque_stribeck": {"bit_torque_stribeck": "{radius: 8 mm, sliding: 0.3, sticking: 0.5, decay: 0.5 s/rad}"},
    "bit_mass": {"bit_mass": "{mass: 0.1 kg, inertia: 1e-5 kg m^2}"},
    "bit_side_force": {"bit_side_force": "{force: 0.1 N}"},
    "random_force": {"random_force": "{rms: 0.05 N/m, correlation_time: 0.2 s, correlation_length: 1 m}"},
    "top_shake": {"top_shake": "{amplitude: 0.1 mm, frequency: 3 Hz}"},
}
"""Row of the table -> effects on top of the bare rod. Left out: what needs another end than the guided one."""
SLACK = {"bit_friction": "free", "bit_mass": "free", "bit_side_force": "free"}
"""Effects that need a bit that can move."""
NARROW = "8.3 mm"  # a clearance of 0.05 mm: the buckled rod touches the wall all along


def forms_of(name: str) -> tuple[str, ...]:
    """The forms of the string that a row exists in: some effects need stretch or torsion."""
    needs = {need for key in EXAMPLES.get(name, {}) for need in EFFECTS[key].requires}
    return (SPATIAL,) if needs & {"stretch", "torsion"} else (SPATIAL, LATERAL)


def scene_with(name: str, form: str, elements: int) -> Scene:
    """The peers' rod with the effects of a row of `EXAMPLES` alone, or bare for the name "bare rod"."""
    off = {f"effects.{key}": "off" for key in EFFECTS}
    basic = {"lateral_kick": "{velocity: 0.05 m/s, shape: hump}"}
    if form == SPATIAL:
        basic |= {"stretch": "on", "torsion": "on"}
    on = {f"effects.{key}": value for key, value in (basic | dict(EXAMPLES.get(name, {}))).items()}
    touched = name.endswith("touched")
    return load_scene(ROD, overrides={
        **off, **on, "wob": "40 N" if touched else "5 N",
        "hole.radius": NARROW if touched else "90 mm", "string.bit_end": SLACK.get(name, "guided"),
        **_numerics(elements),
    })  # fmt: skip


def full_scene(elements: int, form: str, rate: float = 10.0) -> Scene:
    """The peers' scene as it is: gravity, drag, wall and friction."""
    lateral = {"effects.stretch": "off", "effects.torsion": "off"} if form == LATERAL else {}
    return load_scene(ROD, overrides=lateral | _numerics(elements, rate))


def _numerics(elements: int, rate: float = 10.0) -> dict[str, str]:
    return {"numerics.elements": str(elements), "numerics.step": "1 ms", "numerics.frame_rate": f"{rate} Hz"}
