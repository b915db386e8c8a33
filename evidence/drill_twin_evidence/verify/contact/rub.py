# SPDX-License-Identifier: Apache-2.0
"""Jeffcott rotor that rubs in its clearance, and a string that whirls as a helix, against closed forms."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.branches import branch, speed_of
from drill_twin.dynamics.rotordynamics.steady.shape_search import Shape, ShapeSearch, helix
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.dynamics.modes import SET
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import AREA, EI, LINE_MASS, quiet_scene

LATERAL = FORMS[1]
SHAFT, SHAFT_DENSITY, DISC, DISC_RADIUS, DISC_DENSITY, HOLE = 0.5, 1100.0, 0.2, 0.02, 8000.0, 0.06
"""Of each half shaft and of the disc between them: length and radius [m], density [kg/m3]; radius of the hole [m]."""
DRAG, FRICTION, ROTATION = 8.0, 0.15, 80.0
"""External damping [N s/m^2], friction coefficient, and a rotation at which the rotor rolls [rad/s]."""
BLACK = "Black 1968, Journal of Mechanical Engineering Science 10"
LUBINSKI = "Lubinski, Althouse and Logan 1962; Mitchell 1982"


def rotor() -> Scene:
    """A rigid disc between two clamped half shafts, in a hole with a clearance of twice its radius."""
    shaft = {"length": SHAFT, "density": SHAFT_DENSITY}
    disc = {"length": DISC, "density": DISC_DENSITY, "outer_diameter": 2.0 * DISC_RADIUS, "youngs_modulus": 1e12}
    effects = {"drag": {"linear": DRAG}, "wall": {"stiffness": None, "linear_stiffness": 1e8},
               "wall_friction": {"coefficient": FRICTION}}  # fmt: skip
    return quiet_scene(
        effects, of=SET, form=LATERAL, sections=(shaft, disc, shaft), radius=HOLE, elements=24, marks=(0.6,)
    )


def dynamic_stiffness(omega: float) -> complex:
    """Force over displacement of the disc whirling at omega [N/m].

    Each half shaft, clamped at one end, without rotation at the other, is a beam: EI z'''' = (m omega^2 - i c omega) z.
    """
    beta = cmath.sqrt(cmath.sqrt((SHAFT_DENSITY * AREA * omega**2 - 1j * DRAG * omega) / EI))
    at = beta * SHAFT
    even, odd = cmath.cos(at) - cmath.cosh(at), cmath.sin(at) - cmath.sinh(at)
    slope = -cmath.sin(at) - cmath.sinh(at), even
    matrix = np.array([[even, odd], slope])
    one, other = np.linalg.solve(matrix, [1.0, 0.0])
    shear = beta**3 * (one * (cmath.sin(at) - cmath.sinh(at)) - other * (cmath.cos(at) + cmath.cosh(at)))
    mass = DISC_DENSITY * math.pi * DISC_RADIUS**2 * DISC
    return complex(-2.0 * EI * shear - mass * omega**2 + 1j * DRAG * DISC * omega)


def _newton(turning: TurningEquations, shape: Shape | None) -> SteadyWhirl:
    whirl = turning.newton(shape.whirl) if shape is not None else None
    if whirl is None:
        raise RunError("expected a steady whirl near the first shape, found none: Newton's method does not converge")
    return whirl


@case(forms=(LATERAL,))
def rubbing_jeffcott_rotor() -> Iterator[Row]:
    """Dry whip: the backward whirl that friction sustains in full slip, and the rotation from which it can exist.

    The wall presses on the disc with N, friction with mu N against the slip: the whirl is the speed at which the phase
    of the rotor's dynamic stiffness Z is the friction angle. It does not depend on the rotation, down to that at which
    the slip ends: there its branch over the rotation ends too. Mesh of 24 cubic elements, contact regularised at
    1e-6 of the speed of the surface.
    """

    def excess(omega: float) -> float:
        stiffness = dynamic_stiffness(-omega)
        return abs(stiffness.imag) + FRICTION * stiffness.real

    natural = float(brentq(lambda omega: dynamic_stiffness(omega).real, 1.0, 100.0))
    exact = float(brentq(excess, natural, 100.0))
    turning, command = TurningEquations(EquationsOfMotion(rotor())), Command(0.0, ROTATION)
    search = ShapeSearch(turning, command)
    shape = search.relax(next(search.starts(0, 0)), -1.02 * exact)
    whip = _newton(turning, shape)
    found = branch(speed_of(turning, command, 0.5 * ROTATION, 1.05 * ROTATION), whip, ROTATION)
    yield Row("dry whip [rad/s]", "abs(Im Z) = -mu Re Z", BLACK, -exact, whip.omega, 2e-4)
    yield Row("its threshold: rotation [rad/s]", "omega_whip r_orbit / r", BLACK,
              exact * float(whip.radius.max()) / DISC_RADIUS, float(found.values.min()), 2e-4)  # fmt: skip


@case(forms=(LATERAL,))
def whirling_helix() -> Iterator[Row]:
    """A string buckled into a helix by a load P, without friction: pitch and wall force in the middle, and whirl speed.

    At both ends no torque acts about the axis, so none does along the string: EI beta^2 = P / 2. Damping of the
    material drives the whirl, drag brakes it, each by its integral over the shape. 64 cubic elements: (beta h)^4 / 720
    is 7e-5, and more in the force, by the depth of the penetration over the radius.
    """
    load, rotation, drag, retardation, length = 150.0, 1.0, 0.1, 1e-4, 10.0
    effects = {"internal_damping": {"bending_time": retardation}, "drag": {"linear": drag}}
    scene = quiet_scene(effects, of=SET, form=LATERAL, length=length, radius=0.09, elements=64)
    turning = TurningEquations(EquationsOfMotion(scene))
    search = ShapeSearch(turning, Command(load, rotation))
    wave = math.sqrt(load / (2.0 * EI))
    inner = retardation * EI * wave**4
    shape = search.relax(helix(search, wave * length / math.tau), rotation * inner / (inner + drag))
    whirl = _newton(turning, shape)
    rod, middle = turning.equations.model.rod, whirl.u.shape[0] // 2
    place, slope = whirl.u[:, 0] + 1j * whirl.u[:, 1], whirl.u[:, 3] + 1j * whirl.u[:, 4]
    radius = abs(place[middle])
    turn = float((slope[middle] / place[middle]).imag)
    ends = np.stack([place[:-1], slope[:-1], place[1:], slope[1:]], axis=1)
    at_gauss, curved = (np.einsum("egk,ek->eg", rod.shape[:, :, order], ends) for order in (0, 2))
    force = 1e7 * (np.abs(at_gauss[middle]) - turning.clearance) ** 1.5
    yield Row("wave number in the middle [1/m]", "sqrt(P / 2 EI)", LUBINSKI, wave, abs(turn), 1e-3)
    pressed = float(radius * (load**2 / (4.0 * EI) + LINE_MASS * whirl.omega**2))
    yield Row(
        "wall force in the middle [N/m]", "r (P^2 / 4 EI + m omega^2)", LUBINSKI, pressed, float(force.mean()), 3e-3
    )
    square, bent = (float(np.sum(0.5 * rod.length[:, None] * np.abs(one) ** 2)) for one in (at_gauss, curved))
    drive = retardation * EI * bent
    yield Row("whirl over rotation [-]", "a / (a + c int |z|^2), a = eta EI int |z''|^2", "balance of power",
              drive / (drive + drag * square), whirl.omega / rotation, 1e-5)  # fmt: skip
