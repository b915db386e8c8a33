# SPDX-License-Identifier: Apache-2.0
"""Types of bit: torque and boundary of stick-slip, of the twin beside two masses on a spring and the literature.

`python -m drill_twin_evidence.validation.bit_types` prints the table of `evidence/docs/bit_types.md`. A vertical string
of 3,600 m drills with 22 klbf and 8 1/2 in, and the boundary is the speed of the top from which a bit that starts from
rest does not stick any more. Only the retardation of twist damps: no mud, no friction along the string.

Two degrees of freedom: the bit, with the inertia of the collars and a third of the pipe's, on the spring of the pipe;
the top turns as prescribed. Nothing here is tuned to the boundary of the field, which is general knowledge.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.bit_torque_stribeck import BITS, BitTorqueStribeck
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.contact.torsional_reference import DENSITY, SHEAR, Pipe, Torsion

COLLARS, PIPE = Pipe(90.0, 0.17145, 0.07144), Pipe(3510.0, 0.127, 0.10861)
WEIGHT, DIAMETER = 22e3 * 4.4482216, 8.5 * 0.0254
RETARDATION = 1e-3
"""Of twist [s]."""
SECONDS, LATE, SPIN_UP = 100.0, 40.0, 10.0
"""Time of a run, of its end that is judged, and in which the top reaches its speed [s]."""
SLOW = 0.1
"""Speed below which a bit sticks [rad/s]."""
SLOWEST, FASTEST, APART = 20.0, 300.0, 5.0
"""Least and largest boundary that is looked for, and how near it is found [rpm]."""
FIELD = (100.0, 150.0)
"""Boundary of the field with PDC bits, from general knowledge [rpm]."""
KILO_FOOT_POUND = 1355.8179


def polar(pipe: Pipe) -> float:
    """Polar moment of the section of a pipe [m4]."""
    return math.pi / 32.0 * (pipe.outer**4 - pipe.inner**4)


STIFFNESS = SHEAR * polar(PIPE) / PIPE.length
INERTIA = DENSITY * (polar(COLLARS) * COLLARS.length + polar(PIPE) * PIPE.length / 3.0)


def law_of(kind: str) -> BitTorqueStribeck:
    """Law of a type of bit."""
    return BitTorqueStribeck.model_validate({"bit": kind, "radius": DIAMETER / 3.0})


def torque_of(kind: str) -> Callable[[float], float]:
    """Torque of a type of bit against its speed [N m]."""
    law, arm = law_of(kind), WEIGHT * DIAMETER / 3.0
    excess = law.sticking - law.sliding
    return lambda speed: arm * (law.sliding + excess * math.exp(-law.decay * speed))


def sticks_on_a_spring(kind: str, rpm: float) -> bool:
    """True if the bit on a spring stands still at times at the end of a run."""
    stiffness, inertia = STIFFNESS * np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag([INERTIA, 1.0])
    masses = Torsion(stiffness, inertia, RETARDATION, torque_of(kind), rpm * math.pi / 30.0, SPIN_UP)
    time, speed = masses.run(SECONDS, 0.02)
    return bool(speed[time > SECONDS - LATE].min() < SLOW)


def well(kind: str, rpm: float) -> Scene:
    """The string as a scene, whose bit is of a type; it moves sideways in its lowest 20 m."""
    sections = [{"length": each.length, "outer_diameter": each.outer, "inner_diameter": each.inner}
                for each in (COLLARS, PIPE)]  # fmt: skip
    times = ("bending_time", "stretch_time", "torsion_time")
    return Scene.model_validate({
        "name": f"bit_{kind}",
        "string": {"sections": sections, "bit_end": "guided"},
        "hole": {"radius": 0.5 * DIAMETER},
        "rig": {"weight_on_bit": {"value": WEIGHT}, "rotation": {"value": f"{rpm} rpm"}, "duration": SECONDS},
        "effects": {
            "gravity": {}, "stretch": {}, "torsion": {}, "wall": {"stiffness": 1e10},
            "internal_damping": dict.fromkeys(times, RETARDATION),
            "bit_torque_stribeck": {"bit": kind, "radius": DIAMETER / 3.0},
        },
        "numerics": {"frame_rate": 50.0, "lateral_from": 3580.0},
    })  # fmt: skip


def sticks_in_the_twin(kind: str, rpm: float) -> bool:
    """True if the bit of the twin stands still at times at the end of a run."""
    twin, top = Twin(well(kind, rpm)), rpm * math.pi / 30.0
    ends = 0.02 * np.arange(1, round(SECONDS / 0.02) + 1)
    speeds = [twin.advance(Command(WEIGHT, top * min(end / SPIN_UP, 1.0)), 0.02).rig.bit_speed for end in ends.tolist()]
    return bool(np.min(np.array(speeds)[ends > SECONDS - LATE]) < SLOW)


def boundary(sticks: Callable[[float], bool]) -> float:
    """Speed of the top above which the bit does not stick, by bisection [rpm]; NaN: beyond the range."""
    low, high = SLOWEST, FASTEST
    if not sticks(low) or sticks(high):
        return math.nan
    while high - low > APART:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sticks(middle) else (low, middle)
    return 0.5 * (low + high)


def linear_boundary(kind: str) -> float:
    """Speed from which small motion of the bit on the spring decays: -T' is at most the damping of the spring [rpm]."""
    law = law_of(kind)
    fall = WEIGHT * DIAMETER / 3.0 * (law.sticking - law.sliding) * law.decay
    return math.log(fall / (STIFFNESS * RETARDATION)) / law.decay * 30.0 / math.pi


def main() -> None:
    """Print the table."""
    print("| type | torque while it slides | small motion, two masses | sticks, two masses | sticks, twin | field |")
    print("| --- | --- | --- | --- | --- | --- |")
    for kind in BITS:
        torque = torque_of(kind)(15.0) / KILO_FOOT_POUND
        models = [boundary(partial(sticks, kind)) for sticks in (sticks_on_a_spring, sticks_in_the_twin)]
        field = f"{FIELD[0]:g} to {FIELD[1]:g} rpm" if kind == "pdc" else "not known"
        speeds = (f"{rpm:.0f} rpm" for rpm in (linear_boundary(kind), *models))
        cells = (kind, f"{torque:.1f} kft lbf", *speeds)
        print(f"| {' | '.join(cells)} | {field} |", flush=True)


if __name__ == "__main__":
    main()
