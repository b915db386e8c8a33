# SPDX-License-Identifier: Apache-2.0
"""Campbell diagram of a rotor with two discs in two bearings: drill_twin beside ROSS (Timbo et al. 2020).

    pip install ross-rotordynamics "plotly<6"
    python -m drill_twin_evidence.rotors.beside_ross      # whirl frequencies at three speeds, and their difference

ROSS is not a dependency: its elements have rotary inertia and gyroscopic moments, and shear is left out, as here.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.api import modes
from drill_twin.scene import load_scene

LENGTH, ELEMENTS, DIAMETER = 0.56, 56, 0.01
DISCS, OUTER, WIDTH = (0.17, 0.35), 0.08, 0.02
BEARINGS, STIFFNESS, DAMPING = (0.03, 0.49), 250e3, 150.0
SPEEDS = (1.0, 3000.0, 5999.0)
"""Speeds of rotation [rpm]."""
COMPARED = 6
"""Lateral frequencies that are compared, the lowest."""


def by_drill_twin(speed: float) -> list[float]:
    """Lowest lateral frequencies [Hz] at a speed [rpm]."""
    supports = [
        f"{{name: bearing_{k}, distance_from_bit: {place} m, stiffness: {STIFFNESS} N/m, damping: {DAMPING} N s/m}}"
        for k, place in enumerate(BEARINGS)
    ]
    overrides = {
        "string.supports": f"[{', '.join(supports)}]",
        "hole.inclination": "0 deg",
        "effects.gravity": "off",
        "effects.internal_damping": "off",
        "rig.rotation": f"{{shape: constant, value: {speed} rpm}}",
    }
    scene = load_scene("rotor_kit", overrides=overrides)
    return sorted(abs(mode.frequency) for mode in modes(scene).modes)[:COMPARED]


def by_ross(speed: float) -> list[float]:
    """Lowest lateral frequencies [Hz] at a speed [rpm]."""
    import ross

    steel = ross.Material(name="steel", rho=7850.0, E=206e9, G_s=206e9 / 2.6)
    shaft = [
        ross.ShaftElement(L=LENGTH / ELEMENTS, idl=0.0, odl=DIAMETER, material=steel, shear_effects=False)
        for _ in range(ELEMENTS)
    ]
    squares = OUTER**2 + DIAMETER**2
    mass = 7850.0 * math.pi / 4.0 * (OUTER**2 - DIAMETER**2) * WIDTH
    nodes = {place: round(place / LENGTH * ELEMENTS) for place in (*DISCS, *BEARINGS)}
    discs = [
        ross.DiskElement(
            n=nodes[place], m=mass, Ip=mass * squares / 8.0, Id=mass * squares / 16.0 + mass * WIDTH**2 / 12.0
        )
        for place in DISCS
    ]
    bearings = [ross.BearingElement(n=nodes[place], kxx=STIFFNESS, cxx=DAMPING) for place in BEARINGS]
    found = ross.Rotor(shaft, discs, bearings).run_modal(speed=speed * math.pi / 30.0, num_modes=20)
    lateral = found.wd[np.abs(found.log_dec[: found.wd.size]) > 1e-9]  # torsion and stretch have no damping
    return sorted((lateral / math.tau).tolist())[:COMPARED]


def main() -> None:
    """Print both, and the largest difference."""
    worst = 0.0
    for speed in SPEEDS:
        ours, theirs = by_drill_twin(speed), by_ross(speed)
        worst = max(worst, *(abs(a / b - 1.0) for a, b in zip(ours, theirs, strict=True)))
        print(f"{speed:5.0f} rpm  drill_twin {' '.join(f'{value:8.3f}' for value in ours)} Hz")
        print(f"           ROSS       {' '.join(f'{value:8.3f}' for value in theirs)} Hz")
    print(f"largest difference {100.0 * worst:.4f} %")


if __name__ == "__main__":
    main()
