# SPDX-License-Identifier: Apache-2.0
"""A pipe in mud: buoyancy and added mass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.special import kv

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import (
    DENSITY,
    DIAMETER,
    FIRST,
    KICK,
    LENGTH,
    LINE_MASS,
    WAVE,
    YOUNG,
    quiet_scene,
)  # fmt: skip
from drill_twin_evidence.verify.signals import AT_REST, first_mode, free_motion, rates, squared_frequencies
from drill_twin_evidence.verify.statics.buckling import buckling_load

BORE, HOLE, MUD = 0.012, 0.03, 1200.0
WALL, DISC, INSIDE = np.pi / 4 * (DIAMETER**2 - BORE**2), np.pi / 4 * DIAMETER**2, np.pi / 4 * BORE**2
PIPE_EI = YOUNG * np.pi / 64 * (DIAMETER**4 - BORE**4)
PIPE = ({"inner_diameter": BORE},)
NARROW = (HOLE**2 + (DIAMETER / 2) ** 2) / (HOLE**2 - (DIAMETER / 2) ** 2)
ADDED: dict[str, tuple[dict[str, Any], str, float]] = {
    "open": ({"coefficient": 1.7}, "mud", MUD * (1.7 * DISC + INSIDE)),
    "confined": ({"coefficient": 1.0, "confined": True}, "air", MUD * NARROW * DISC),
}
"""Block of `added_mass`, fluid in the pipe, added mass per length [kg/m]."""
PINNED = (3.926602312, 7.068582746, 10.210176123)


@case(forms=FORMS)
def buoyant_weight(form: str) -> Iterator[Row]:
    """Hookload of the pipe with buoyancy: it displaces its wall if mud fills it, its full disc if air does.

    The string starts in equilibrium, so only round-off remains.
    """
    for inside, displaced in (("mud", WALL), ("air", DISC)):
        effects = {"gravity": {"magnitude": 9.81}, "mud": {"density": MUD, "inside": inside}}
        twin = Twin(quiet_scene(effects, form=form, sections=PIPE))
        loads = [twin.advance(AT_REST, 0.01).rig.hookload for _ in range(20)]
        exact = (DENSITY * WALL - MUD * displaced) * 9.81 * LENGTH
        worst = max(loads, key=lambda load: abs(load - exact))
        yield Row(f"hookload with {inside} inside [N]", "(rho_s A_wall - rho A) g L", "Archimedes", float(exact), worst,
                  1e-8)  # fmt: skip


@case(forms=FORMS)
def floating_string(form: str) -> Iterator[Row]:
    """Buckling of a hanging pipe by buoyancy in mud denser than itself, as of a column that stands on its clamp.

    Evaluated as Euler's load.
    """

    def scene(lift: float) -> Scene:
        effects = KICK | {
            "gravity": {"magnitude": lift / ((1500.0 - DENSITY) * WALL)},
            "mud": {"density": 1500.0},
        }
        return quiet_scene(effects, form=form, sections=PIPE, bit_end="free", step=2e-3)

    exact = 7.83734744 * PIPE_EI / LENGTH**3
    found = buckling_load(scene, exact, 0.01 * exact, 4.0)
    yield Row("critical lift, w L^3 / EI [-]", "w L^3 / EI = 9/4 j^2, J_-1/3(j) = 0", "Greenhill 1881", 7.83734744,
              float(found * LENGTH**3 / PIPE_EI), 1e-3)  # fmt: skip


@case(forms=FORMS, hole=tuple(ADDED))
def frequencies(hole: str, form: str) -> Iterator[Row]:
    """Lateral frequencies of the pipe with the added mass of the mud, in an open and in a narrow hole.

    24 elements and 2 ms: (omega dt)^2 / 12 is 2e-4 of the third.
    """
    block, inside, added = ADDED[hole]
    effects: dict[str, Any] = WAVE | {"mud": {"density": MUD, "inside": inside}, "added_mass": block}
    scene = quiet_scene(effects, form=form, sections=PIPE, step=2e-3, bit_end="pinned", radius=HOLE)
    found = np.sqrt(squared_frequencies(free_motion(scene, 8.0, 0.02), 0.02, modes=6)[:3])
    source = "Blevins 1979, table 8-1; " + ("Fritz 1972" if hole == "confined" else "Lamb 1932, art. 68")
    for value, frequency in zip(PINNED, found, strict=True):
        exact = (value / LENGTH) ** 2 * np.sqrt(PIPE_EI / (DENSITY * WALL + added))
        yield Row(f"frequency at beta L = {value:.4f} [rad/s]", "beta^2 sqrt(EI / (m + m_a))", source, float(exact),
                  float(frequency), 3e-4)  # fmt: skip


@case(forms=FORMS)
def viscous_damping(form: str) -> Iterator[Row]:
    """Decay and frequency of the first mode of the clamped-clamped rod in a thick mud whose wall is far away.

    The coefficients hold at `mud.frequency`, which is not the mode's. The wall at 5 m adds (r_o / R)^2 = 3e-6.
    """
    viscosity, reference = 0.2, 0.5
    effects: dict[str, Any] = {
        "mud": {"density": MUD, "viscosity": viscosity, "frequency": reference},
        "added_mass": {"coefficient": 1.0, "confined": True},
        "viscous_drag": {},
    }
    twin = Twin(quiet_scene(effects, form=form, step=2e-3))
    u = twin.unknowns[0]
    shape, slope = first_mode(twin.rod.arc)
    u[:, 0], u[:, 3] = 1e-6 * shape, 1e-6 * slope
    found = rates(np.array([twin.advance(AT_REST, 0.02).marks.centre[0, 0] for _ in range(200)]), 0.02)[0]
    omega = 2.0 * np.pi * reference
    z = np.sqrt(1j * omega * MUD / viscosity) * DIAMETER / 2
    force = MUD * DISC * (1.0 + 4.0 * kv(1, z) / (z * kv(0, z)))
    mass = LINE_MASS + force.real
    decay = float(-omega * force.imag / (2.0 * mass))
    source = "Stokes 1851, H = 1 + 4 K1(z) / (z K0(z)), z^2 = i omega r^2 / nu"
    yield Row("decay [1/s]", "c / 2 (m + m_a), c = -rho A omega Im(H)", source, decay, -float(found.real), 1e-3)
    yield Row("frequency [rad/s]", "sqrt(omega_1^2 m / (m + m_a) - (c / 2 (m + m_a))^2), m_a = rho A Re(H)", source,
              float(np.sqrt(FIRST**2 * LINE_MASS / mass - decay**2)), abs(float(found.imag)), 1e-4)  # fmt: skip


@case()
def axial_frequency() -> Iterator[Row]:
    """Frequency of the first axial mode, which the added mass does not change.

    omega dt = 1/22: 2e-4.
    """
    effects = {"mud": {"density": MUD}, "added_mass": {"coefficient": 2.0}}
    twin = Twin(quiet_scene(effects, sections=PIPE, step=1e-4))
    _, v = twin.unknowns
    wave = np.pi / (2.0 * LENGTH)
    v[:, 2], v[:, 5] = 1e-6 * np.cos(wave * twin.rod.arc), -1e-6 * wave * np.sin(wave * twin.rod.arc)
    speeds = []
    for _ in range(200):
        twin.advance(AT_REST, 2e-4)
        speeds.append(v[0, 2])
    yield Row("first axial frequency [rad/s]", "pi / 2 L sqrt(E / rho)", "Rayleigh 1877, ch. VII",
              float(wave * np.sqrt(YOUNG / DENSITY)), abs(float(rates(np.array(speeds), 2e-4)[0].imag)), 5e-4,
              )  # fmt: skip
