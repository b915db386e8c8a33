# SPDX-License-Identifier: Apache-2.0
"""Scenes for exact checks: the paper's rod with only the effects a reference has. Plain numbers are SI."""

from typing import Any

from drill_twin.scene import Scene

LENGTH, DIAMETER = 5.0, 0.0165
YOUNG, POISSON, DENSITY = 2.3e9, 0.394, 1100.0
AREA = 3.141592653589793 / 4 * DIAMETER**2
EI = YOUNG * 3.141592653589793 / 64 * DIAMETER**4
EA = YOUNG * AREA
GJ = YOUNG / (2 * (1 + POISSON)) * 3.141592653589793 / 32 * DIAMETER**4
LINE_MASS = DENSITY * AREA
BARE: dict[str, Any] = {"stretch": {}, "torsion": {}}
ROLLING: dict[str, Any] = {
    "bow": {"amplitude": 2e-3},
    "drag": {"linear": 0.02},
    "internal_damping": {"bending_time": 2e-3, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "wall": {"stiffness": 1e7},
    "wall_friction": {"coefficient": 0.5},
    "lateral_kick": {"velocity": 0.05, "shape": "hump"},
}
"""Whirls into the wall of a 40 mm hole under a few newtons, and rolls there."""


def rod_scene(  # noqa: PLR0913
    *,
    effects: dict[str, Any],
    bit_end: str = "guided",
    length: float = LENGTH,
    elements: int = 24,
    step: float | str = "auto",
    radius: float = 5.0,
    inclination: float = 0.0,
    weight_on_bit: float = 0.0,
    at: str = "bit",
    marks: tuple[float, ...] = (2.5,),
    frame_rate: float = 100.0,
    form: str = "spatial",
) -> Scene:
    """The PA6 rod with the given effects; `weight_on_bit` acts from the first instant.

    The form "lateral" leaves stretch and torsion out.
    """
    return Scene.model_validate({
        "name": "check",
        "string": {
            "sections": [{
                "name": "rod", "length": length, "outer_diameter": DIAMETER, "inner_diameter": 0.0,
                "youngs_modulus": YOUNG, "poisson_ratio": POISSON, "density": DENSITY,
            }],
            "marks": [
                {"name": f"mark_{i + 1}", "distance_from_bit": place, "on": "centre"} for i, place in enumerate(marks)
            ],
            "bit_end": bit_end,
        },
        "hole": {"radius": radius, "inclination": inclination},
        "rig": {
            "weight_on_bit": {
                "shape": "step", "initial": weight_on_bit, "value": weight_on_bit, "duration": 1.0, "at": at,
            },
            "rotation": {"shape": "constant", "value": 0.0},
            "duration": 10.0,
        },
        "effects": (BARE if form == "spatial" else {}) | effects,
        "numerics": {"elements": elements, "step": step, "frame_rate": frame_rate},
    })  # fmt: skip
