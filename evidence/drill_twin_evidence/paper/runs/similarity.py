# SPDX-License-Identifier: Apache-2.0
"""Similarity of the model rod and a drillstring: the paper's 21.6 r/min per rev/s, and the scales that belong to it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drill_twin.scene import Scene
from drill_twin_evidence.paper.runs.published import published

PIPE = {"outer_diameter": 0.127, "inner_diameter": 0.1086, "mass_per_length": 29.0, "youngs_modulus": 210e9}
"""A 5 in, 19.5 lb/ft drill pipe (API 5DP) [m, m, kg/m, Pa]."""
GRAVITY = 9.80665


@dataclass(frozen=True)
class Scale:
    """A quantity of the rod and its equivalent in the field."""

    what: str
    rod: str
    field: str
    why: str


def similarity(scene: Scene) -> list[Scale]:
    """Scales between the rod and a 5 in pipe: lengths as the diameters, speeds by the Froude number.

    Equal Froude number Omega^2 d / g: a field speed of 60 / sqrt(lambda) r/min for each rev/s. Loads as bending
    stiffness over length squared (buckling), or as weight per length times length.
    """
    (rod,) = scene.string.sections
    ratio = PIPE["outer_diameter"] / rod.outer_diameter
    implied = (60.0 / published().similarity) ** 2 * rod.outer_diameter
    second_moment = math.pi / 64.0 * (PIPE["outer_diameter"] ** 4 - PIPE["inner_diameter"] ** 4)
    bending = PIPE["youngs_modulus"] * second_moment / (rod.youngs_modulus * rod.second_moment)
    buckling = bending / ratio**2
    weight = PIPE["mass_per_length"] / rod.mass_per_length * ratio
    load = scene.rig.weight_on_bit.value
    return [
        Scale("speed", "1 rev/s", f"{60.0 / math.sqrt(ratio):.2f} r/min",
              f"Froude, 5 in pipe; the paper: {published().similarity:g}, which is Froude for a pipe of "
              f"{implied * 1e3:.1f} mm"),
        Scale("length", f"{rod.length:g} m", f"{rod.length * ratio:.1f} m", f"as the diameters, 1 : {ratio:.2f}"),
        Scale("hole radius", f"{scene.hole.radius * 1e3:g} mm", f"{scene.hole.radius * ratio * 1e3:.0f} mm",
              "as the diameters: wider than any field hole"),
        Scale("weight on bit", f"{load:g} N", f"{load * buckling * 1e-3:.0f} kN",
              f"buckling, EI / length^2: 1 N is {buckling * 1e-3:.2f} kN"),
        Scale("weight on bit", f"{load:g} N", f"{load * weight * 1e-3:.0f} kN",
              f"weight of the string: 1 N is {weight * 1e-3:.2f} kN; the two differ"),
    ]  # fmt: skip
