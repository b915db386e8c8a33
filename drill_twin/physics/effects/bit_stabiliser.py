# SPDX-License-Identifier: Apache-2.0
"""Near-bit stabiliser: contact of its gauge with the wall of the hole."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Damping, Dimensionless, Length, RotationalStiffness, Stiffness, Within
from drill_twin.physics.effects.config import EffectConfig, Problem, too_large
from drill_twin.physics.effects.friction_dual import dual_variable, no_iterate
from drill_twin.physics.effects.wall import SMALLEST, mean_force
from drill_twin.physics.model import DiscreteModel, Rod

AT_THE_BIT = 1e-9  # of the string's length, from the bit up, where its gauge fits the hole


class BitStabiliser(EffectConfig):
    """Stabiliser for `string.bit_end: stabilised`: contact with the wall at its gauge, tilt free or restrained."""

    gauge: Annotated[Length, Within(above="0 m", at_most="20 m")]
    """Outer diameter [m]; at most the hole's."""
    stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m", reason="steel on rock has 1e8")]
    """Stiffness of the contact of its blades with the wall [N/m]."""
    damping: Annotated[Damping, Within(at_least="0 N s/m", at_most="1e9 N s/m")] = 0.0
    """Damping of that contact, without adhesion [N s/m]."""
    friction: Annotated[Dimensionless, Within(at_least="0", at_most="5")] = 0.0
    """Coulomb friction of its blades, on their slip across and along the wall, spin included [-]."""
    tilt_stiffness: Annotated[RotationalStiffness, Within(at_least="0 N m/rad", at_most="1e12 N m/rad")] = 0.0
    """Stiffness against tilt from the axis of the hole [N m/rad]; 0 = free to tilt."""

    creep: ClassVar[float] = 1e-3
    """Slip below which friction is proportional to it (regularisation) [m/s]."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a gauge above the diameter of the hole."""
        length = scene.length
        diameter = 2.0 * min(scene.hole.radius, scene.hole.least_radius(length * (1.0 - AT_THE_BIT), length))
        yield from too_large(("gauge",), self.gauge, diameter, "diameter of the hole")


class Parameters(NamedTuple):
    """Clearance, radius, stiffness, damping, friction, tilt stiffness and creep [SI units], and the last iterate."""

    clearance: float
    radius: float
    stiffness: float
    damping: float
    friction: float
    tilt: float
    creep: float
    memory: Array  # see `no_iterate`


def parameters(block: BitStabiliser, model: DiscreteModel) -> Parameters:
    """Compute the clearance of the blades in the hole at the bit; with less, no blade could be in its middle."""
    radius = 0.5 * block.gauge
    hole = float(model.wellbore.clearance[0] + model.contact_radius[0])  # the hole's radius at the bit
    return Parameters(
        max(hole - radius, SMALLEST), radius, block.stiffness, block.damping, block.friction, block.tilt_stiffness,
        block.creep, no_iterate(),
    )  # fmt: skip


class Contact(NamedTuple):
    """Contact of the blades over a step."""

    force: float  # on the wall [N]
    on_n: float  # its slope by the velocity along the outward normal [N s/m]
    on_c: float  # and around the hole [N s/m]
    swing: float  # change of the normal's direction by the velocity around the hole [s/m]
    nx: float  # outward normal at mid-step
    ny: float


@kernel
def contact(law: Parameters, x: float, y: float, vx: float, vy: float, half_step: float) -> Contact:
    """Normal force N = max(0, K d + C d_dot) over a step with its middle at (x, y); zero off the wall.

    The elastic part is a discrete gradient between the ends of the step, as the force of the wall is
    (`wall.contact_force`): evaluated at mid-step, a stiff contact adds energy in each impact. The damper works in the
    part of the step in contact: a jump of its force at first contact would leave the step without a solution.
    """
    bx, by = x + half_step * vx, y + half_step * vy
    before, after = np.hypot(x - half_step * vx, y - half_step * vy), np.hypot(bx, by)
    if max(before, after) <= law.clearance:
        return Contact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    q, p = max(before - law.clearance, 0.0), max(after - law.clearance, 0.0)
    spring, slope = mean_force(law.stiffness, 1.0, before - law.clearance, after - law.clearance)
    normal = spring + law.damping * (p - q) / (2.0 * half_step)
    if normal <= 0.0:
        return Contact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    slope = 2.0 * half_step * slope + (law.damping if p > 0.0 else 0.0)
    radius = max(np.hypot(x, y), SMALLEST)
    nx, ny = x / radius, y / radius
    # gradient of the distance over the chord between both ends, along the normal at mid-step
    share = 2.0 * half_step / (before + after)
    chord = 2.0 * radius / (before + after)
    growth = chord * (slope - share * normal)
    return Contact(
        chord * normal,
        growth * (bx * nx + by * ny) / after + share * normal,
        growth * (by * nx - bx * ny) / after,
        half_step / radius, nx, ny,
    )  # fmt: skip


@kernel
def add_row(bit: Array, i: int, on_n: float, on_c: float, on_z: float, on_spin: float, at: Contact) -> None:
    """Add a row of the tangent, given by the velocities along the normal, around and along the hole, and of spin."""
    bit[i, 0] += on_n * at.nx - on_c * at.ny
    bit[i, 1] += on_n * at.ny + on_c * at.nx
    bit[i, 2] += on_z
    bit[i, 6] += on_spin


@kernel
def end_load(
    parameters: Any,
    rod: Rod,
    command: Array,
    time: float,
    half_step: float,
    u: Array,
    v: Array,
    v_old: Array,
    ends: Array,
) -> None:
    """Add the normal force N at the blades, and mu N s / sqrt(|s|^2 + creep^2) at their slip s."""
    law, bit = parameters.bit_stabiliser, ends[0]
    for c in range(3, 5):
        bit[c, c] += law.tilt * half_step
        bit[c, 7] += law.tilt * u[0, c]
    at = contact(law, u[0, 0], u[0, 1], v[0, 0], v[0, 1], half_step)
    if at.force <= 0.0:
        return
    arm, memory = law.radius, law.memory
    slip, along = at.nx * v[0, 1] - at.ny * v[0, 0] + arm * v[0, 6], v[0, 2]
    size = np.sqrt(slip * slip + along * along + law.creep * law.creep)
    st, sz = slip / size, along / size
    ft, fz = law.friction * at.force * st, law.friction * at.force * sz
    bit[0, 7] += at.force * at.nx - ft * at.ny
    bit[1, 7] += at.force * at.ny + ft * at.nx
    bit[2, 7] += fz
    bit[6, 7] += arm * ft
    first_iteration = memory[6] != time or memory[7] != half_step
    dt, dz = dual_variable(memory, first_iteration, memory[5] + 1.0, slip, along, size, 1.0)
    memory[6], memory[7] = time, half_step
    # friction depends on the normal force: unsymmetric
    scale = law.friction * at.force / size
    tt, zz, mixed = scale * (1.0 - dt * st), scale * (1.0 - dz * sz), -0.5 * scale * (dt * sz + dz * st)
    tn, zn = law.friction * at.on_n * st, law.friction * at.on_n * sz
    turned = 1.0 - at.swing * (at.nx * v[0, 0] + at.ny * v[0, 1])  # the direction of slip turns with the normal
    tc, zc = law.friction * at.on_c * st + tt * turned, law.friction * at.on_c * sz + mixed * turned
    nc, cc = at.on_c - at.swing * ft, tc + at.swing * at.force
    add_row(bit, 0, at.on_n * at.nx - tn * at.ny, nc * at.nx - cc * at.ny, -mixed * at.ny, -arm * tt * at.ny, at)
    add_row(bit, 1, at.on_n * at.ny + tn * at.nx, nc * at.ny + cc * at.nx, mixed * at.nx, arm * tt * at.nx, at)
    add_row(bit, 2, zn, zc, zz, arm * mixed, at)
    add_row(bit, 6, arm * tn, arm * tc, arm * mixed, arm * arm * tt, at)
