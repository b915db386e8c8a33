# SPDX-License-Identifier: Apache-2.0
"""Contact with the wall of the hole: force per length K d^1.5 or K d at the penetration d, with restitution."""

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, HertzStiffness, LinearStiffness, Speed, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import DiscreteModel, Point, Rod, Wellbore, axis_offset

SMALLEST = 1e-12  # distance from the axis at which a normal still has a direction [m]


class Wall(EffectConfig):
    """Elastic wall with the damping of Hunt and Crossley (1975), and the exponent 1.5 of the paper's Eq. 11.

    Give `stiffness` (Hertz, K d^1.5) or `linear_stiffness` (K d), both per metre of string.
    """

    across = True
    stiffness: Annotated[HertzStiffness, Within(above="0 N/m^2.5", at_most="1e15 N/m^2.5")] | None = None
    """Contact stiffness K per length of string, force K d^1.5 at the penetration d [N/m^2.5]."""
    linear_stiffness: Annotated[LinearStiffness, Within(above="0 N/m^2", at_most="1e13 N/m^2")] | None = None
    """Instead of `stiffness`: contact stiffness K per length of string, force K d [N/m^2]."""
    restitution: Annotated[
        Dimensionless, Within(at_least="0.01", at_most="1", reason="such a wall always rebounds a little")
    ] = 0.5
    """Coefficient of restitution of an impact at the reference speed [-]; 1 = no loss."""
    reference_speed: Annotated[Speed, Within(above="0 m/s", at_most="100 m/s")] = 0.1
    """Impact speed of that restitution [m/s]; slower impacts lose less."""

    def problems(self) -> Iterator[Problem]:
        """Two laws, or none."""
        if (self.stiffness is None) == (self.linear_stiffness is None):
            found = "neither" if self.stiffness is None else "both"
            yield (), f'expected `stiffness` such as "1e7 N/m^2.5" or `linear_stiffness`, found {found}'


class Parameters(NamedTuple):
    """The hole at the Gauss points, and the contact law per metre of string."""

    bore: Wellbore
    lever: Array  # contact radius of the string [m], shape (2 n,)
    stiffness: float  # [N/m^2.5], or [N/m^2] of a linear wall
    linear: float  # 1: force K d; 0: K d^1.5
    damping: float  # chi [s/m]


def parameters(block: Wall, model: DiscreteModel) -> Parameters:
    """Compute the damping factor from the restitution at the reference speed."""
    return Parameters(
        bore=model.wellbore,
        lever=model.contact_radius,
        stiffness=block.stiffness or block.linear_stiffness or 0.0,
        linear=1.0 if block.stiffness is None else 0.0,
        damping=damping_number(block.restitution) / block.reference_speed,
    )


def damping_number(restitution: float) -> float:
    """Damping factor times impact speed, a = chi v, for a coefficient of restitution e, exact for any power of d.

    With force K d^p (1 + chi d_dot), m v dv = -K d^p (1 + chi v) dd separates. Integrated over approach and rebound:
    a - ln(1 + a) = -e a - ln(1 - e a) for all K, p and m (Gonthier, McPhee, Lange and Piedboeuf 2004, Multibody System
    Dynamics 11, 209-233, Eq. 21); 3/2 (1 - e) is its limit for small loss (Hunt and Crossley 1975).
    """
    if restitution >= 1.0:
        return 0.0

    def excess(a: float) -> float:
        return float(a * (1.0 + restitution) - np.log1p(a) + np.log1p(-restitution * a))

    # positive from 0 up to the root, then decreasing to minus infinity at 1 / e
    low, high = 0.0, (1.0 - 1e-15) / restitution
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


class Contact(NamedTuple):
    """Contact at a point: normal force, outward normal and direction of the hole."""

    force: float  # normal force per length [N/m]
    slope: float  # of the force by the velocity along the normal, position included (times half_step) [N s/m2]
    swing: float  # of the force by the circumferential velocity [N s/m2]
    radius: float  # distance of the centre line from the hole's axis [m]
    nx: float  # outward normal
    ny: float
    nz: float
    tx: float  # the hole's axis, upwards
    ty: float
    tz: float


@kernel
def mean_force(stiffness: float, linear: float, before: float, after: float) -> Pair:
    """Mean force of the elastic wall over a step (discrete gradient of its energy), and its slope by the depth after.

    (V(after) - V(before)) / (after - before), with V = 2/5 K d^2.5 or K d^2 / 2 in contact and 0 off the wall, written
    without cancellation.

    Args:
        stiffness: K [N/m^2.5], or [N/m^2] of a linear wall.
        linear: 1 for the linear wall, else 0.
        before: Depth at the start of the step [m], negative off the wall.
        after: Depth at the end of the step [m]; one of the two depths is positive.
    """
    q, p = max(before, 0.0), max(after, 0.0)
    a, b = np.sqrt(q), np.sqrt(p)
    hertz = 0.4 * (q * q + q * a * b + q * p + p * a * b + p * p) / (a + b)
    steeper = 0.2 * (2.0 * q * a + 4.0 * q * b + 6.0 * p * a + 3.0 * p * b) / ((a + b) * (a + b))
    force = stiffness * (linear * 0.5 * (p + q) + (1.0 - linear) * hertz)
    slope = stiffness * (linear * 0.5 + (1.0 - linear) * steeper)
    if before <= 0.0 or after <= 0.0:  # contact in part of the step
        way = after - before
        force *= (p - q) / way
        slope = (stiffness * p * (linear + (1.0 - linear) * b) - force) / way
    return force, slope


@kernel
def contact_force(wall: Parameters, here: Point, half_step: float) -> Contact:
    """Normal force of the wall on the string per length over a step; zero off the wall.

    N = K d^p (1 + chi d_dot), not negative (Hertz; Hunt and Crossley 1975). d is the penetration of the string's
    surface into the wall: the paper's Eq. 12, with its missing condition d > 0.

    The elastic part is a discrete gradient between the ends of the step and conserves energy for any step (Gonzalez
    2000, Computer Methods in Applied Mechanics and Engineering 190); evaluated at mid-step, a long step could gain
    energy in an impact. With half_step = 0 it is the force at this instant.
    """
    off = axis_offset(wall.bore.axis, here.place, here.x, here.y, here.z)
    clearance = wall.bore.clearance[here.place]
    away = off.tx * here.vx + off.ty * here.vy + off.tz * here.vz
    wx, wy, wz = (
        half_step * (here.vx - away * off.tx),
        half_step * (here.vy - away * off.ty),
        half_step * (here.vz - away * off.tz),
    )
    ax, ay, az = off.x - wx, off.y - wy, off.z - wz
    bx, by, bz = off.x + wx, off.y + wy, off.z + wz
    square, later = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz
    before, after = np.sqrt(square), np.sqrt(later)
    if max(before, after) <= clearance:
        return Contact(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    radius = max(np.sqrt(off.x * off.x + off.y * off.y + off.z * off.z), SMALLEST)
    nx, ny, nz = off.x / radius, off.y / radius, off.z / radius
    spring, steeper = mean_force(wall.stiffness, wall.linear, before - clearance, after - clearance)
    # gradient of the distance over the chord between both ends, along the normal at mid-step
    chord = 2.0 * radius / (before + after)
    closing = chord * (nx * here.vx + ny * here.vy + nz * here.vz)
    factor = max(1.0 + wall.damping * closing, 0.0)
    lossy = wall.damping if factor > 0.0 else 0.0
    force = spring * factor * chord
    # the force increases along the normal at the end of the step and, by the chord, along that at mid-step
    share = 2.0 * half_step / (before + after)
    growth = chord * (2.0 * half_step * steeper * factor + spring * lossy) - share * force
    along = (bx * nx + by * ny + bz * nz) / after
    around = (
        bx * (off.ty * nz - off.tz * ny) + by * (off.tz * nx - off.tx * nz) + bz * (off.tx * ny - off.ty * nx)
    ) / after
    return Contact(
        force, growth * along + share * spring * factor, growth * around, radius, nx, ny, nz, off.tx, off.ty, off.tz
    )


@kernel
def dissipated_power(parameters: Any, here: Point, half_step: float) -> float:
    """Dissipated power per length [W/m]: the force beyond the elastic one, times the normal velocity."""
    wall = parameters.wall
    at = contact_force(wall, here, half_step)
    spring = contact_force(Parameters(wall.bore, wall.lever, wall.stiffness, wall.linear, 0.0), here, half_step).force
    return float((at.force - spring) * (at.nx * here.vx + at.ny * here.vy + at.nz * here.vz))


@kernel
def add_row(stiff: Array, i: int, at: Contact, on_n: float, on_c: float, cx: float, cy: float, cz: float) -> None:
    """Add multiples of the normal and of c to a row of the tangent."""
    stiff[i, 0] += on_n * at.nx + on_c * cx
    stiff[i, 1] += on_n * at.ny + on_c * cy
    stiff[i, 2] += on_n * at.nz + on_c * cz


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the normal force of the wall."""
    at = contact_force(parameters.wall, here, half_step)
    if at.force > 0.0:
        load[0] -= at.force * at.nx
        load[1] -= at.force * at.ny
        load[2] -= at.force * at.nz
        # the normal rotates with the point about the axis: c = t x n is the circumferential direction
        across = half_step * at.force / at.radius
        cx, cy, cz = at.ty * at.nz - at.tz * at.ny, at.tz * at.nx - at.tx * at.nz, at.tx * at.ny - at.ty * at.nx
        add_row(stiff, 0, at, at.slope * at.nx, at.swing * at.nx + across * cx, cx, cy, cz)
        add_row(stiff, 1, at, at.slope * at.ny, at.swing * at.ny + across * cy, cx, cy, cz)
        add_row(stiff, 2, at, at.slope * at.nz, at.swing * at.nz + across * cz, cx, cy, cz)
