# SPDX-License-Identifier: Apache-2.0
"""Torsion: reflection at bit and top drive, the first mode of a well, buckling under torque."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DENSITY, EI, GJ, LENGTH, SHEAR, rod_scene
from drill_twin_evidence.verify.signals import AT_REST, rates, squared_frequencies

SPEED = float(np.sqrt(SHEAR / DENSITY))
IMPEDANCE = GJ / SPEED
IDLE: dict[str, Any] = {
    "internal_damping": {"bending_time": 0.0},
    "bit_torque_stribeck": {"radius": 0.1, "sliding": 0.5, "sticking": 0.8, "decay": 0.9},
}
"""Effects of the scene two_mass, so that no other kernel is compiled; without weight the bit torque is zero."""
TUNED = {"model": "impedance", "integral_gain": 0.0}
DRIVES: dict[str, tuple[dict[str, Any], float]] = {
    "held": ({"model": "prescribed"}, -1.0),
    "matched": (TUNED, 0.0),
    "stiffer": (TUNED | {"reflection": -0.5}, -0.5),
    "softer": (TUNED | {"reflection": 0.5}, 0.5),
}
"""Top drives and their reflection coefficients of speed."""
PIPE, COLLAR = (0.146529, 0.123024), (0.176768, 0.0714)
WELL_SHEAR, WELL_DENSITY, PIPE_LENGTH, COLLAR_LENGTH = 61e9, 7850.0, 2270.0, 230.0
WELL_SPEED = float(np.sqrt(WELL_SHEAR / WELL_DENSITY))
DRIVE_INERTIA = 2900.0
GAINS = {"stiff": (38e3, 100e3), "soft": (996.0, 300.0)}
LINES = "line equations; Aarsnes and Shor 2018 for the well"


@case(share=(0.0, 0.5, -0.5))
def reflection_at_the_bit(share: float) -> Iterator[Row]:
    """Reflection of a torsional pulse at a bit with a damper; zero where the impedances match.

    Dispersion of the pulse of 0.4 m over 100 elements: 3e-3.
    """
    damping = IMPEDANCE * (1.0 - share) / (1.0 + share)
    scene = rod_scene(effects=IDLE | {"bit_mass": {"damping": damping}}, elements=100, step=4e-5)
    yield _reflection(scene, share, down=True)


@case(drive=tuple(DRIVES))
def reflection_at_the_top(drive: str) -> Iterator[Row]:
    """Reflection of the same pulse at the top drive.

    Dispersion of the pulse of 0.4 m over 100 elements: 3e-3.
    """
    model, share = DRIVES[drive]
    scene = _with_rig(rod_scene(effects=IDLE | {"bit_mass": {}}, elements=100, step=4e-5), top_drive=model)
    yield _reflection(scene, share, down=False)


def _reflection(scene: Scene, share: float, *, down: bool) -> Row:
    """Row of the reflection coefficient of a pulse, by projection of the speed on the pulse that was sent."""
    twin = Twin(scene)
    u, v = twin.unknowns
    place = twin.rod.arc - 0.5 * LENGTH
    u[:, 6] = 1e-3 * np.exp(-((place / 0.4) ** 2))
    sent = u[:, 6] * SPEED * 2.0 * place / 0.4**2 * (-1.0 if down else 1.0)
    v[:, 6] = sent
    twin.advance(AT_REST, LENGTH / SPEED)
    back = float(-np.dot(twin.unknowns[1][:, 6], sent) / np.dot(sent, sent))
    return Row("speed that comes back, of that sent [-]", "(Z_0 - Z) / (Z_0 + Z), Z_0 = J sqrt(G rho)",
               "Graff 1975, ch. 2", share, back, 5e-3, relative=False)  # fmt: skip


@case(ratio=(0.3, 3.0))
def heavy_bit(ratio: float) -> Iterator[Row]:
    """First torsional frequency of the rod, held at the top, with a body at the bit.

    Error of 16 elements and a step of 0.1 ms: 1e-4.
    """
    inertia = GJ / SPEED**2 * LENGTH / ratio
    twin = Twin(rod_scene(effects=IDLE | {"bit_mass": {"inertia": inertia}}, elements=16, step=1e-4))
    twin.unknowns[1][:, 6] = np.cos(0.5 * np.pi * twin.rod.arc / LENGTH)
    motion = np.array([twin.advance(AT_REST, 5e-4).spin for _ in range(400)])
    wave = np.linspace(1e-3, 1.5, 200001)
    exact = wave[np.argmin(np.abs(wave * np.tan(wave) - ratio))] * SPEED / LENGTH
    yield Row("first frequency [rad/s]", "k L tan(k L) = J_string / J_bit", "Blevins 1979, table 8-19", float(exact),
              float(np.sqrt(squared_frequencies(motion, 5e-4, modes=4)[0])), 1e-3)  # fmt: skip


@case()
def well_off_bottom() -> Iterator[Row]:
    """First mode of a well of 2,270 m of pipe and 230 m of collars, held at the top.

    Error of 64 elements and a step of 5 ms: 1e-4. Published: 0.22 Hz; here all collars have one size.
    """
    exact, found = well_mode(lambda _: 1e12), _ringing({})
    yield Row("first frequency [rad/s]", "tan(k L_p) tan(k L_c) = J_p / J_c", LINES, exact.imag, found.imag, 1e-3)
    yield Row("decay [1/s]", "0", LINES, 0.0, found.real, 1e-3, relative=False)
    yield Row("first frequency [Hz], as published", "0.22 Hz", "Aarsnes and Shor 2018", 0.22, found.imag / 2.0 / np.pi,
              0.005, relative=False)  # fmt: skip


@case(drive=tuple(GAINS))
def well_with_a_top_drive(drive: str) -> Iterator[Row]:
    """The mode with 2,900 kg m2 and a speed controller at the top: stiff as published (38 kN m s/rad, 100 kN m/rad),
    and soft.

    The decay is identified from a fit of 24 exponentials.
    """
    proportional, integral = GAINS[drive]
    exact = well_mode(lambda s: s * DRIVE_INERTIA + proportional + integral / s)
    found = _ringing({
        "top_drive": {
            "model": "speed_controller", "inertia": DRIVE_INERTIA, "proportional_gain": proportional,
            "integral_gain": integral,
        }
    })  # fmt: skip
    formula = "impedances of two lines and of J s + P + I / s"
    yield Row("first frequency [rad/s]", formula, LINES, exact.imag, found.imag, 2e-3)
    yield Row("decay [1/s]", formula, LINES, -exact.real, -found.real, 0.03)


def _polar(tube: tuple[float, float]) -> float:
    return float(np.pi / 32.0 * (tube[0] ** 4 - tube[1] ** 4))


def _with_rig(scene: Scene, **parts: Any) -> Scene:
    """The scene with parts of its rig replaced."""
    data = scene.model_dump(exclude_none=True)
    data["rig"] |= parts
    return Scene.model_validate(data)


def _ringing(rig: dict[str, Any]) -> complex:
    """Complex rate of the least damped mode of the bit speed in the well [1/s]."""
    sections = [
        {"length": length, "outer_diameter": tube[0], "inner_diameter": tube[1],
         "youngs_modulus": 2.0 * 1.3 * WELL_SHEAR, "poisson_ratio": 0.3, "density": WELL_DENSITY}
        for length, tube in ((COLLAR_LENGTH, COLLAR), (PIPE_LENGTH, PIPE))
    ]  # fmt: skip
    effects = IDLE | {"bit_mass": {}}
    scene = rod_scene(effects=effects, sections=sections, elements=64, step=5e-3, radius=0.2, marks=())
    twin = Twin(_with_rig(scene, **rig))
    twin.unknowns[1][:, 6] = np.cos(0.5 * np.pi * twin.rod.arc / twin.rod.arc[-1])
    signal = np.array([twin.advance(AT_REST, 0.1).rig.bit_speed for _ in range(400)])
    found = rates(signal, 0.1, order=24)
    found = found[(found.imag > 0.5) & (found.imag < 2.5)]
    return complex(found[np.argmax(found.real)])


def well_mode(drive: Callable[[complex], complex]) -> complex:
    """Root s of the line equations: free bit, collars, pipe, and an impedance `drive(s)` at the top [1/s]."""
    low, high = (_polar(tube) * float(np.sqrt(WELL_SHEAR * WELL_DENSITY)) for tube in (COLLAR, PIPE))

    def miss(s: complex) -> complex:
        load = low * np.tanh(s * COLLAR_LENGTH / WELL_SPEED)
        along = np.tanh(s * PIPE_LENGTH / WELL_SPEED)
        return complex((high + load * along) / (high * (load + high * along)) + 1.0 / drive(s))

    s = 1j * math.tau * 0.2209 - 0.01
    for _ in range(50):
        s -= miss(s) * 1e-6 / (miss(s + 1e-6) - miss(s))
    return s


@case(share=(0.0, 0.5))
def torque_buckling(share: float) -> Iterator[Row]:
    """Critical torque of the clamped-clamped rod, without load and under half of Euler's load, where omega^2 is zero
    (without load 8.987 EI / L; Greenhill's 2 pi EI / L is for hinges).

    Linear interpolation between 99 % and 101 %, with 32 elements.
    """
    load = share * 4.0 * np.pi**2 * EI / LENGTH**2
    exact = critical_torque(load)
    below, above = (_twisted(part * exact, load) for part in (0.99, 1.01))
    if not below > 0.0 > above:
        raise ValueError(f"expected omega^2 to fall through zero, found {below:.6g} and {above:.6g} 1/s2")
    yield Row("critical torque [N m]", "EI w'''' - i T w''' + P w'' = 0, w = x + i y, and four conditions",
              "Greenhill 1883; Ziegler 1968 for clamps", exact, exact * (0.99 + 0.02 * below / (below - above)), 2e-3,
              )  # fmt: skip


def _twisted(torque: float, load: float) -> float:
    """Lowest omega^2 [1/s2] under a torque [N m] and a compression [N]; a large bit inertia maintains the twist."""
    effects = IDLE | {"bit_mass": {"inertia": 1e6}, "lateral_kick": {"velocity": 1e-6, "shape": "hump"}}
    twin = Twin(rod_scene(effects=effects, weight_on_bit=load, elements=32, step=2e-3))
    twin.unknowns[0][:, 6] = -torque / GJ * (LENGTH - twin.rod.arc)
    motion = np.array([twin.advance(Command(load, 0.0), 0.04).positions[:, 0] for _ in range(150)])
    return float(squared_frequencies(motion, 0.04, modes=6)[0])


def critical_torque(load: float) -> float:
    """Least torque [N m] at which a clamped rod under a compression [N] has a second equilibrium.

    w = A + B s + C exp(i a s) + D exp(i b s) with its four conditions at 0 and L: a determinant vanishes.
    """
    from scipy.optimize import brentq

    load = max(load, 1e-6 * EI / LENGTH**2)

    def determinant(torque: float) -> float:
        middle, half = torque / (2.0 * EI), np.sqrt((torque / (2.0 * EI)) ** 2 + load / EI)
        a, b = middle + half, middle - half
        ea, eb = np.exp(1j * a * LENGTH), np.exp(1j * b * LENGTH)
        matrix = np.array([
            [1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1j * a, 1j * b],
            [1.0, LENGTH, ea, eb], [0.0, 1.0, 1j * a * ea, 1j * b * eb],
        ])  # fmt: skip
        return float(np.imag(np.linalg.det(matrix) * np.exp(-1j * middle * LENGTH)))

    torques = np.linspace(0.05, 1.05, 401) * 2.0 * 4.493409458 * EI / LENGTH
    values = np.array([determinant(torque) for torque in torques])
    change = int(np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))[0])
    return float(brentq(determinant, torques[change], torques[change + 1]))
