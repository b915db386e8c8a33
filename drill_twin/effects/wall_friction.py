# SPDX-License-Identifier: Apache-2.0
"""Friction of the string on the wall, on the slip velocity of the contact point including the spin."""

from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.effects.block import Block
from drill_twin.effects.wall import press
from drill_twin.rod.jit import kernel
from drill_twin.rod.mesh import Rod
from drill_twin.rod.point import Point
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array, Pair
from drill_twin.units import Dimensionless, InverseSpeed, Within


class WallFriction(Block):
    """Friction force 2 mu N arctan(xi v) / (pi (1 + delta |v|)) against the slip velocity v (the paper's Eq. 10)."""

    needs: ClassVar[tuple[str, ...]] = ("wall",)

    coefficient: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient mu at low slip speed [-]."""
    decay: Annotated[InverseSpeed, Within(at_least="0 s/m", at_most="1e4 s/m")] = 0.0
    """Fall of friction with slip speed, delta [s/m]; 0 = Coulomb."""
    accuracy: Annotated[InverseSpeed, Within(at_least="1 s/m", at_most="1e12 s/m")] = 1e6
    """Steepness xi of the regularised sign at zero slip [s/m]."""


class Parameters(NamedTuple):
    """Coefficient, decay with slip [s/m], the slip below which the contact sticks [m/s], and Newton's memory."""

    coefficient: float
    decay: float
    creep: float
    memory: (
        Array  # per Gauss point: slip across and along, its smoothed size, dual across and along, iteration; (2 n, 6)
    )


def parameters(block: WallFriction, site: Site) -> Parameters:
    """The creep has the initial slope of the paper's arctan: 2 xi / pi = 1 / creep."""
    memory = np.zeros((site.places.size, 6))
    memory[:, 5] = -1.0
    return Parameters(block.coefficient, block.decay, np.pi / (2.0 * block.accuracy), memory)


@kernel
def dual(memory: Array, fresh: bool, count: float, across: float, along: float, size: float) -> Pair:
    """Direction and share of the friction limit that Newton's method believes in, at most 1 long.

    The law s / |s| has a kink that throws Newton's method to and fro. Written as ``dual |s| = s`` and linearised in
    both unknowns it does not (Chan, Golub and Mulet 1999): the dual follows from the last iteration's slip alone.
    """
    dx, dy = 0.0, 0.0
    if not fresh and memory[5] == count - 1.0:
        change = (memory[0] * (across - memory[0]) + memory[1] * (along - memory[1])) / memory[2]
        dx = (across - memory[3] * change) / memory[2]
        dy = (along - memory[4] * change) / memory[2]
        long = np.sqrt(dx * dx + dy * dy)
        if long > 1.0:
            dx, dy = dx / long, dy / long
    memory[0], memory[1], memory[2], memory[3], memory[4], memory[5] = across, along, size, dx, dy, count
    return dx, dy


@kernel
def point(parameters: Any, rod: Rod, here: Point, h2: float, load: Array, stiff: Array) -> None:
    """Friction against the slip of the contact point: v_t + Omega r across, v_z along (paper Eq. 10 on the true slip).

    mu N s / sqrt(s^2 + creep^2) / (1 + delta s). The paper's 2/pi arctan(xi s) has the same limits and the same slope
    at rest.
    """
    force, slope, nx, ny, _ = press(parameters.wall, here, h2)
    if force > 0.0:
        law = parameters.wall_friction
        r = rod.outer_radius[here.element]
        across = nx * here.vy - ny * here.vx + r * here.spin_rate
        along = here.vz
        square = across * across + along * along
        size = np.sqrt(square + law.creep * law.creep)
        limit = law.coefficient / (1.0 + law.decay * np.sqrt(square))
        st, sz = across / size, along / size
        ft, fz = -limit * force * st, -limit * force * sz
        load[0] -= ft * ny
        load[1] += ft * nx
        load[2] += fz
        load[3] += r * ft
        dt, dz = dual(law.memory[here.place], here.fresh, here.iteration, across, along, size)
        scale = limit * force / size
        tt, zz = scale * (1.0 - dt * st), scale * (1.0 - dz * sz)
        tz = -0.5 * scale * (dt * sz + dz * st)
        # friction grows with the pressure: unsymmetric
        tn, zn = limit * slope * st, limit * slope * sz
        stiff[0, 0] += tt * ny * ny - tn * ny * nx
        stiff[0, 1] -= tt * nx * ny + tn * ny * ny
        stiff[0, 2] -= tz * ny
        stiff[0, 3] -= tt * ny * r
        stiff[1, 0] -= tt * nx * ny - tn * nx * nx
        stiff[1, 1] += tt * nx * nx + tn * nx * ny
        stiff[1, 2] += tz * nx
        stiff[1, 3] += tt * nx * r
        stiff[2, 0] += zn * nx - tz * ny
        stiff[2, 1] += zn * ny + tz * nx
        stiff[2, 2] += zz
        stiff[2, 3] += tz * r
        stiff[3, 0] += r * (tn * nx - tt * ny)
        stiff[3, 1] += r * (tn * ny + tt * nx)
        stiff[3, 2] += r * tz
        stiff[3, 3] += r * r * tt
