# SPDX-License-Identifier: Apache-2.0
"""Bow, eccentricity and internal damping: what turns with the material."""

import numpy as np
import pytest
from scenes import EI, LENGTH, LINE_MASS, rod_scene

from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

FIRST = 4.730040745**2 / LENGTH**2 * np.sqrt(EI / LINE_MASS)  # first natural frequency between clamps [rad/s]
LOSSY = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}


def steady(effects: dict, speed: float, seconds: float) -> tuple[complex, float]:
    """Mid-span place seen by the turning string [m], averaged over the last second, and its scatter [m]."""
    twin = Twin(rod_scene(effects=effects | {"internal_damping": LOSSY}, step=2e-3))
    seen = []
    for k in range(round(seconds / 0.01)):
        speed_now = speed * min((k + 1) * 0.01, 1.0)
        marks = twin.step(Command(weight_on_bit=0.0, rotation=speed_now), 0.01).marks
        seen.append(complex(*marks.centre[0, :2]) * np.exp(-1j * marks.spin[0]))
    return complex(np.mean(seen[-100:])), float(np.std(seen[-100:]))


def test_bow_turns_with_the_string() -> None:
    """A half-wave bow between clamps stands off by A (1 - pi / 4) at mid-span, in the material's own direction."""
    effects = {"bow": {"amplitude": 4e-3, "angle": 0.6}, "drag": {"linear": 0.1}}
    seen, scatter = steady(effects, speed=0.3, seconds=30.0)
    assert seen == pytest.approx(4e-3 * (1.0 - np.pi / 4.0) * np.exp(0.6j), rel=0.02)
    assert scatter < 0.01 * abs(seen)


@pytest.mark.parametrize("share", [0.4, 0.7])
def test_unbalance_response_below_resonance(share: float) -> None:
    """EI y'''' - m Omega^2 (y + e) = 0 between clamps: y_mid / e = C_1 + C_2 - 1 in closed form."""
    offset = 1e-3
    speed = share * FIRST
    half = np.sqrt(speed / np.sqrt(EI / LINE_MASS)) * LENGTH / 2.0
    c1, c2 = np.linalg.solve([[np.cos(half), np.cosh(half)], [-np.sin(half), np.sinh(half)]], [1.0, 0.0])
    effects = {"eccentricity": {"offset": offset, "angle": -0.4}, "drag": {"linear": 0.2}}
    seen, scatter = steady(effects, speed, seconds=25.0)
    assert abs(seen) == pytest.approx(offset * (c1 + c2 - 1.0), rel=0.03)
    assert scatter < 0.01 * abs(seen)
    # drag turns the response behind the imbalance, by less than a right angle below resonance
    assert -0.5 * np.pi < np.angle(seen * np.exp(0.4j)) < 0.0


def growth(speed: float, retardation: float, drag: float) -> float:
    """Growth rate [1/s] of the first forward mode of the free-running rod."""
    effects = {
        "internal_damping": {"bending_time": retardation},
        "drag": {"linear": drag},
        "lateral_kick": {"velocity": 1e-6, "shape": "hump"},
    }
    twin = Twin(rod_scene(effects=effects, step=1e-3))
    twin.unknowns[1][:, 6] = speed
    rows = []
    for _ in range(600):
        frame = twin.step(Command(weight_on_bit=0.0, rotation=speed), 0.01)
        rows.append(complex(*frame.marks.centre[0, :2]))
    signal = np.array(rows)[200:]
    order = 8  # four modes, forward and backward: each sample is a fixed combination of the eight before it
    history = np.stack([signal[k : k - order] for k in range(order)], -1)
    roots = np.roots(np.append(1.0, -np.linalg.lstsq(history, signal[order:], rcond=1e-10)[0][::-1]))
    rates = np.log(roots) / 0.01
    return float(rates[np.argmin(np.abs(rates.imag - FIRST))].real)


@pytest.mark.parametrize("ratio", [0.5, 2.5, 4.0])
def test_internal_damping_threshold(ratio: float) -> None:
    """m z'' + (c_e + c_i) z' + (k - i c_i Omega) z = 0 (Genta 2005): the growth rate, not only its sign.

    c_i = EI eta beta^4 per length; with c_e = 2 c_i forward whirl sets in at three times the natural frequency.
    """
    omega = FIRST
    retardation = 0.01 / omega
    c_i = LINE_MASS * omega**2 * retardation
    drag = 2.0 * c_i
    speed = ratio * omega
    roots = np.roots([LINE_MASS, drag + c_i, LINE_MASS * omega**2 - 1j * c_i * speed])
    exact = roots[np.argmax(roots.imag)].real
    assert (exact > 0.0) == (ratio > 3.0)
    assert growth(speed, retardation, drag) == pytest.approx(exact, rel=0.03)
