# SPDX-License-Identifier: Apache-2.0
"""Regenerative cutting: a bit on a torsional spring under a constant weight."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import modes
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import drilled
from drill_twin_evidence.verify.signals import rates

RICHARD = "Richard, Germay and Detournay 2007"
INERTIA, SPRING, MASS = 116.0, 938.0, 34e3
"""Of bit and string in one [kg m2], of the string [N m/rad], and [kg]."""
ENERGY, RADIUS, THRUST, FRICTION, STRENGTH, BLADES = 60e6, 0.108, 0.6, 0.6, 60e6, 4
AXIAL = THRUST * ENERGY * RADIUS
"""Weight per depth of cut [N/m]."""
TURNING = 0.5 * ENERGY * RADIUS**2
"""Torque per depth of cut [N]."""
LIMIT = 2.0 / BLADES * math.sqrt(2.0 * BLADES * AXIAL / MASS)
"""Speed below which steady drilling of a bit that cannot twist is unstable [rad/s]: 2 sqrt(2 psi / n) sqrt(C / I)."""
DEPTH = 2e-3
LENGTH, DIAMETER = 0.1, 0.03


def scene(worn: float, speed: float, step: float, *, inertia: float = INERTIA, regeneration: bool = True) -> Scene:
    """The bit below a short light rod, the spring; it cuts 2 mm a turn, and its wear flats carry `worn` [N]."""
    shear = SPRING * LENGTH / (math.pi / 32.0 * DIAMETER**4)
    weight = AXIAL * DEPTH + worn
    return Scene.model_validate({
        "name": "bit_on_spring",
        "string": {
            "sections": [{
                "length": LENGTH, "outer_diameter": DIAMETER, "inner_diameter": 0.0,
                "youngs_modulus": 2.6 * shear, "poisson_ratio": 0.3, "density": 1.0,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.2},
        "rig": {
            "weight_on_bit": {"shape": "step", "initial": weight, "value": weight, "at": "top"},
            "rotation": {"value": speed},
            "duration": 60.0,
        },
        "effects": {
            "stretch": {}, "torsion": {}, "bit_mass": {"mass": MASS, "inertia": inertia},
            "bit_regenerative": {
                "radius": RADIUS, "blades": BLADES, "specific_energy": ENERGY, "thrust": THRUST, "friction": FRICTION,
                "wear": worn / (RADIUS * STRENGTH), "contact_strength": STRENGTH, "regeneration": regeneration,
            },
        },
        "numerics": {"elements": 4, "step": step, "tolerance": 1e-9},
    })  # fmt: skip


def drilling(worn: float, speed: float, step: float, kick: float, **more: Any) -> tuple[Twin, Command]:
    """A twin in steady drilling, its rate of penetration larger by a share."""
    twin = Twin(scene(worn, speed, step, **more))
    command = Command(AXIAL * DEPTH + worn, speed)
    u, v = (rows.copy() for rows in twin.unknowns)
    u[:, 6] = twin.rod.arc / LENGTH * (TURNING * DEPTH + 0.5 * FRICTION * RADIUS * worn) / SPRING
    v[:, 6], v[:, 2] = speed, -(1.0 + kick) * speed * DEPTH / math.tau
    twin.dynamics.begin(u, v, command)
    return twin, command


def characteristic_root(speed: float, guess: complex) -> complex:
    """Root of s^2 (s^2 + 1) + n (1 - exp(-s T)) (psi (s^2 + 1) - (V / Omega) s^2) = 0 next to a guess [1/s].

    In units of sqrt(I / C) and 2 C / (eps a^2): the linear equations, with the delay T = 2 pi / (n Omega) that the
    rotation changes.
    """
    unit = math.sqrt(INERTIA / SPRING)
    psi, rate = AXIAL * INERTIA / (MASS * SPRING), DEPTH / math.tau * ENERGY * RADIUS**2 / (2.0 * SPRING)
    delay, s = math.tau / (BLADES * speed * unit), guess * unit

    def value(s: complex) -> complex:
        cut = BLADES * (1.0 - np.exp(-s * delay))
        return complex(s * s * (s * s + 1.0) + cut * (psi * (s * s + 1.0) - rate * s * s))

    for _ in range(60):
        s -= value(s) * 2e-6 / (value(s + 1e-6) - value(s - 1e-6))
    return s / unit


@case(share=(0.95, 1.05))
def growth(share: float) -> Iterator[Row]:
    """A sharp bit 5 % below and above the limit: the motion after a small kick, and the modes without simulation.

    A blade spacing takes 256 steps; the modes use 40 Chebyshev points over the delay.
    """
    speed = share * LIMIT
    delay = math.tau / (BLADES * speed)
    exact = characteristic_root(speed, 0.01 + 1j * math.pi / delay)
    twin, command = drilling(0.0, speed, delay / 256, 1e-3)
    places = []
    for _ in range(280):
        twin.advance(command, delay / 8)
        places.append(twin.unknowns[0][0, 2] + twin.time * speed * DEPTH / math.tau)
    seen = np.diff(places[48:])  # without the offset
    simulated = min(rates(1e6 * seen, delay / 8, order=12), key=lambda s: abs(s - exact))
    found = modes(EquationsOfMotion(twin.scene), command).modes
    linear = min((mode.eigenvalue for mode in found), key=lambda s: abs(s - exact))
    formula = "s^2 (s^2 + 1) + n (1 - exp(-s T)) (psi (s^2 + 1) - s^2 V / Omega) = 0"
    source = f"{RICHARD}, equations of motion"
    for how, s, tolerance in (("of the motion", simulated, 1e-3), ("of the mode", linear, 1e-6)):
        yield Row(f"growth {how} [1/s]", formula, source, exact.real, float(s.real), tolerance)
        yield Row(f"frequency {how} [rad/s]", formula, source, exact.imag, float(s.imag), tolerance)


@case()
def limit() -> Iterator[Row]:
    """Speed at which the mode of a bit too heavy to twist neither grows nor decays.

    Half a vibration fits between two blades there. The inertia of 1e8 kg m2 leaves a twist of some 1e-6.
    """
    low, high = 0.9 * LIMIT, 1.1 * LIMIT
    equations = EquationsOfMotion(scene(0.0, LIMIT, 1e-3, inertia=1e8))
    for _ in range(24):
        speed = 0.5 * (low + high)
        table = modes(equations, Command(AXIAL * DEPTH, speed)).modes
        chatter = min(table, key=lambda mode: abs(mode.eigenvalue - 0.5j * BLADES * LIMIT))
        low, high = (speed, high) if chatter.growth > 0.0 else (low, speed)
    yield Row("limit of stability [rad/s]", "(2 / n) sqrt(2 n zeta eps a / M), or 2 sqrt(2 psi / n) sqrt(C / I)",
              f"{RICHARD}, equation of the axial motion", LIMIT, low, 1e-5)  # fmt: skip


@case(regeneration=(True, False))
def steady_drilling(regeneration: bool) -> Iterator[Row]:
    """A blunt bit at 20 rad/s, above the limit: weight, rate of penetration and torque lie on the friction line.

    Mean of a second after ten; the regularisations of the wear flats take less than 1e-6.
    """
    worn, speed = 8e3, 20.0
    twin, command = drilling(worn, speed, 1e-3, 0.0, regeneration=regeneration)
    for _ in range(10):
        twin.advance(command, 1.0)
    begun = drilled(twin)
    rig = twin.advance(command, 1.0).rig
    source = "Detournay and Defourny 1992"
    yield Row("weight on bit [N]", "zeta eps a d + Wf", source, AXIAL * DEPTH + worn, rig.bit_force, 1e-5)
    yield Row("torque of the rock [N m]", "a / 2 (eps a d + mu gamma Wf)", source,
              -(TURNING * DEPTH + 0.5 * FRICTION * RADIUS * worn), rig.bit_torque, 1e-4)  # fmt: skip
    yield Row("rate of penetration [m/s]", "Omega d / (2 pi)", source, speed * DEPTH / math.tau,
              drilled(twin) - begun, 1e-3)  # fmt: skip


def switched(worn: float, speed: float, seconds: float, step: float) -> Array:
    """Speed of the bit after each step of an integration with switches for axial and torsional sticking [rad/s].

    Semi-implicit Euler steps of the two equations, the delay found in the recorded path: no mesh, no regularisation,
    no surface in cells.
    """
    weight, spacing, rate = AXIAL * DEPTH + worn, math.tau / BLADES, DEPTH / math.tau
    arm = 0.5 * FRICTION * RADIUS
    twist = (TURNING * DEPTH + arm * worn) / SPRING
    depths, angles, passed = [0.0], [0.0], 0
    depth, fall, angle, turn = 0.0, 1.01 * speed * rate, 0.0, speed
    found = np.empty(round(seconds / step))
    for k in range(found.size):
        before = angle - spacing
        surface = before * rate
        if before > 0.0:
            while angles[passed + 1] < before:
                passed += 1
            share = (before - angles[passed]) / (angles[passed + 1] - angles[passed])
            surface = depths[passed] + share * (depths[passed + 1] - depths[passed])
        cut = BLADES * max(depth - surface, 0.0)
        free, most = weight - AXIAL * cut, worn if cut > 0.0 else 0.0
        friction = most if fall > 0.0 or (fall == 0.0 and free > most) else 0.0
        held = 0.0 <= free <= most
        moved = fall + step * (free - friction) / MASS
        if held and (fall == 0.0 or moved * fall < 0.0):
            moved, friction = 0.0, free
        torque = TURNING * cut + arm * friction
        spring = SPRING * (twist + speed * k * step - angle)
        turn = max(turn + step * (spring - torque) / INERTIA, 0.0)
        fall = moved
        depth, angle = depth + step * fall, angle + step * turn
        if turn > 0.0:
            depths.append(depth)
            angles.append(angle)
        else:
            depths[-1] = depth
        found[k] = turn
    return found


def cycle_of(turn: Array, interval: float) -> tuple[float, float, float]:
    """Period [s], peak speed [rad/s] and share of time stuck of a stick-slip motion."""
    loose = np.flatnonzero((turn[:-1] < 0.5) & (turn[1:] >= 0.5))
    return float(np.diff(loose).mean()) * interval, float(turn.max()), float(np.mean(turn < 0.02))


@case()
def cycle() -> Iterator[Row]:
    """A blunt bit at 6 rad/s, far below the limit: its axial vibration drives it into a stick-slip cycle.

    Means over the second half of 60 s, in frames of 10 ms; the axial vibration is irregular, so both scatter.
    """
    worn, speed, late = 8e3, 6.0, 30.0
    exact = cycle_of(switched(worn, speed, 60.0, 2e-4)[round(late / 2e-4) :], 2e-4)
    twin, command = drilling(worn, speed, 1e-3, 0.01)
    turn = np.array([twin.advance(command, 0.01).rig.bit_speed for _ in range(6000)])
    found = cycle_of(turn[round(late / 0.01) :], 0.01)
    for what, tolerance, reference, computed in zip(
        ("period [s]", "peak speed of the bit [rad/s]", "share of time stuck [-]"), (5e-3, 1e-2, 0.1), exact, found,
        strict=True,
    ):  # fmt: skip
        yield Row(what, "two equations with a delay that depends on the rotation", f"{RICHARD}, integrated with "
                  "switches for sticking", reference, computed, tolerance)  # fmt: skip
