# SPDX-License-Identifier: Apache-2.0
"""Damped modes without simulation in time (`drill-twin modes`) against exact eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.optimize import brentq

from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import AXIAL, LATERAL, TORSIONAL, Mode, modes
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, SPATIAL, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import (
    DENSITY,
    EI,
    FIRST,
    GJ,
    LENGTH,
    LINE_MASS,
    SHEAR,
    WALLED,
    YOUNG,
    quiet_scene,
)

SET: dict[str, dict[str, Any]] = {**WALLED, "bit_friction": {"coefficient": 0.0, "radius": 5.5e-3}}
"""The effects of pa6_bench, each at zero."""
LATERAL_FORM = FORMS[1]
BEAM = "Blevins 1979, table 8-1"


def modes_at(effects: dict[str, Any], form: str, *, load: float = 0.0, speed: float = 1.0, **scene: Any) -> list[Mode]:
    """Modes of the rod with 24 elements, turning under a load [N]."""
    equations = EquationsOfMotion(quiet_scene(effects, of=SET, form=form, **scene))
    return list(modes(equations, Command(load, speed), count=20).modes)


def loaded_frequency(load: float, order: int) -> float:
    """Natural frequency of a beam between clamps under compression [rad/s]; order from 1.

    2 p q (1 - cos qL cosh pL) + (p^2 - q^2) sin qL sinh pL = 0 with q^2, p^2 = sqrt(b^2 + m omega^2 / EI) +- b,
    b = load / 2 EI, scaled by cosh pL (Bokaian 1988, Journal of Sound and Vibration 126, Eq. 10).
    """
    b = 0.5 * load / EI

    def characteristic(omega: float) -> float:
        root = math.sqrt(b * b + LINE_MASS * omega * omega / EI)
        p, q = math.sqrt(max(root - b, 0.0)), math.sqrt(root + b)
        decay = 1.0 / math.cosh(p * LENGTH)
        slope = (p * p - q * q) * math.sin(q * LENGTH) * math.tanh(p * LENGTH)
        return 2.0 * p * q * (decay - math.cos(q * LENGTH)) + slope

    grid = np.linspace(1e-3, 12.0, 4000) * FIRST
    signs = np.array([characteristic(omega) for omega in grid])
    changes = np.flatnonzero(signs[:-1] * signs[1:] < 0.0)
    at = changes[order - 1]
    return float(brentq(characteristic, grid[at], grid[at + 1], xtol=1e-13))


@case(forms=FORMS, share=(-1.0, 0.0, 0.8), long=True)
def beam_under_axial_load(share: float, form: str) -> Iterator[Row]:
    """Frequencies of a beam between clamps under a share of its buckling load, by eigenvalues.

    In space the load also shortens the rod, by up to 4e-5 of its length. 24 cubic elements: (k h)^4 / 1440 is 1e-5 for
    the third mode.
    """
    load = share * 4.0 * math.pi**2 * EI / LENGTH**2
    found = sorted(mode.eigenvalue.imag for mode in modes_at({}, form, load=load, bit_end="guided")
                   if mode.kind == LATERAL and mode.eigenvalue.imag > 0.0)  # fmt: skip
    for order in (1, 2, 3):
        yield Row(f"frequency of mode {order} [rad/s]", "2pq (1 - cos qL cosh pL) + (p2 - q2) sin qL sinh pL = 0",
                  "Bokaian 1988, Eq. 10", loaded_frequency(load, order), found[order - 1], 2e-4)  # fmt: skip


@case(forms=(LATERAL_FORM,), turning=(0.0, 2.5, 3.0, 4.0))
def eigenvalues_with_internal_damping(turning: float, form: str) -> Iterator[Row]:
    """Growth and frequency of the first mode with internal and external damping, at multiples of its frequency.

    External damping is twice the internal one, so forward whirl is unstable above three times the frequency. Growth is
    relative to (c_e + c_i) / 2 m.
    """
    retardation = 0.02 / FIRST
    inner = LINE_MASS * FIRST**2 * retardation
    outer, speed = 2.0 * inner, turning * FIRST
    exact = np.roots([LINE_MASS, outer + inner, LINE_MASS * FIRST**2 - 1j * inner * speed])
    effects = {"internal_damping": {"bending_time": retardation}, "drag": {"linear": outer}}
    found = [mode.eigenvalue for mode in modes_at(effects, form, speed=speed, bit_end="guided") if mode.kind == LATERAL]
    scale = (outer + inner) / (2.0 * LINE_MASS)
    formula = "m s^2 + (c_e + c_i) s + k - i c_i Omega = 0"
    for root in exact:
        value = min(found, key=lambda one: abs(one - root))
        sense = "forward" if root.imag > 0.0 else "backward"
        yield Row(f"growth of {sense} whirl, of (c_e + c_i) / 2 m [-]", formula, "Genta 2005, ch. 3",
                  float(root.real / scale), value.real / scale, 1e-4, relative=False)  # fmt: skip
        yield Row(f"frequency of {sense} whirl [rad/s]", formula, "Genta 2005, ch. 3", float(root.imag), value.imag,
                  1e-4)  # fmt: skip


@case(forms=(SPATIAL,), long=True)
def torsional_and_axial_eigenvalues() -> Iterator[Row]:
    """Frequencies of twist and stretch of the rod fixed at the top and free at the bit, by eigenvalues.

    24 elements; the inertia of twist is of fourth order, stretch by cubic elements more.
    """
    found = modes_at({}, SPATIAL, bit_end="guided")
    for kind, wave, about in ((TORSIONAL, math.sqrt(SHEAR / DENSITY), "GJ psi'' = rho J psi_tt"),
                              (AXIAL, math.sqrt(YOUNG / DENSITY), "EA u'' = rho A u_tt")):  # fmt: skip
        own = sorted(mode.eigenvalue.imag for mode in found if mode.kind == kind)
        for order in (1, 2):
            exact = (order - 0.5) * math.pi * wave / LENGTH
            yield Row(f"{kind} frequency {order} [rad/s]", f"(k - 1/2) pi c / L, {about}", BEAM, exact, own[order - 1],
                      1e-4)  # fmt: skip


@case(forms=(SPATIAL,), share=(0.1, 0.5), long=True)
def onset_of_stick_slip(share: float) -> Iterator[Row]:
    """Growth of torsional vibration by a bit torque that falls with speed, a share of the string's impedance Z.

    tanh(s L / c) = -Z / d for the slope d of the torque by the speed: s L / c = ln((Z - d) / (Z + d)) / 2 + i pi / 2
    for the lowest, unstable for any falling torque (d < 0) of a string without losses.
    """
    speed, decay, weight, radius = 10.0, 0.2, 10.0, 0.01
    impedance = GJ * math.sqrt(DENSITY / SHEAR)
    excess = share * impedance / (weight * radius * decay * math.exp(-decay * speed))
    law = {"radius": radius, "sliding": 0.2, "sticking": 0.2 + excess, "decay": decay}
    effects = {"bit_torque_stribeck": law}
    scene = quiet_scene(effects, of={"gravity": {"magnitude": 0.0}}, bit_end="guided", weight_on_bit=weight)
    found = modes(EquationsOfMotion(scene), Command(weight, speed), count=20).of(TORSIONAL)
    travel = LENGTH * math.sqrt(DENSITY / SHEAR)
    exact = complex(0.5 * math.log((1.0 + share) / (1.0 - share)), 0.5 * math.pi) / travel
    value = min((mode.eigenvalue for mode in found), key=lambda one: abs(one - exact))
    formula = "tanh(s L / c) = -Z / d"
    yield Row("growth [1/s]", formula, "wave equation", exact.real, value.real, 1e-3)
    yield Row("frequency [rad/s]", formula, "wave equation", exact.imag, value.imag, 1e-3)


__all__ = ["loaded_frequency", "modes_at"]
