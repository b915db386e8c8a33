# SPDX-License-Identifier: Apache-2.0
"""Damping, drag and mud."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import (
    AREA,
    DENSITY,
    DIAMETER,
    FIRST,
    GJ,
    LENGTH,
    LINE_MASS,
    SHEAR,
    YOUNG,
    quiet_scene,
)  # fmt: skip
from drill_twin_evidence.verify.signals import AT_REST, first_mode, rates

SPEEDS = {"stretch": float(np.sqrt(YOUNG / DENSITY)), "torsion": float(np.sqrt(SHEAR / DENSITY))}
HOLE, VISCOSITY, OUTER = 0.03, 0.5, DIAMETER / 2
COUETTE = 4.0 * np.pi * VISCOSITY * OUTER**2 * HOLE**2 / (HOLE**2 - OUTER**2)
MUD = {"density": 1200.0, "viscosity": VISCOSITY}
SOFT = ({"youngs_modulus": 1e3},)  # waves take more than two seconds from an end to mid-span
RAYLEIGH, COUETTE_FLOW = "Rayleigh 1877, ch. III", "Bird, Stewart and Lightfoot 2002, ex. 3.6-3"


@case(forms=FORMS)
def linear_drag(form: str) -> Iterator[Row]:
    """Decay of the first mode of the clamped-clamped rod by drag alone.

    Rates are identified from a fit of two exponentials; the step of 2 ms adds (omega dt)^2 / 12 = 1e-5.
    """
    drag = 0.3
    twin = Twin(quiet_scene({"drag": {"linear": drag}}, form=form, step=2e-3))
    u, arc = twin.unknowns[0], twin.rod.arc
    shape, slope = first_mode(arc)
    u[:, 0], u[:, 3] = 1e-6 * shape, 1e-6 * slope
    middle = np.array([twin.advance(AT_REST, 0.02).marks.centre[0, 0] for _ in range(200)])
    found = rates(middle, 0.02)[0]
    decay = drag / (2.0 * LINE_MASS)
    yield Row("decay [1/s]", "c / 2 m", RAYLEIGH, decay, -float(found.real), 1e-3)
    yield Row("frequency [rad/s]", "sqrt(omega^2 - (c / 2 m)^2)", RAYLEIGH, float(np.sqrt(FIRST**2 - decay**2)),
              abs(float(found.imag)), 1e-4)  # fmt: skip


@case(kind=tuple(SPEEDS), mode=(1, 3), ratio=(0.02, 0.3))
def kelvin_voigt(kind: str, mode: int, ratio: float) -> Iterator[Row]:
    """Decay of axial and torsional modes of the rod by internal damping, at 2 and 30 % of critical damping.

    omega dt = 1/20: (omega dt)^2 / 12 = 2e-4; in the third mode the 24 elements add as much.
    """
    wave = (mode - 0.5) * np.pi / LENGTH
    omega = wave * SPEEDS[kind]
    step = 0.05 / omega
    effects = {"internal_damping": {"bending_time": 0.0, f"{kind}_time": 2.0 * ratio / omega}}
    twin = Twin(quiet_scene(effects, step=step))
    _, v = twin.unknowns
    column = 2 if kind == "stretch" else 6
    v[:, column] = 1e-6 * np.cos(wave * twin.rod.arc)
    if kind == "stretch":
        v[:, 5] = -1e-6 * wave * np.sin(wave * twin.rod.arc)
    speeds = []
    for _ in range(120):
        twin.advance(AT_REST, 3.0 * step)
        speeds.append(v[0, column])
    found = rates(np.array(speeds), 3.0 * step)[0]
    yield Row("decay [1/s]", "zeta omega, zeta = eta omega / 2, omega = (n - 1/2) pi c / L", RAYLEIGH,
              ratio * omega, -float(found.real), 2e-3)  # fmt: skip
    yield Row("frequency [rad/s]", "omega sqrt(1 - zeta^2)", RAYLEIGH, omega * float(np.sqrt(1.0 - ratio**2)),
              abs(float(found.imag)), 1e-3)  # fmt: skip


@case(forms=FORMS)
def quadratic_drag(form: str) -> Iterator[Row]:
    """Deceleration by quadratic drag of a rod so soft that its slices move independently, at mid-length.

    48 elements: the rate differs along the rod, and the error of the mesh is of second order, 5e-4.
    """
    density, coefficient, speed = 1000.0, 1.1, 0.1
    effects = {
        "mud": {"density": density},
        "quadratic_drag": {"coefficient": coefficient},
        "lateral_kick": {"velocity": speed, "shape": "half_wave"},
    }
    twin = Twin(quiet_scene(effects, form=form, sections=SOFT, step=2e-3, elements=48))
    factor = coefficient * density * OUTER
    for _ in range(25):
        frame = twin.advance(AT_REST, 0.02)
    yield Row("speed after 0.5 s [m/s]", "v_0 / (1 + k v_0 t / m), k = C_d rho r_o", "Morison and others 1950",
              speed / (1.0 + factor * speed * twin.time / LINE_MASS), float(frame.marks.velocity[0, 0]), 5e-4,
              )  # fmt: skip


@case(forms=FORMS)
def sinking_in_mud(form: str) -> Iterator[Row]:
    """Fall of the same soft rod across a level hole filled with mud: weight, buoyancy, added mass and drag together.

    The motion is uniform along the middle, so only the error of the step remains: 1e-4.
    """
    density = 900.0
    effects = {
        "gravity": {"magnitude": 9.81},
        "mud": {"density": density},
        "quadratic_drag": {"coefficient": 1.0},
        "added_mass": {"coefficient": 1.0},
    }
    twin = Twin(quiet_scene(effects, form=form, sections=SOFT, step=2e-3, inclination=np.pi / 2))
    factor = density * OUTER
    terminal = np.sqrt((LINE_MASS - density * AREA) * 9.81 / factor)
    settling = (LINE_MASS + density * AREA) / (factor * terminal)
    for frames in (10, 30):
        for _ in range(frames):
            frame = twin.advance(AT_REST, 0.02)
        yield Row(f"speed after {twin.time:.1f} s [m/s]",
                  "v_t tanh(t / T), v_t = sqrt((m - rho A) g / k), T = (m + m_a) / (k v_t)", "Lamb 1932, art. 68",
                  float(terminal * np.tanh(twin.time / settling)), float(frame.marks.velocity[0, 0]), 1e-4,
                  )  # fmt: skip


@case(forms=FORMS)
def torque_of_turning(form: str) -> Iterator[Row]:
    """Torque of the drive at steady speed, against rotary drag and viscous mud.

    Steady state; the tolerance covers the residual transient.
    """
    effects = {"drag": {"linear": 0.0, "rotary": 1e-3}, "internal_damping": {"bending_time": 0.0, "torsion_time": 2e-3}}
    for speed in (20.0, -20.0):
        for what, more, radius, torque, formula, source in (
            ("rotary drag", effects, 5.0, 1e-3, "c_r Omega L", "balance"),
            ("mud", effects | {"drag": {"linear": 0.0}, "mud": MUD}, HOLE, COUETTE,
             "4 pi mu Omega r^2 R^2 / (R^2 - r^2) L", COUETTE_FLOW),
        ):  # fmt: skip
            twin = Twin(quiet_scene(more, form=form, radius=radius, step=0.01))
            for _ in range(60):
                frame = twin.advance(Command(weight_on_bit=0.0, rotation=speed), 0.05)
            yield Row(f"torque against {what} at {speed:g} rad/s [N m]", formula, source, torque * speed * LENGTH,
                      frame.rig.top_drive_torque, 1e-3)  # fmt: skip


@case()
def twist_in_mud() -> Iterator[Row]:
    """Decay of the first torsional mode in viscous mud.

    omega dt = 1/27: 1e-4.
    """
    twin = Twin(quiet_scene({"mud": MUD}, radius=HOLE, step=1e-4))
    _, v = twin.unknowns
    wave, polar = np.pi / (2.0 * LENGTH), np.pi / 32 * DIAMETER**4
    v[:, 6] = 1e-3 * np.cos(wave * twin.rod.arc)
    speeds = [twin.advance(AT_REST, 4e-4).rig.bit_speed for _ in range(200)]
    found, decay = rates(np.array(speeds), 4e-4)[0], COUETTE / (2.0 * DENSITY * polar)
    yield Row("decay [1/s]", "c / 2 rho J, c = 4 pi mu r^2 R^2 / (R^2 - r^2)", COUETTE_FLOW, decay,
              -float(found.real), 1e-3)  # fmt: skip
    exact = float(np.sqrt(wave**2 * GJ / (DENSITY * polar) - decay**2))
    yield Row("frequency [rad/s]", "sqrt(omega^2 - decay^2)", RAYLEIGH, exact, abs(float(found.imag)), 1e-3)
