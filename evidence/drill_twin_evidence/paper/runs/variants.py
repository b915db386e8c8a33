# SPDX-License-Identifier: Apache-2.0
"""Variants of the bench: other interpretations of what the paper does not specify."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from drill_twin_evidence.paper.runs.cases import DAMPING, Case

CASES = (Case(20.0, 2.0), Case(40.0, 2.0), Case(150.0, 2.0), Case(300.0, 2.0))
"""Cases of each variant."""


@dataclass(frozen=True)
class Variant:
    """A variant of the bench."""

    name: str
    changes: dict[str, float | str] = field(default_factory=dict)
    """Values in SI by their key in the scene."""


VARIANTS = (
    Variant("as calibrated: bit slides, load counted at the bit, vertical, R is the radius, straight ramp"),
    Variant("bit guided on the axis, as on the bench", {"string.bit_end": "guided"}),
    Variant("load counted at the top, as in the simulation", {"rig.weight_on_bit.at": "top"}),
    Variant("R = 90 mm is the diameter", {"hole.radius": 0.045}),
    Variant("hole tilted by 10 degrees", {"hole.inclination": math.radians(10.0)}),
    Variant("load as a STEP of ADAMS of the same duration", {"rig.weight_on_bit.shape": "step"}),
    Variant(
        "friction that does not fall with slip, and a bit that rubs less: slow whirl at high load",
        {
            **dict.fromkeys(DAMPING, 30e-3),
            "effects.wall_friction.coefficient": 0.25,
            "effects.wall_friction.decay": 0.0,
            "effects.bit_friction.coefficient": 0.04,
            "effects.bit_friction.radius": 3.5e-3,
        },
    ),
    Variant(
        "two branches: friction high at rest, low in sliding, under a rod of little damping",
        {
            "rig.weight_on_bit.duration": 12.0,
            "rig.rotation.duration": 5.0,
            "rig.rotation.shape": "step",
            "effects.bow.amplitude": 1e-3,
            "effects.internal_damping.bending_time": 12e-3,
            "effects.internal_damping.stretch_time": 1e-3,
            "effects.internal_damping.torsion_time": 1e-3,
            "effects.wall_friction.coefficient": 0.35,
            "effects.wall_friction.decay": 5.0,
            "effects.bit_friction.coefficient": 0.0,
        },
    ),
)
