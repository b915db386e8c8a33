# SPDX-License-Identifier: Apache-2.0
"""Bit-rock interaction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.compile.jit import as_python
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import bit_torque_tanh
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import drilled, rod_scene, steel
from drill_twin_evidence.verify.signals import run_for

RPM_100 = 100.0 * np.pi / 30.0
A1, A2, A3, A4, A5, E = 3.429e-3, 5.672e-8, 1.374e-4, 9.537e6, 1.475e3, 2.0
RITTO = "Ritto, Soize and Sampaio 2009"


@case(at=("bit", "top"))
def rate_of_penetration(at: str) -> Iterator[Row]:
    """100 kN at 100 r/min on a short steel pipe, with the load given at the bit, or at the top with rock stiffness.

    Steady state; the tolerance covers the residual transient.
    """
    law = {"rock_stiffness": 1e8} if at == "top" else {}
    twin = Twin(steel({"bit_cutting": law}, at=at, weight_on_bit=100e3))
    command = Command(100e3, RPM_100)
    for seconds in (0.2, 1.0):
        twin.advance(command, seconds)
    before = drilled(twin)
    rig = twin.advance(command, 0.5).rig
    z = RPM_100 / np.hypot(RPM_100, E)
    rate = z**2 * (A2 * 100e3 - A1) + z * A3 * RPM_100
    yield Row("rate of penetration [m/s]", "Z^2 (a2 W - a1) + Z a3 w, Z = w / sqrt(w^2 + e^2)", RITTO, float(rate),
              (drilled(twin) - before) / 0.5, 1e-4)  # fmt: skip
    yield Row("torque on the bit [N m]", "a4 Z^2 x / w + a5 Z", RITTO, float(rate * A4 * z**2 / RPM_100 + A5 * z),
              -rig.bit_torque, 1e-4)  # fmt: skip
    yield Row("weight on the bit [N]", "W", "balance", 100e3, rig.bit_force, 1e-4)


@case()
def smooth_torque_law() -> Iterator[Row]:
    """The curve of the regularised law T = 0.0239 W (tanh(1.91 w) + 8.5 w / (1 + 5.47 w^2)), per newton.

    Extrema are found on a grid of 1 mrad/s; the published numbers have three digits.
    """
    law = bit_torque_tanh.Parameters(**dict(bit_torque_tanh.BitTorqueTanh()))
    speeds = np.linspace(0.0, 5.0, 5001)
    torque, slope = np.array([as_python(bit_torque_tanh.torque)(law, 1.0, float(w)) for w in speeds]).T
    for what, exact, found, tolerance in (
        ("peak [m]", 0.0608, torque.max(), 1e-4),
        ("speed of the peak [rad/s]", 0.542, speeds[torque.argmax()], 1e-3),
        ("steepest fall [m s/rad]", -0.0181, slope.min(), 1e-4),
        ("speed of the steepest fall [rad/s]", 0.918, speeds[slope.argmin()], 1e-3),
        ("asymptote [m]", 0.0239, as_python(bit_torque_tanh.torque)(law, 1.0, 1e6)[0], 1e-4),
    ):
        yield Row(what, "0.0239 W (tanh(1.91 w) + 8.5 w / (1 + 5.47 w^2))", "Real, Ritto and others 2018", exact,
                  float(found), tolerance, relative=False)  # fmt: skip


@case()
def friction_torque() -> Iterator[Row]:
    """Friction torque of the bit at a given radius and a steady speed.

    Steady state; the tolerance covers the residual transient.
    """
    losses = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}
    effects = {"bit_friction": {"coefficient": 0.4, "radius": 0.02}, "internal_damping": losses}
    twin = run_for(rod_scene(effects=effects, bit_end="sliding", weight_on_bit=2.0), 3.0, rotation=10.0)
    rig = twin.advance(Command(weight_on_bit=2.0, rotation=10.0), 0.05).rig
    yield Row("torque of the drive [N m]", "mu W r", "Coulomb 1785", 0.4 * 2.0 * 0.02, rig.top_drive_torque, 1e-3)
    yield Row("torque on the bit [N m]", "-mu W r", "Coulomb 1785", -0.4 * 2.0 * 0.02, rig.bit_torque, 1e-3)
