# SPDX-License-Identifier: Apache-2.0
"""Curved hole: soft string and capstan."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.dynamics.twin.frame import Frame
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DIAMETER, LINE_MASS, WALLED, quiet_scene
from drill_twin_evidence.verify.signals import run_for

CLEARANCE = 0.01
RADIUS = CLEARANCE + DIAMETER / 2
WEIGHT = LINE_MASS * 9.81
SETTLING: dict[str, Any] = {
    "drag": {"linear": 1.0},
    "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
}
SOFT_STRING = "Johancsik, Friesen and Dawson 1984"


def bend(radius: float, length: float, inclination: float = 0.0, azimuth: float = 0.0, hole: float = RADIUS) -> Any:
    """A hole that builds inclination along one circular arc [m], as the block of a scene."""
    stations = [
        {"depth": depth, "inclination": inclination + depth / radius, "azimuth": azimuth} for depth in (0.0, length)
    ]
    return {"radius": hole, "survey": stations}


@case()
def pulled_through_a_bend() -> Iterator[Row]:
    """Weightless string of 20 m under a tension of 20 N in a bend of 40 m radius, without friction.

    At rest; the wall force leaves out the ends, which are held at the centre of the hole.
    """
    scene = quiet_scene(SETTLING, of=WALLED, length=20.0, elements=80, step=2e-3, weight_on_bit=-20.0, marks=(10.0,),
                        hole=bend(40.0, 20.0))  # fmt: skip
    twin, frame = _at_rest(scene, 20.0, 3.0)
    exact = 20.0 / (40.0 - CLEARANCE)
    per_metre = frame.wall_force[20:-20] / 0.25
    worst = per_metre[np.argmax(np.abs(per_metre - exact))]
    yield Row("force of the wall, where worst [N/m]", "T / R", SOFT_STRING, exact, float(worst), 2e-3)
    yield Row("hookload [N]", "T", SOFT_STRING, 20.0, frame.rig.hookload, 1e-3)
    yield Row("off the axis of the hole to the inside [m]", "clearance + (T / R K)^(2/3)", "Hertz 1882",
              CLEARANCE + (exact / 1e7) ** (2.0 / 3.0), -float(frame.marks.centre[0, 0]), 1e-3)  # fmt: skip
    place, turn = twin.unknowns[0][0, 0:3], 0.5
    yield Row("place of the bit across the top's axis, of the bend [-]", "1 - cos(L / R)", "geometry",
              1.0 - np.cos(turn), -float(place[0]) / 40.0, 2e-3)  # fmt: skip


@case(pull=(20.0, 200.0))
def weight_in_a_bend(pull: float) -> Iterator[Row]:
    """A heavy string in a bend that builds from 40 deg: at 20 N it lies on the low side, at 200 N it is pulled up to
    the high side.

    The soft string has no bending stiffness; error of 120 elements in a bend of 60 m: 2e-3.
    """
    length, radius = 30.0, 60.0
    scene = quiet_scene(
        SETTLING | {"gravity": {"magnitude": 9.81}}, of=WALLED, length=length, elements=120, step=2e-3,
        weight_on_bit=-pull, hole=bend(radius, length, 0.7, 0.4), marks=(15.0,),
    )  # fmt: skip
    twin, frame = _at_rest(scene, pull, 4.0)
    inclination = 0.7 + (length - twin.rod.arc) / radius
    tension = pull + WEIGHT * radius * (np.sin(inclination[0]) - np.sin(inclination))
    normal = (tension / radius - WEIGHT * np.sin(inclination))[20:-20]
    found = frame.wall_force[20:-20] / (length / 120)
    worst = int(np.argmax(np.abs(found / np.abs(normal) - 1.0)))
    yield Row("force of the wall, where worst [N/m]", "|T / R - w sin(inclination)|", SOFT_STRING,
              float(np.abs(normal[worst])), float(found[worst]), 4e-3)  # fmt: skip
    yield Row("side it lies on (1 low, -1 high)", "sign of w sin(inclination) - T / R", SOFT_STRING,
              -float(np.sign(normal[40])), float(np.sign(frame.marks.centre[0, 0])), 0.0)  # fmt: skip
    yield Row("hookload [N]", "pull + w R (sin of inclination at the bit - at the top)", SOFT_STRING,
              float(pull + tension[-1] - tension[0]), frame.rig.hookload, 2e-3)  # fmt: skip


@case()
def capstan() -> Iterator[Row]:
    """Soft string pulled through a bend of one radian with friction.

    Near its held ends it is off the wall, over a shorter length the softer it is and the narrower the hole: 1 %.
    """
    steps = 400
    scene = quiet_scene(
        SETTLING | {"wall_friction": {"coefficient": 0.3}}, of=WALLED, length=20.0, elements=80, step=2e-3,
        weight_on_bit=-1.0, at="top", sections=({"youngs_modulus": 2.3e8},), marks=(),
        hole=bend(20.0, 20.0, hole=0.5e-3 + DIAMETER / 2),
    )  # fmt: skip
    twin = Twin(scene)
    for k in range(steps):
        pull = 1.0 + 99.0 * (k + 1) / steps
        frame = twin.advance(Command(weight_on_bit=-pull, rotation=0.0), 0.02)
    mean = pull - 0.5 * 99.0 / steps  # reactions are means over the frame
    yield Row("force at the hook over that at the bit [-]", "exp(mu theta)", "Euler 1769; Eytelwein 1808",
              float(np.exp(0.3)), mean / -frame.rig.bit_force, 1e-2)  # fmt: skip


def _at_rest(scene: Scene, pull: float, seconds: float) -> tuple[Twin, Frame]:
    twin = run_for(scene, seconds, interval=0.02)
    frame = twin.advance(Command(weight_on_bit=-pull, rotation=0.0), 0.02)
    speed = float(np.abs(frame.velocities).max())
    if speed > 1e-4:
        raise ValueError(f"expected the string to be at rest after {seconds:g} s, found it at {speed:.3g} m/s")
    return twin, frame
