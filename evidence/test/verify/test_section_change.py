# SPDX-License-Identifier: Apache-2.0
"""Waves at a change of section: part goes on, part comes back, by the ratio of the impedances.

A wave of velocity is reflected by (Z_1 - Z_2) / (Z_1 + Z_2) and goes on with 2 Z_1 / (Z_1 + Z_2) (Graff 1975, section
2.4); Z is A sqrt(E rho) along the string and J sqrt(G rho) about it. Tolerances are those of the ripple behind a front.
"""

import numpy as np
import pytest
from hole_scenes import ON_THE_WALL, with_parts

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.scenes import (
    AREA,
    DENSITY,
    DIAMETER,
    EA,
    LENGTH,
    LINE_MASS,
    POISSON,
    YOUNG,
    quiet_scene,
)

INTERVAL, SPAN = 2e-5, 5.0
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
POLAR = np.pi / 32.0 * DIAMETER**4


def stepped(elements: int, ratio: float) -> Twin:
    """Two spans of 5 m, the upper one thicker by a ratio of diameters."""
    sections = [{"length": SPAN}, {"length": SPAN, "outer_diameter": ratio * DIAMETER}]
    return Twin(with_parts(effects=ON_THE_WALL, elements=elements, step=INTERVAL, sections=sections, length=SPAN))


def echo(signal: np.ndarray, before: float, after: float, window: slice) -> float:
    """When a signal changed from one plateau to another [s], from its integral: a mesh smears a front."""
    time = INTERVAL * np.arange(1, signal.size + 1)
    return float(np.mean(((np.cumsum(signal) * INTERVAL - after * time) / (before - after))[window]))


@pytest.mark.parametrize("elements", [100, 200])
def test_axial_wave_at_a_change_of_section(elements: int) -> None:
    """One newton at the bit: its speed is 1 / Z_1, and (1 - 2 R) / Z_1 once the echo is back and doubled.

    The echo comes early by 3e-5 of its time at 100 elements.
    """
    ratio = 2.0
    twin = stepped(elements, ratio)
    frames = [twin.advance(Command(weight_on_bit=1.0, rotation=0.0), INTERVAL) for _ in range(640)]
    speed = np.array([frame.velocities[0, 2] for frame in frames]) * AREA * np.sqrt(YOUNG * DENSITY)
    reflected = (ratio**2 - 1.0) / (ratio**2 + 1.0)
    assert speed[100:300].mean() == pytest.approx(1.0, rel=2e-3)
    assert speed[425:625].mean() == pytest.approx(1.0 - 2.0 * reflected, abs=4e-3)
    there_and_back = 2.0 * SPAN * np.sqrt(DENSITY / YOUNG)
    seen = echo(speed, 1.0, 1.0 - 2.0 * reflected, slice(425, 625))
    assert seen == pytest.approx(there_and_back, rel=0.01 / elements)


def test_elongation_is_of_second_order() -> None:
    """A string whose upper half has four times the area, under its weight and a pull of 10 N; it starts in balance."""
    pull, half, line = 10.0, 0.5 * LENGTH, LINE_MASS * 9.81
    exact = (pull + 0.5 * line * half) * half / EA + (pull + line * half + 2.0 * line * half) * half / (4.0 * EA)
    effects = {"gravity": {"magnitude": 9.81}, "internal_damping": {"bending_time": 0.0, "stretch_time": 5e-3}}
    sections = [{"length": half}, {"length": half, "outer_diameter": 2.0 * DIAMETER}]
    errors = []
    for elements in (8, 16, 32):
        twin = Twin(quiet_scene(effects, weight_on_bit=-pull, step=1e-3, sections=sections, elements=elements))
        start = float(twin.unknowns[0][0, 2])
        for _ in range(30):
            frame = twin.advance(Command(weight_on_bit=-pull, rotation=0.0), 0.01)
        place = float(twin.unknowns[0][0, 2])
        assert place == pytest.approx(start, abs=1e-6 * exact)
        assert frame.rig.hookload == pytest.approx(pull + 5.0 * line * half, rel=1e-6)
        errors.append(1.0 - (-place - LENGTH) / exact)
    assert errors[0] < 6e-3
    assert np.log2(errors[:-1]) - np.log2(errors[1:]) == pytest.approx(2.0, abs=0.1)


def test_torsional_wave_at_a_change_of_section() -> None:
    """One radian per second at the top: 2 Z_2 / (Z_1 + Z_2) goes on and doubles at the bit; the rest brakes the top."""
    ratio = 2.0
    twin = stepped(100, ratio)
    frames = [twin.advance(Command(weight_on_bit=0.0, rotation=1.0), INTERVAL) for _ in range(830)]
    lower = POLAR * np.sqrt(SHEAR * DENSITY)
    upper = ratio**4 * lower
    speed = np.array([frame.rig.bit_speed for frame in frames])
    torque = np.array([frame.rig.top_drive_torque for frame in frames]) / upper
    assert speed[640:820].mean() == pytest.approx(4.0 * upper / (upper + lower), rel=3e-3)
    reflected = (upper - lower) / (upper + lower)
    assert torque[100:500].mean() == pytest.approx(1.0, rel=2e-3)
    assert torque[640:820].mean() == pytest.approx(1.0 - 2.0 * reflected, abs=6e-3)
    seen = echo(torque, 1.0, 1.0 - 2.0 * reflected, slice(640, 820))
    assert seen == pytest.approx(2.0 * SPAN * np.sqrt(DENSITY / SHEAR), rel=1e-3)
