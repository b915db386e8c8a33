# SPDX-License-Identifier: Apache-2.0
"""Errors at fifty elements and the default tolerance of Newton's method."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.dynamics.lateral_frequencies import frequency_rows
from drill_twin_evidence.verify.numerics.conservation import swing
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import DENSITY, EI, KICK, LENGTH, SHEAR, quiet_scene
from drill_twin_evidence.verify.signals import AT_REST, squared_frequencies
from drill_twin_evidence.verify.statics.buckling import EULER, buckling_load

ELEMENTS, TOLERANCE = 50, 1e-5


@case(forms=FORMS, bit_end=("guided", "free"))
def frequencies(bit_end: str, form: str) -> Iterator[Row]:
    """First three lateral frequencies, with a step of 1 ms, which causes nearly all of the error."""
    yield from frequency_rows(bit_end, form, 1e-3, ELEMENTS, tolerance=TOLERANCE)


@case(bit_end=("guided", "free"))
def buckling(bit_end: str) -> Iterator[Row]:
    """Euler's load, where the lowest omega^2 passes zero."""

    def scene(load: float) -> Scene:
        return quiet_scene(KICK, bit_end=bit_end, weight_on_bit=load, elements=ELEMENTS, step=2e-3, tolerance=TOLERANCE)

    exact = float(np.pi**2 * EI / (EULER[bit_end] * LENGTH) ** 2)
    yield Row("buckling load [N]", "F = pi^2 EI / (K L)^2", "Euler 1757", exact,
              buckling_load(scene, exact, 0.01 * exact, 6.0), 1e-3)  # fmt: skip


@case()
def torsion() -> Iterator[Row]:
    """First torsional frequency of the rod, held at the top, with a step of 0.1 ms."""
    twin = Twin(quiet_scene({}, elements=ELEMENTS, step=1e-4, tolerance=TOLERANCE))
    twin.unknowns[1][:, 6] = np.cos(0.5 * np.pi * twin.rod.arc / LENGTH)
    motion = np.array([twin.advance(AT_REST, 5e-4).spin for _ in range(200)])
    exact = 0.5 * np.pi / LENGTH * np.sqrt(SHEAR / DENSITY)
    yield Row("first torsional frequency [rad/s]", "omega = pi / (2 L) sqrt(G / rho)", "Graff 1975, ch. 2",
              float(exact), float(np.sqrt(squared_frequencies(motion, 5e-4, modes=4)[0])), 1e-3)  # fmt: skip


@case(tolerance=(1e-5, 1e-6))
def energy_of_a_swing(tolerance: float) -> Iterator[Row]:
    """Energy over thirty seconds of undamped free motion of the hanging rod after a large initial velocity; free bit.

    The residuals of Newton's method at 1e-5 accumulate over 15000 steps; at 1e-6, the default of a scene without
    losses, they do not.
    """
    yield Row("largest change of energy, of what was put in [-]", "kinetic + bending + stretch + m g z is kept",
              "Hairer, Lubich and Wanner 2006, ch. IX", 0.0, swing("spatial", elements=ELEMENTS, tolerance=tolerance),
              100.0 * tolerance, relative=False)  # fmt: skip
