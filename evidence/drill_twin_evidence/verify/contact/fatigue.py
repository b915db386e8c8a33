# SPDX-License-Identifier: Apache-2.0
"""Stress of the turning material: cycles of a whirling and a rolling string, stress of a bent and a pulled one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model.mesh import SPIN
from drill_twin.physics.model.section_stress import AXIAL_FORCE, CYCLES, DAMAGE, SCALARS, STRESS
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import SPATIAL, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import (
    AREA,
    DIAMETER,
    FIRST,
    LENGTH,
    ROLLING,
    WALLED,
    YOUNG,
    quiet_scene,
)
from drill_twin_evidence.verify.signals import first_mode

RANGE, SLOPE = 1e6, 3.0
AMPLITUDE, SMALLEST = 1e-3, 1e4
SECONDS = 60.0
INTERVAL = 0.04
FATIGUE: dict[str, Any] = {
    "sections": [{"name": "middle", "distance_from_bit": 0.5 * LENGTH}],
    "line": {"stress_range": RANGE, "slope": SLOPE}, "mean_stress": "none", "smallest_range": SMALLEST,
}  # fmt: skip
STRESSED = {**WALLED, "fatigue": FATIGUE}
"""Set of effects with a wall, and the stress at mid-span."""
MATERIAL = "kinematics of the turning material"


@case(forms=(SPATIAL,), turning=(1.0, 0.0, 2.5, -1.0))
def cycles_of_whirl(turning: float) -> Iterator[Row]:
    """Stress cycles of a free circular whirl in the first mode, rotating at multiples of its frequency.

    A synchronous whirl bends each fibre by a constant amount. The count ends in the midst of a cycle: half a one is
    the error. Other modes put a ripple on the ranges, by which the damage is some per cent larger than that of their
    mean. 16 elements and a step of 4 ms.
    """
    twin = Twin(quiet_scene({}, of=STRESSED, elements=16, step=INTERVAL / 10.0))
    u, v = twin.unknowns
    shape, slope = first_mode(twin.rod.arc)
    u[:, 0], u[:, 3] = AMPLITUDE * shape, AMPLITUDE * slope
    v[:, 1], v[:, 4], v[:, 6] = FIRST * u[:, 0], FIRST * u[:, 3], turning * FIRST
    command = Command(weight_on_bit=0.0, rotation=turning * FIRST)
    stress = np.array([_middle(twin, command)[STRESS] for _ in range(round(SECONDS / INTERVAL))])
    found = _middle(twin, command)
    rate = abs(turning - 1.0) * FIRST / math.tau
    yield Row("cycles [-]", "|Omega - omega| T / (2 pi)", MATERIAL, rate * twin.time, float(found[CYCLES]), 0.75,
              relative=False)  # fmt: skip
    if turning != 1.0:
        damage = found[CYCLES] * (2.0 * float(np.mean(stress)) / RANGE) ** SLOPE / 1e6
        yield Row("damage [-]", "n (2 E r kappa)^m / (N_0 S_0^m)", "Miner 1945", damage, float(found[DAMAGE]), 0.1)


@case(forms=(SPATIAL,))
def cycles_of_rolling() -> Iterator[Row]:
    """Stress cycles of a string that rolls backwards on the wall, in each of its turns.

    The clearance is that of the orbit, from 20 s of it; the count is exact to half a cycle. Step 2 ms.
    """
    twin = Twin(quiet_scene(ROLLING, of=STRESSED, step=2e-3, radius=0.04))
    rows = []
    for k in range(2500):
        share = min((k + 1) * 0.01 / 2.0, 1.0)
        found = _middle(twin, Command(weight_on_bit=30.0 * share, rotation=math.tau * share), 0.01)
        middle = twin.unknowns[0][twin.elements // 2]
        rows.append((middle[SPIN], found[CYCLES], math.hypot(middle[0], middle[1])))
    spin, cycles, radius = np.array(rows[-2000:]).T
    turns = float(spin[-1] - spin[0]) / math.tau
    yield Row("cycles a turn [-]", "1 + r / C", MATERIAL, float(1.0 + 0.5 * DIAMETER / radius.mean()),
              float((cycles[-1] - cycles[0]) / turns), 1.0 / turns, relative=False)  # fmt: skip


@case(forms=(SPATIAL,))
def stress_of_bending_and_tension() -> Iterator[Row]:
    """Stress at mid-span of a given arc between clamps, and of a pulled rod, at the first instants.

    The arc is the first mode with an amplitude of 1 mm. The curvature of a cubic element is linear: at its ends it is
    wrong by h^2 kappa'' / 12, 4e-3 with 24 elements.
    """
    twin = Twin(quiet_scene({}, of=STRESSED, elements=24, step=1e-5))
    u, _ = twin.unknowns
    shape, slope = first_mode(twin.rod.arc)
    u[:, 0], u[:, 3] = AMPLITUDE * shape, AMPLITUDE * slope
    found = _middle(twin, Command(weight_on_bit=0.0, rotation=0.0), 1e-5)
    beta, half = 4.730040745 / LENGTH, 4.730040745 / 2.0
    curve = AMPLITUDE * beta**2 * (np.cosh(half) + np.cos(half) - 0.9825022158 * (np.sinh(half) + np.sin(half)))
    exact = 0.5 * YOUNG * DIAMETER * abs(float(curve))
    yield Row("stress of bending [Pa]", "E r kappa", "beam theory", exact, float(found[STRESS]), 5e-3)
    damping = {"internal_damping": {"stretch_time": 0.02}}
    twin = Twin(quiet_scene(damping, of=STRESSED, weight_on_bit=-10.0, step=2e-3))
    for _ in range(50):
        force = _middle(twin, Command(weight_on_bit=-10.0, rotation=0.0))
    yield Row("axial force [N]", "F", "balance", 10.0, float(force[AXIAL_FORCE]), 1e-4)
    yield Row("stress of tension [Pa]", "F / A", "balance", 10.0 / AREA, float(force[STRESS]), 1e-4)


def _middle(twin: Twin, command: Command, seconds: float = INTERVAL) -> Array:
    """Scalars of mid-span after a frame (`drill_twin.physics.model.section_stress`)."""
    found = twin.advance(command, seconds).stress
    return np.zeros(len(SCALARS)) if found is None else found[0]
