# SPDX-License-Identifier: Apache-2.0
"""Axial and torsional waves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame import Frame
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import AREA, DENSITY, DIAMETER, LENGTH, SHEAR, YOUNG, quiet_scene

INTERVAL, ELEMENTS = 2e-5, 100
POLAR = np.pi / 32 * DIAMETER**4
TEXTBOOK = "Graff 1975, ch. 2"
THICK = 1.3
"""Diameter of the thicker of two sections, in diameters of the rod."""


def arrival(signal: Array, plateau: float) -> float:
    """Arrival of a front of this height [s]: zero of the integral of the signal, extrapolated backwards.

    Dispersion smears a front over a few elements but does not change its integral.
    """
    time = INTERVAL * np.arange(1, signal.size + 1)
    return float(np.mean((time - np.cumsum(signal) * INTERVAL / plateau)[300:480]))


@case()
def axial() -> Iterator[Row]:
    """A step of 1 N on the bit at t = 0 travels up and doubles at the clamp.

    Dispersion smears the front over a few of the 100 elements: its position is accurate to half an element, its height
    to the ringing that remains in the mean.
    """
    twin = Twin(quiet_scene({}, elements=ELEMENTS, step=INTERVAL))
    load = Command(weight_on_bit=1.0, rotation=0.0)
    push = -np.array([twin.advance(load, INTERVAL).rig.hookload for _ in range(480)])
    exact = LENGTH * float(np.sqrt(DENSITY / YOUNG))
    yield Row("arrival at the clamp [s]", "L sqrt(rho / E)", TEXTBOOK, exact, arrival(push, 2.0), 5e-3)
    yield Row("force at the clamp [N]", "2 F", TEXTBOOK, 2.0, float(push[300:].mean()), 2e-3)


@case()
def torsional() -> Iterator[Row]:
    """The top starts to turn at 1 rad/s; the front doubles at the free bit, and until its reflection returns the torque
    of the drive is that of an infinite string.

    Resolution as for the axial wave.
    """
    twin = Twin(quiet_scene({}, elements=ELEMENTS, step=INTERVAL))
    frames = [twin.advance(Command(weight_on_bit=0.0, rotation=1.0), INTERVAL) for _ in range(560)]
    speed = np.array([frame.rig.bit_speed for frame in frames])
    torque = np.array([frame.rig.top_drive_torque for frame in frames])
    exact = LENGTH * float(np.sqrt(DENSITY / SHEAR))
    yield Row("arrival at the bit [s]", "L sqrt(rho / G)", TEXTBOOK, exact, arrival(speed, 2.0), 5e-3)
    yield Row("speed of the bit [rad/s]", "2 Omega", TEXTBOOK, 2.0, float(speed[400:].mean()), 2e-3)
    impedance = POLAR * float(np.sqrt(SHEAR * DENSITY))
    yield Row(
        "torque of the drive [N m]", "J sqrt(G rho) Omega", TEXTBOOK, impedance, float(torque[100:500].mean()), 5e-3
    )


@case(thick=("bit", "top"))
def torsional_at_a_change_of_section(thick: str) -> Iterator[Row]:
    """Transmission and reflection of the front at a change of section half way down, to or from 1.3 times the diameter.

    Means over a plateau, with the ringing of a front smeared over a few of the 100 elements.
    """
    frames = _two_sections(thick, Command(weight_on_bit=0.0, rotation=1.0), LENGTH / 4, intervals=540)
    below, above = (_share(thick, end, 4) for end in ("bit", "top"))
    passed = 2.0 * above / (above + below)
    speed = np.mean([frame.marks.spin_rate[0] for frame in frames[250:340]])
    torque = np.mean([frame.rig.top_drive_torque for frame in frames[340:]])
    impedance = above * POLAR * float(np.sqrt(SHEAR * DENSITY))
    yield Row("speed below the change [rad/s]", "2 Z_1 / (Z_1 + Z_2), Z = J sqrt(G rho)", TEXTBOOK, passed,
              float(speed), 5e-3)  # fmt: skip
    yield Row("torque of the drive after the echo, of that before [-]", "1 - 2 (Z_1 - Z_2) / (Z_1 + Z_2)", TEXTBOOK,
              3.0 - 2.0 * passed, float(torque) / impedance, 5e-3, relative=False)  # fmt: skip


@case(thick=("bit", "top"))
def axial_at_a_change_of_section(thick: str) -> Iterator[Row]:
    """Transmission of a step of 1 N at a change of section half way up, to or from 1.3 times the diameter.

    Means over a plateau, weighted by a Hann window against the ringing behind a front in 100 elements.
    """
    frames = _two_sections(thick, Command(weight_on_bit=1.0, rotation=0.0), 0.75 * LENGTH, intervals=330)
    below, above = (_share(thick, end, 2) for end in ("bit", "top"))
    passed = 2.0 * above / (above + below)
    speed = _calm_mean([frame.marks.velocity[0, 2] for frame in frames[140:200]])
    force = -_calm_mean([frame.rig.hookload for frame in frames[210:]])
    impedance = above * AREA * float(np.sqrt(YOUNG * DENSITY))
    yield Row("speed above the change [m/s]", "2 / (Z_1 + Z_2) F, Z = A sqrt(E rho)", TEXTBOOK, passed / impedance,
              speed, 2e-3)  # fmt: skip
    yield Row("force at the clamp [N]", "4 Z_2 / (Z_1 + Z_2) F", TEXTBOOK, 2.0 * passed, force, 2e-3)


def _calm_mean(signal: list[float]) -> float:
    return float(np.average(signal, weights=np.hanning(len(signal))))


def _share(thick: str, end: str, power: int) -> float:
    """Ratio to the rod at this end: THICK to the power where the section is the thicker one, else 1."""
    return float(THICK**power) if thick == end else 1.0


def _two_sections(thick: str, command: Command, mark: float, intervals: int) -> list[Frame]:
    sections = [{"length": LENGTH / 2, "outer_diameter": DIAMETER * _share(thick, end, 1)} for end in ("bit", "top")]
    scene = quiet_scene({}, sections=sections, elements=ELEMENTS, step=INTERVAL, marks=(mark,))
    twin = Twin(scene)
    return [twin.advance(command, INTERVAL) for _ in range(intervals)]
