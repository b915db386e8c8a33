# SPDX-License-Identifier: Apache-2.0
"""Static elongation and deflection."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import ellipk

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import EA, EI, LENGTH, LINE_MASS, quiet_scene
from drill_twin_evidence.verify.signals import AT_REST, run_for

SETTLING = {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3}
HEAVY = {"gravity": {"magnitude": 9.81}}
WEIGHT = LINE_MASS * 9.81 * LENGTH
EULER_LOAD = 4.0 * np.pi**2 * EI / LENGTH**2
SAGGING = 0.1  # [m/s2], small for small slopes
INCLINATION = np.pi / 3


@case()
def stretch_under_its_own_weight() -> Iterator[Row]:
    """The rod starts under 10 N on its bit, is released, and comes to rest by its internal damping.

    Cubic elements represent the quadratic displacement exactly; round-off and the residual motion remain.
    """
    effects = {"gravity": {"magnitude": 9.81}, "internal_damping": {"bending_time": 0.0, "stretch_time": 5e-3}}
    twin = Twin(quiet_scene(effects, weight_on_bit=10.0, step=1e-3))
    u, _ = twin.unknowns
    start = float(u[0, 2])
    for _ in range(50):
        frame = twin.advance(AT_REST, 0.01)
    weight = LINE_MASS * 9.81
    yield Row("elongation [m]", "w L^2 / (2 EA)", "Hooke 1678", weight * LENGTH**2 / (2.0 * EA),
              -float(u[0, 2]) - LENGTH, 1e-6)  # fmt: skip
    yield Row("displacement of the bit as 10 N are released [m]", "F L / EA", "Hooke 1678", 10.0 * LENGTH / EA,
              start - float(u[0, 2]), 1e-6)  # fmt: skip
    yield Row("hookload [N]", "w L", "balance", weight * LENGTH, frame.rig.hookload, 1e-6)


@case(forms=FORMS, load=(-40.0, 0.0, 8.0))
def beam_column_in_an_inclined_hole(load: float, form: str) -> Iterator[Row]:
    """Sag of the rod between its guided ends in a hole at 60 deg under a small gravity, in tension or compression.

    The closed form takes the axial force at mid-span, where its slow change along the string cancels to first order;
    the slopes of 3e-3 cause an error of 1e-5.
    """
    effects = {"gravity": {"magnitude": SAGGING}, "drag": {"linear": 2.5}}
    scene = quiet_scene(effects, inclination=INCLINATION, weight_on_bit=load, step=0.02, frame_rate=50.0, form=form)
    twin = run_for(scene, 12.0)
    weight = LINE_MASS * SAGGING
    exact = sag(weight * np.sin(INCLINATION), 0.5 * weight * np.cos(INCLINATION) * LENGTH - load)
    yield Row(
        what="sag at mid-span [m]",
        reference="q L^2 / 8T - q L / (2 T k) tanh(k L / 4), k^2 = T / EI; tan when pushed",
        source="Timoshenko 1956, part II, tie rods and beam columns",
        expected=exact,
        computed=float(twin.unknowns[0][twin.elements // 2, 0]),
        tolerance=1e-4,
    )


def sag(load: float, tension: float) -> float:
    """Deflection [m] at mid-span of a clamped-clamped beam under a load per length [N/m] and a tension [N]."""
    k = np.sqrt(abs(tension) / EI)
    lever = np.tanh(k * LENGTH / 4.0) if tension > 0.0 else np.tan(k * LENGTH / 4.0)
    return float(load * LENGTH**2 / (8.0 * tension) - load * LENGTH / (2.0 * tension * k) * lever)


@case(forms=FORMS)
def sag_of_a_cantilever(form: str) -> Iterator[Row]:
    """Cantilever in a level hole without contact, under a small gravity.

    Slopes of 1e-2 cause an error of 1e-3 in the spatial formulation.
    """
    effects = {"gravity": {"magnitude": 0.02}, "drag": {"linear": 0.3}, "internal_damping": SETTLING}
    scene = quiet_scene(effects, form=form, bit_end="free", inclination=np.pi / 2, step=0.02, frame_rate=20.0)
    u, _ = run_for(scene, 30.0).unknowns
    exact = LINE_MASS * 0.02 * LENGTH**4 / (8.0 * EI)
    yield Row("sag of the bit to the low side [m]", "w L^4 / (8 EI)", "Timoshenko 1955, part I", exact, float(u[0, 0]),
              2e-3)  # fmt: skip


@case()
def arc_of_a_bowed_rod() -> Iterator[Row]:
    """Rod with a uniform stress-free curvature: a circular arc in the direction of the bow.

    Exact for cubic elements; the residual motion remains.
    """
    bow = {"amplitude": 4e-3, "shape": "uniform", "angle": 0.6}
    effects = {"bow": bow, "drag": {"linear": 0.3}, "internal_damping": SETTLING}
    scene = quiet_scene(effects, form="lateral", bit_end="free", step=0.02, frame_rate=20.0)
    u, _ = run_for(scene, 25.0).unknowns
    place = complex(u[0, 0], u[0, 1]) * np.exp(-0.6j)
    yield Row("bit off the clamp's tangent, along the bow [m]", "4 A, curvature 8 A / L^2", "geometry", -16e-3,
              float(place.real), 1e-4)  # fmt: skip
    yield Row("bit off the clamp's tangent, across it [m]", "0", "geometry", 0.0, float(place.imag), 1e-8,
              relative=False)  # fmt: skip


@case(forms=FORMS, at=("bit", "top"))
def hanging_from_the_first_instant(at: str, form: str) -> Iterator[Row]:
    """Rod that starts in static equilibrium under its weight and 8 N at the bit: elongation, and no motion after it.

    Cubic elements represent the quadratic displacement exactly.
    """
    scene = in_equilibrium(quiet_scene(HEAVY, weight_on_bit=8.0 if at == "bit" else 8.0 - WEIGHT, at=at, form=form))
    twin = Twin(scene)
    u, v = twin.unknowns
    if form == "spatial":
        stretch = (0.5 * WEIGHT - 8.0) * LENGTH / EA
        yield Row("elongation [m]", "(w L / 2 - F) L / EA", "Hooke 1678", stretch, float(u[-1, 2] - u[0, 2]) - LENGTH,
                  1e-6)  # fmt: skip
        middle = twin.elements // 2
        yield Row("axial force at mid-span [N]", "w L / 2 - F", "balance", 0.5 * WEIGHT - 8.0,
                  EA * (float(u[middle, 5]) - 1.0), 1e-6)  # fmt: skip
    frames = [twin.advance(Command(*scene.rig.first), 0.01) for _ in range(50)]
    yield Row("hookload after 0.5 s [N]", "w L - F", "balance", WEIGHT - 8.0, frames[-1].rig.hookload, 1e-6)
    yield Row("axial speed at the free end after 0.5 s [m/s]", "0", "balance", 0.0,
              float(np.abs(v[:, 2]).max()), 1e-9, relative=False)  # fmt: skip


@case(share=(1.05, 1.2))
def elastica(share: float) -> Iterator[Row]:
    """Weightless column between guided ends that starts in static equilibrium above its buckling load.

    Four quarters of the elastica. The axial strain of 4e-5 shifts the buckling load, and the deflection just above it
    by more.
    """
    load = share * EULER_LOAD
    scene = in_equilibrium(quiet_scene({}, weight_on_bit=load, elements=32))
    u, _ = Twin(scene).unknowns
    modulus = _modulus(0.25 * LENGTH * np.sqrt(load / EI))
    yield Row(
        what="deflection at mid-span [m]",
        reference="4 k sqrt(EI / F), K(k) = L / 4 sqrt(F / EI)",
        source="Timoshenko and Gere 1961, section 2.7",
        expected=float(4.0 * modulus * np.sqrt(EI / load)),
        computed=float(np.hypot(u[u.shape[0] // 2, 0], u[u.shape[0] // 2, 1])),
        tolerance=1e-3,
    )


def in_equilibrium(scene: Scene) -> Scene:
    """The scene with its string in static equilibrium at time zero."""
    return scene.model_copy(update={"rig": scene.rig.model_copy(update={"start": "equilibrium"})})


def _modulus(quarter: float) -> float:
    """Modulus k with K(k) = quarter, by bisection [-]."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ellipk(middle**2) < quarter else (low, middle)
    return low
