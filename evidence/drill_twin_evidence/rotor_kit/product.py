# SPDX-License-Identifier: Apache-2.0
"""The kit in drill_twin: a scene of one rig, and its vectors a unit of unbalance."""

from __future__ import annotations

from typing import Any

import numpy as np

from drill_twin.dynamics.rotordynamics import forced_response
from drill_twin.scene import Scene
from drill_twin_evidence.rotor_kit.elements import STEEL_DENSITY, Complex, Real
from drill_twin_evidence.rotor_kit.rig import DIAMETER, MICRO_PER_GRAM_MM, RUNOUT_SPEED, Rigs

ELEMENTS = 24
RESPONSE = getattr(forced_response, "unbalance_response", None)  # None before drill_twin has discs
HOLE = 0.1  # [m] radius: wider than any motion


def has_response() -> bool:
    """Return whether this drill_twin has the response to an unbalance of discs."""
    return RESPONSE is not None


def scene_of(rig: Rigs) -> dict[str, Any]:
    """Return the scene of one rig, shapes of arrays (1, ...); bearing 1 is at the bit's end."""
    rotors = rig.rotors()
    span, discs, bearings = float(rig.span[0]), rotors.discs, rotors.bearings
    supports = []
    for i in range(2):
        stiff, damping = bearings.stiffness[0, i], bearings.damping[0, i]
        supports.append(
            {
                "name": f"bearing_{i + 1}",
                "distance_from_bit": float(bearings.places[0, i]),
                "stiffness": float(stiff[0, 0]),
                "stiffness_y": float(stiff[1, 1]),
                "stiffness_xy": float(stiff[0, 1]),
                "stiffness_yx": float(stiff[1, 0]),
                "damping": float(damping[0, 0]),
                "damping_y": float(damping[1, 1]),
                "tilt_stiffness": float(bearings.rotational[0, i]),
            }
        )
        supports.append(
            {
                "name": f"air_{i + 1}",
                "distance_from_bit": float(discs.places[0, i]),
                "damping": float(discs.damping[0, i]),
            }
        )
    second = np.pi * DIAMETER**4 / 64
    return {
        "name": "kit",
        "string": {
            "sections": [
                {
                    "length": span,
                    "outer_diameter": DIAMETER,
                    "youngs_modulus": float(rotors.bending_stiffness[0] / second),
                    "density": STEEL_DENSITY,
                }
            ],
            "discs": [
                {
                    "name": f"disc_{i + 1}",
                    "distance_from_bit": float(discs.places[0, i]),
                    "mass": float(discs.mass[0, i]),
                    "polar_inertia": float(discs.polar[0, i]),
                    "diametral_inertia": float(discs.diametral[0, i]),
                }
                for i in range(2)
            ],
            "supports": supports,
            "marks": [
                {"name": f"probes_{i + 1}", "distance_from_bit": float(place), "on": "centre"}
                for i, place in enumerate(rig.probe_places()[0])
            ],
            "bit_end": "free",
            "top_end": "free",
        },
        "hole": {"radius": HOLE},
        "rig": {
            "weight_on_bit": {"shape": "constant", "value": 0.0},
            "rotation": {"shape": "constant", "value": 105.0},
            "duration": 1.0,
        },
        "effects": {"gyroscopic": {}},
        "numerics": {"elements": ELEMENTS},
    }


def sensitivities(rig: Rigs, speeds: Real) -> Complex:
    """Return drill_twin's vectors a unit of unbalance [um per g mm, lag] at speeds [rad/s]: (speeds, 4, 2).

    Raises:
        ValueError: if this drill_twin has no response to an unbalance of discs.
    """
    if RESPONSE is None:
        raise ValueError("this drill_twin has no discs; expected forced_response.unbalance_response")
    scene = Scene.model_validate(scene_of(rig))
    found = RESPONSE(scene, np.append(speeds, RUNOUT_SPEED))
    motion = found.transpose(0, 2, 3, 1)  # speeds, marks, axes, discs
    shown = np.stack([rig.seen(one[None])[0] for one in motion])
    common = np.exp(1j * np.deg2rad(rig["angle"][0])) * MICRO_PER_GRAM_MM
    turned: Complex = np.conj(shown[:-1] - rig["runout_share"][0] * shown[-1]) * common
    return turned
