# SPDX-License-Identifier: Apache-2.0
"""Rotor dynamics: internal damping, imbalance, bow, and lateral excitation of the top."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, SPATIAL, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import EI, FIRST, LENGTH, LINE_MASS, quiet_scene
from drill_twin_evidence.verify.signals import first_mode, rates, rotating_frame_response

OFFSET, ANGLE, DRAG = 1e-3, -0.4, 0.25
BOW, BOW_ANGLE, BOW_DRAG = 4e-3, 0.6, 0.4
SHAKE, DIRECTION = 1e-3, 0.7
LOSSES = {"bending_time": 1e-3, "stretch_time": 2e-3, "torsion_time": 2e-3}
GENTA = "Genta 2005, ch. 3"
BEAM = "beam equation"


@case(forms=FORMS, turning=(0.0, 0.5, 2.5, 3.0, 4.0))
def whirl_driven_by_internal_damping(turning: float, form: str) -> Iterator[Row]:
    """Rate and frequency of forward and backward whirl of the first mode, rotating at multiples of its frequency.

    With external damping twice the internal one (c_i = EI eta beta^4 per length) forward whirl is unstable above three
    times the frequency. Rates are relative to (c_e + c_i) / 2 m; the error is that of the step of 2 ms.
    """
    retardation = 0.02 / FIRST
    inner = LINE_MASS * FIRST**2 * retardation
    outer, speed = 2.0 * inner, turning * FIRST
    exact = np.roots([LINE_MASS, outer + inner, LINE_MASS * FIRST**2 - 1j * inner * speed])
    effects = {"internal_damping": {"bending_time": retardation}, "drag": {"linear": outer}}
    twin = Twin(quiet_scene(effects, form=form, step=2e-3, elements=16))
    u, v = twin.unknowns
    shape, slope = first_mode(twin.rod.arc)
    u[:, 0], u[:, 3], v[:, 6] = 1e-6 * shape, 1e-6 * slope, speed
    command = Command(weight_on_bit=0.0, rotation=speed)
    places = np.array([complex(*twin.advance(command, 0.02).marks.centre[0, :2]) for _ in range(200)])[10:]
    found = sorted(rates(places, 0.02), key=lambda rate: rate.imag)
    scale = (outer + inner) / (2.0 * LINE_MASS)
    formula = "m s^2 + (c_e + c_i) s + k - i c_i Omega = 0"
    pairs = zip(("backward", "forward"), found, sorted(exact, key=lambda root: root.imag), strict=True)
    for sense, rate, root in pairs:
        yield Row(f"growth of {sense} whirl, of (c_e + c_i) / 2 m [-]", formula, GENTA, float(root.real / scale),
                  float(rate.real / scale), 1e-3, relative=False)  # fmt: skip
        yield Row(f"frequency of {sense} whirl [rad/s]", formula, GENTA, float(root.imag), float(rate.imag), 1e-4)


@case(forms=FORMS, share=(0.5, 1.0, 2.0))
def imbalance_through_resonance(share: float, form: str) -> Iterator[Row]:
    """Unbalance response below, at and above the first critical speed: amplitude, phase lag, torque of the drive.

    Internal damping is on and has no effect, because the strains are constant. 16 elements and a step of 4 ms.
    """
    speed = share * FIRST
    place, torque = imbalance(speed)
    effects = {
        "drag": {"linear": DRAG},
        "eccentricity": {"offset": OFFSET, "angle": ANGLE},
        "internal_damping": LOSSES,
    }
    scene = quiet_scene(effects, form=form, step=4e-3, elements=16)
    seen, scatter, given = rotating_frame_response(scene, speed, seconds=25.0)
    formula = "EI z'''' - (m Omega^2 - i c Omega) z = m Omega^2 e between clamps"
    yield from _response(formula, f"{GENTA}; {BEAM}", place, seen, scatter)
    if form == SPATIAL:
        yield Row("torque of the drive [N m]", "c Omega int |z|^2 ds", "balance", torque, given, 2e-3)


def _response(formula: str, source: str, exact: complex, seen: complex, scatter: float) -> Iterator[Row]:
    """Rows of amplitude, phase and scatter."""
    yield Row("amplitude at mid-span [m]", formula, source, abs(exact), abs(seen), 1e-3)
    yield Row("phase error [rad]", formula, source, 0.0, float(np.angle(seen / exact)), 1e-3, relative=False)
    yield Row("scatter, of the amplitude [-]", "0", "steady motion", 0.0, scatter / abs(exact), 1e-3, relative=False)


def imbalance(speed: float) -> tuple[complex, float]:
    """Steady position of mid-span in the rotating frame [m] and the torque of the drive [N m].

    cos and cosh of a complex beta s and a constant, which satisfy the clamped ends.
    """
    mass, square = LINE_MASS * speed**2, LINE_MASS * speed**2 - 1j * DRAG * speed
    beta = (square / EI) ** 0.25
    flat, half = -mass * OFFSET * np.exp(1j * ANGLE) / square, beta * LENGTH / 2.0
    c1, c2 = np.linalg.solve([[np.cos(half), np.cosh(half)], [-np.sin(half), np.sinh(half)]], [-flat, 0.0])
    arc = np.linspace(-LENGTH / 2.0, LENGTH / 2.0, 2001)
    shape = c1 * np.cos(beta * arc) + c2 * np.cosh(beta * arc) + flat
    return complex(shape[1000]), float(DRAG * speed * np.mean(np.abs(shape) ** 2) * LENGTH)


@case(forms=FORMS, share=(0.05, 0.8))
def bow(share: float, form: str) -> Iterator[Row]:
    """Response to a half-wave bow that rotates with the string: A (1 - pi / 4) at low speed, amplified near the
    critical speed.

    16 elements and a step of 4 ms.
    """
    speed = share * FIRST
    square = LINE_MASS * speed**2 - 1j * BOW_DRAG * speed
    beta, wave = (square / EI) ** 0.25, np.pi / LENGTH
    own = BOW * wave**4 / (wave**4 - beta**4)
    half = beta * LENGTH / 2.0
    c1, c2 = np.linalg.solve(
        [[np.cos(half), np.cosh(half)], [-beta * np.sin(half), beta * np.sinh(half)]], [0.0, own * wave]
    )
    effects = {
        "bow": {"amplitude": BOW, "angle": BOW_ANGLE},
        "drag": {"linear": BOW_DRAG},
        "internal_damping": LOSSES | {"bending_time": 0.02},
    }
    seen, scatter, _ = rotating_frame_response(
        quiet_scene(effects, form=form, step=4e-3, elements=16), speed, seconds=20.0
    )
    exact = complex((c1 + c2 + own) * np.exp(1j * BOW_ANGLE))
    yield from _response("EI (z - z_0)'''' = (m Omega^2 - i c Omega) z between clamps", BEAM, exact, seen, scatter)


@case(forms=FORMS, hertz=(0.5, 0.85, 3.0))
def shaken_top(hertz: float, form: str) -> Iterator[Row]:
    """Steady response of the rotating string to a harmonic lateral motion of the top, below, at and above resonance.

    24 elements and a step of 2 ms; the response is fitted over whole periods.
    """
    shake = {"amplitude": SHAKE, "frequency": hertz, "direction": DIRECTION}
    effects = {"drag": {"linear": BOW_DRAG}, "internal_damping": LOSSES | {"bending_time": 0.0}, "top_shake": shake}
    twin = Twin(quiet_scene(effects, form=form, step=2e-3))
    rows = []
    for _ in range(1000):
        place = complex(*twin.advance(Command(weight_on_bit=0.0, rotation=3.0), 0.02).marks.centre[0, :2])
        rows.append((twin.time, place * np.exp(-1j * DIRECTION)))
    when, places = (np.array(column) for column in zip(*rows, strict=True))
    late = when.real > 16.0
    angle = math.tau * hertz * when[late].real
    fit = np.linalg.lstsq(np.stack([np.sin(angle), np.cos(angle)], -1), places[late].real, rcond=None)[0]
    exact, found = _shaken(hertz), complex(*fit)
    formula = "EI z'''' = (m w^2 - i c w) z, clamped at the bit, moved at the top"
    yield Row("amplitude at mid-span [m]", formula, BEAM, abs(exact), abs(found), 1e-3)
    yield Row("phase error [rad]", formula, BEAM, 0.0, float(np.angle(found / exact)), 1e-3, relative=False)
    yield Row("motion aside, of the amplitude of the top [-]", "0", "symmetry", 0.0,
              float(np.abs(places.imag).max()) / SHAKE, 1e-4, relative=False)  # fmt: skip


def _shaken(hertz: float) -> complex:
    """Complex amplitude of mid-span [m]: a combination of cos, sin, cosh and sinh of a complex beta s."""
    omega = math.tau * hertz
    beta = ((LINE_MASS * omega**2 - 1j * BOW_DRAG * omega) / EI) ** 0.25

    def value(arc: float) -> Array:
        return np.array([np.cos(beta * arc), np.sin(beta * arc), np.cosh(beta * arc), np.sinh(beta * arc)])

    def slope(arc: float) -> Array:
        return np.array([-np.sin(beta * arc), np.cos(beta * arc), np.sinh(beta * arc), np.cosh(beta * arc)])

    ends = [value(0.0), slope(0.0), value(LENGTH), slope(LENGTH)]
    return complex(value(LENGTH / 2.0) @ np.linalg.solve(ends, [0.0, 0.0, SHAKE, 0.0]))
