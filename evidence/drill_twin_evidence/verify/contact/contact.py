# SPDX-License-Identifier: Apache-2.0
"""Contact of the string with the wall."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DIAMETER, LINE_MASS, ROLLING, WALLED, quiet_scene
from drill_twin_evidence.verify.signals import AT_REST

RADIUS = DIAMETER / 2
SPEED, CLEARANCE, STEP = 0.1, 1e-3, 2e-5
WEIGHT, STIFFNESS = LINE_MASS * 9.81, 1e7
WALLS: dict[str, dict[str, float]] = {"hertz": {"stiffness": 1e7}, "linear": {"linear_stiffness": 1e6}}
LOSSES = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}
HUNT = "Hunt and Crossley 1975"


def bounce(wall: dict[str, Any], form: str) -> tuple[float, float, float]:
    """Depth [m], duration [s] and restitution of a soft string that hits the wall with all its length at once.

    The string is so soft and the impact so short that the ends do not matter at mid-length: each slice is a mass on the
    spring of the wall.
    """
    scene = quiet_scene(
        {}, of=WALLED | {"wall": wall}, bit_end="free", length=1.0, elements=16, step=STEP, frame_rate=2000.0,
        radius=CLEARANCE + RADIUS, sections=({"youngs_modulus": 1e3},), marks=(0.5,), form=form,
    )  # fmt: skip
    twin = Twin(scene)
    twin.unknowns[1][:-1, 0] = SPEED
    depths: list[float] = []
    while len(depths) < 3000:
        marks = twin.advance(AT_REST, STEP).marks
        depths.append(float(marks.centre[0, 0]) - CLEARANCE)
        if marks.velocity[0, 0] < 0.0 and depths[-1] < 0.0:
            break
    d = np.array(depths)
    first, last = np.flatnonzero(d > 0.0)[[0, -1]]
    inside = (last - first) + d[first] / (d[first] - d[first - 1]) + d[last] / (d[last] - d[last + 1])
    return float(d.max()), float(inside * STEP), float(-marks.velocity[0, 0] / SPEED)


@case(forms=FORMS)
def bounce_without_loss(form: str) -> Iterator[Row]:
    """Impact on a Hertz spring and on a linear one.

    A step of 0.02 ms puts more than 50 steps into the shorter impact; the error is 2e-4.
    """
    deepest = (5.0 * LINE_MASS * SPEED**2 / (4.0 * 1e7)) ** 0.4
    exact = {
        "hertz": (deepest, 2.9432 * deepest / SPEED, "(5 m v^2 / 4 K)^(2/5)", "2.9432 depth / v",
                  "Johnson 1985, section 11.4"),
        "linear": (SPEED * np.sqrt(LINE_MASS / 1e6), np.pi * np.sqrt(LINE_MASS / 1e6), "v sqrt(m / K)",
                   "pi sqrt(m / K)", "oscillator"),
    }  # fmt: skip
    for kind, (depth, seconds, of_depth, of_seconds, source) in exact.items():
        found = bounce(WALLS[kind] | {"restitution": 1.0}, form)
        yield Row(f"{kind}: depth [m]", of_depth, source, float(depth), found[0], 5e-4)
        yield Row(f"{kind}: duration [s]", of_seconds, source, float(seconds), found[1], 5e-4)
        yield Row(f"{kind}: restitution [-]", "1", "energy", 1.0, found[2], 1e-3)


@case(wall=tuple(WALLS))
def restitution(wall: str) -> Iterator[Row]:
    """Restitution at the reference speed, which is the stated value, and at half of that speed, where it is higher.

    Time step as without loss.
    """
    for stated in (0.1, 0.5, 0.9):
        found = bounce(WALLS[wall] | {"restitution": stated}, "lateral")[2]
        yield Row(f"restitution stated as {stated:g} [-]", "a - ln(1 + a) = -e a - ln(1 - e a), a ~ speed", HUNT,
                  stated, found, 1e-3, relative=False)  # fmt: skip
    if wall == "hertz":
        found = bounce(WALLS[wall] | {"restitution": 0.5, "reference_speed": 2.0 * SPEED}, "lateral")[2]
        a = 0.5 * 1.432750533  # the root for e = 0.5, halved
        yield Row("a - ln(1 + a) + e a + ln(1 - e a) at half the speed [-]", "0", HUNT, 0.0,
                  float(a - np.log1p(a) + found * a + np.log1p(-found * a)), 2e-4, relative=False)  # fmt: skip


def string_in_level_hole(speed: float, elements: int, form: str, friction: float = 0.3) -> Twin:
    """A string of 20 m that lies in a level hole, after 6 s of rotation."""
    effects = {
        "gravity": {"magnitude": 9.81},
        "drag": {"linear": 1.0},
        "internal_damping": LOSSES,
        "wall_friction": {"coefficient": friction},
    }
    scene = quiet_scene(
        effects, of=WALLED, length=20.0, elements=elements, radius=0.01 + RADIUS, inclination=np.pi / 2, marks=(10.0,),
        step=2e-3, form=form,
    )  # fmt: skip
    twin = Twin(scene)
    for k in range(300):
        twin.advance(Command(weight_on_bit=0.0, rotation=speed * min((k + 1) / 100.0, 1.0)), 0.02)
    return twin


@case(forms=FORMS, elements=(40, 80))
def weight_on_the_wall(elements: int, form: str) -> Iterator[Row]:
    """Wall force of a string at rest in a level hole, far from its ends, for two meshes: its weight per length.

    The tolerance covers the residual motion.
    """
    frame = string_in_level_hole(0.0, elements, form).advance(AT_REST, 0.02)
    inside = slice(elements // 4, -elements // 4)
    per_metre = frame.wall_force[inside] * elements / 20.0
    worst = per_metre[np.argmax(np.abs(per_metre - WEIGHT))]
    yield Row("force of the wall, where worst [N/m]", "w", "balance", WEIGHT, float(worst), 1e-3)
    yield Row("penetration [m]", "(w / K)^(2/3)", "Hertz 1882", (WEIGHT / STIFFNESS) ** (2.0 / 3.0),
              float(frame.marks.centre[0, 0]) - 0.01, 1e-2)  # fmt: skip


@case(forms=FORMS, speed=(6.0, -6.0))
def climbing(speed: float, form: str) -> Iterator[Row]:
    """A rotating string climbs the wall against its rotation to the angle of friction; torque of the drive.

    The string is bent near its ends, which are held at the centre of the hole; internal damping there takes 2 % more
    torque.
    """
    frame = string_in_level_hole(speed, 40, form).advance(Command(weight_on_bit=0.0, rotation=speed), 0.02)
    angle = np.arctan2(frame.marks.centre[0, 1], frame.marks.centre[0, 0])
    torque = 0.3 * float(frame.wall_force.sum()) * RADIUS
    yield Row("angle from the low side [rad]", "-sign(Omega) arctan(mu)", "Coulomb 1785",
              float(-np.sign(speed) * np.arctan(0.3)), float(angle), 1e-2)  # fmt: skip
    yield Row("torque of the drive [N m]", "mu N r", "Coulomb 1785", float(np.sign(speed)) * torque,
              frame.rig.top_drive_torque, 2.5e-2)  # fmt: skip


@case(forms=FORMS)
def pure_rolling(form: str) -> Iterator[Row]:
    """Backward rolling on the wall without slip, under sufficient friction.

    The orbit is taken from the last 5 s; contact creep and small changes of the orbit radius remain.
    """
    scene = quiet_scene(ROLLING, of=WALLED, step=2e-3, radius=0.04, form=form)
    twin = Twin(scene)
    places = []
    for k in range(1000):
        share = min((k + 1) * 0.01 / 2.0, 1.0)
        frame = twin.advance(Command(weight_on_bit=30.0 * share, rotation=math.tau * share), 0.01)
        places.append(complex(*frame.marks.centre[0, :2]))
    late = np.array(places[-500:])
    turned = np.unwrap(np.angle(late))
    found = (turned[-1] - turned[0]) / (499 * 0.01) / math.tau
    yield Row("whirl ratio [-]", "-r_pipe / r_orbit", "no slip; Vandiver, Nicholson and Shyu 1990",
              float(-RADIUS / np.abs(late).mean()), float(found), 2e-3)  # fmt: skip
