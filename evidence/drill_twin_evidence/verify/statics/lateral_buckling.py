# SPDX-License-Identifier: Apache-2.0
"""Buckling in the hole: snaking on the low side, and the helix."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DIAMETER, EI, LINE_MASS, WALLED, quiet_scene
from drill_twin_evidence.verify.signals import rates

LONG, PACKET, CLEARANCE = 60.0, 10.0, 0.02
WEIGHT, STIFFNESS = LINE_MASS * 9.81, 1e7
DAWSON, LUBINSKI = "Dawson and Paslay 1984", "Lubinski, Althouse and Logan 1962"


def stiffness_of_a_wave(load: float, wave: float, inclination: float, form: str) -> float:
    """Stiffness per length [N/m2] of a small sideways wave [1/m] in the middle of a long string on the low side.

    Args:
        load: Axial compression in the middle [N].
        wave: Wave number [rad/m].
        inclination: Inclination of the hole [rad].
        form: Formulation.
    """
    effects = {
        "gravity": {"magnitude": 9.81},
        "drag": {"linear": 1.0},
        "internal_damping": {"bending_time": 0.02},
    }
    at_bit = load + 0.5 * LONG * WEIGHT * np.cos(inclination)
    scene = quiet_scene(
        effects, of=WALLED, length=LONG, elements=132, radius=CLEARANCE + DIAMETER / 2, inclination=inclination,
        weight_on_bit=at_bit, step=0.02, frame_rate=50.0, form=form,
    )  # fmt: skip
    twin = Twin(scene)
    u, v = twin.unknowns
    for end in (twin.rod.arc, twin.rod.arc - LONG):  # the string starts on the low side
        u[:, 0] += 0.5 * CLEARANCE * (1.0 - 2.0 * np.exp(-((0.6 * end) ** 2)))
        u[:, 3] += CLEARANCE * 0.72 * end * np.exp(-((0.6 * end) ** 2))
    command = Command(weight_on_bit=at_bit, rotation=0.0)
    for _ in range(50):
        twin.advance(command, 0.1)
    place = twin.rod.arc - 0.5 * LONG
    bell = np.exp(-0.5 * (place / PACKET) ** 2)
    v[:] = 0.0
    u[:, 1] += 1e-4 * bell * np.cos(wave * place)
    u[:, 4] += 1e-4 * bell * (-wave * np.sin(wave * place) - place / PACKET**2 * np.cos(wave * place))
    seen = []
    for _ in range(200):
        twin.advance(command, 2e-3)
        seen.append(float(np.sum(u[:, 1] * bell * np.cos(wave * place))))
    return LINE_MASS * float(np.abs(rates(np.array(seen[::5]), 0.01)[0])) ** 2


@case(forms=FORMS, long=True, degrees=(90.0, 75.0))
def snaking(degrees: float, form: str) -> Iterator[Row]:
    """Stiffness of small sideways waves of a string on the low side, without friction: it falls with the load in the
    middle and is zero at the snaking load. Linear extrapolation from two smaller loads, at which the string is at rest
    near its ends, where it rises to the centre of the hole.

    The wave is a packet of about 10 m, whose spread of wave numbers adds 3 EI / (10 m)^2, 0.4 % of the load; at 75 deg
    the load changes along it by a tenth.
    """
    inclination = float(np.radians(degrees))
    pressing = WEIGHT * float(np.sin(inclination))
    across = pressing / (CLEARANCE + (pressing / STIFFNESS) ** (2.0 / 3.0))
    loads = (0.0, 25.0) if degrees == 90.0 else (-10.0, 15.0)
    for share in (1.0, 1.3):
        wave = share * float((across / EI) ** 0.25)
        one, two = (stiffness_of_a_wave(load, wave, inclination, form) for load in loads)
        found = loads[0] + (loads[1] - loads[0]) * one / (one - two)
        yield Row(f"snaking load at {share:g} of the worst wave number [N]",
                  "EI k^2 + w sin(alpha) / (r k^2), k = n pi / L; least 2 sqrt(EI w sin(alpha) / r)",
                  DAWSON, EI * wave**2 + across / wave**2, found,
                  1e-2 if degrees == 90.0 else 2e-2)  # fmt: skip


class Trough:
    """Rod of 20 m on the low side of a level hole, without friction, about 15 half-waves long."""

    length, elements, clearance, interval = 20.0, 100, 0.01, 0.05

    def __init__(self) -> None:
        effects = {
            "gravity": {"magnitude": 9.81},
            "drag": {"linear": 2.0},
            "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
        }
        scene = quiet_scene(
            effects, of=WALLED, length=self.length, elements=self.elements, step=5e-3, marks=(),
            radius=self.clearance + DIAMETER / 2, inclination=np.pi / 2,
        )  # fmt: skip
        self.twin = Twin(scene)
        self.critical = 2.0 * float(np.sqrt(EI * WEIGHT / self.clearance))
        self.wave = float((WEIGHT / (EI * self.clearance)) ** 0.25)
        self.share = 0.0

    def load(self, share: float, seconds: float) -> tuple[Array, Array]:
        """Ramp to a share of the snaking load; angle from the low side [rad], wall force [N/m] in the middle half."""
        steps, start = round(seconds / self.interval), self.share
        for k in range(steps):
            self.share = start + (share - start) * (k + 1) / steps
            frame = self.twin.advance(Command(weight_on_bit=self.share * self.critical, rotation=0.0), self.interval)
        middle = slice(self.elements // 4, -self.elements // 4)
        x, y = frame.positions[middle, 0], frame.positions[middle, 1]
        return np.unwrap(np.arctan2(y, x)), frame.wall_force[middle] / (self.length / self.elements)

    def push(self) -> None:
        """Add a small sideways velocity with the critical wave number."""
        rates, arc = self.twin.unknowns[1], self.twin.rod.arc
        rates[:, 1] += 5e-3 * np.sin(np.pi * arc / self.length) ** 2 * np.sin(self.wave * arc + 0.4)


@case()
def snake() -> Iterator[Row]:
    """The rod on the low side stays straight below the snaking load, and above it snakes with the amplitude of least
    energy.

    With theta = A sin(k s), U = EI r^2 (theta''^2 + theta'^4) / 2 - F r^2 theta'^2 / 2 + w r (1 - cos theta), to fourth
    order, has its minimum at the load as given: the amplitude determines the load. The rod contains a whole number of
    waves and its ends are off the wall: 2 %.
    """
    trough = Trough()
    trough.load(0.99, 3.0)
    trough.push()
    straight, _ = trough.load(0.99, 4.0)
    yield Row("angle that is left of a push at 0.99 of the snaking load [rad]", "0 below 2 sqrt(EI w / r)", DAWSON, 0.0,
              float(np.abs(straight).max()), 2e-3, relative=False)  # fmt: skip
    trough.push()
    for share in (1.2, 1.3, 1.4):
        angle, _ = trough.load(share, 4.0)
        square = 2.0 * float(np.mean(angle**2))
        yield Row("load that the amplitude tells, of the snaking load [-]", "sqrt(1 - A^2 / 8) (1 + 3 A^2 / 4)", DAWSON,
                  share, float(np.sqrt(1.0 - square / 8.0) * (1.0 + 0.75 * square)), 2e-2)  # fmt: skip


@case()
def helix_in_a_level_hole() -> Iterator[Row]:
    """Helix in a level hole: its mean wall force over a turn is that of a weightless string; it persists above the load
    of helical buckling and unwinds at a load well below it.

    Means over the middle half, which is not a whole number of turns: 2 %.
    """
    trough = Trough()
    trough.load(2.5, 0.05)
    u, v = trough.twin.unknowns
    arc = trough.twin.rod.arc
    rise = np.clip(np.minimum(arc, 20.0 - arc) / 1.5, 0.0, 1.0)
    angle = np.sqrt(2.5 * trough.critical / (2.0 * EI)) * (arc - 10.0)
    for column, place in enumerate((np.cos(angle), np.sin(angle))):
        u[:, column] = trough.clearance * rise**2 * (3.0 - 2.0 * rise) * place
        u[:, 3 + column] = np.gradient(u[:, column], arc)
        u[[0, -1], 3 + column] = 0.0
    v[:] = 0.0
    angle, force = trough.load(2.5, 4.0)
    load = 2.5 * trough.critical
    yield Row("force of the wall at 2.5 of the snaking load, mean [N/m]", "F^2 r / (4 EI)", LUBINSKI,
              load**2 * trough.clearance / (4.0 * EI), float(force.mean()), 2e-2)  # fmt: skip
    for share, seconds, turns in ((1.05 * 2.0**0.5, 12.0, 1.0), (1.1, 6.0, 0.0)):
        angle, _ = trough.load(share, seconds)
        held = float(np.ptp(angle) > 8.0 * np.pi) if turns else float(np.ptp(angle) > np.pi)
        yield Row(f"helix at {share:.3g} of the snaking load (1 holds, 0 gone)", "holds above 2 sqrt(2) sqrt(EI w / r)",
                  "Chen, Lin and Cheatham 1990", turns, held, 0.0, relative=False)  # fmt: skip


@case(forms=FORMS)
def helix(form: str) -> Iterator[Row]:
    """Weightless rod of ten pitches under 300 N, at rest on the wall: the interior of both helices.

    The formulas are for small slopes; the slope of the helix is 0.085, its square 0.7 %. A rod held at both ends forms
    two helices of opposite hand; the reversals are not part of the interior.
    """
    load, length = 300.0, 15.0
    effects = {
        "bow": {"amplitude": 2e-3},
        "drag": {"linear": 3.0},
        "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
        "lateral_kick": {"velocity": 0.02, "shape": "hump"},
    }
    scene = quiet_scene(effects, of=WALLED, length=length, elements=120, step=2e-3, radius=CLEARANCE + DIAMETER / 2,
                        form=form)  # fmt: skip
    twin = Twin(scene)
    for k in range(500):
        t = (k + 1) * 0.02
        frame = twin.advance(Command(weight_on_bit=load * min(t / 4.0, 1.0), rotation=0.3 * (t < 3.0)), 0.02)
    speed = float(np.abs(frame.velocities).max())
    if speed > 1e-3:
        raise ValueError(f"expected the rod to be at rest after 10 s, found it at {speed:.3g} m/s")
    share, centre = twin.rod.arc / length, frame.positions[:, 0] + 1j * frame.positions[:, 1]
    winding = np.gradient(np.unwrap(np.angle(centre)), twin.rod.arc)
    inside = (np.abs(share - 0.25) < 0.13) | (np.abs(share - 0.75) < 0.13)
    steady = inside & (np.abs(np.abs(winding) / np.median(np.abs(winding[inside])) - 1.0) < 0.05)
    yield Row("share of the interior that is a steady helix [-]", "1", "geometry", 1.0,
              float(steady.sum() / inside.sum()), 0.2)  # fmt: skip
    yield Row("pitch [m]", "2 pi sqrt(2 EI / F)", LUBINSKI,
              math.tau * float(np.sqrt(2.0 * EI / load)), float(math.tau / np.abs(winding[steady]).mean()), 5e-3,
              )  # fmt: skip
    exact = load**2 * float(np.abs(centre[steady]).mean()) / (4.0 * EI)
    yield Row("force of the wall [N/m]", "F^2 r / (4 EI)", LUBINSKI, exact,
              float(frame.wall_force[steady].mean() * 120 / length), 0.015)  # fmt: skip
