# SPDX-License-Identifier: Apache-2.0
"""Near-bit stabiliser: contact of its gauge with the wall of the hole."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.effects.config import EffectConfig, Incompatibility
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import Rod
from drill_twin.units import Damping, Dimensionless, Length, RotationalStiffness, Stiffness, Within


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

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:
        """Yield another constraint of the bit, or a gauge above the diameter of the hole."""
        end, diameter = scene.string.bit_end, 2.0 * scene.hole.radius
        if end != "stabilised":
            yield Incompatibility(
                (),
                "expected `string.bit_end: stabilised` and `effects.bit_stabiliser` together, "
                f"found bit_end {end} with a bit_stabiliser",
            )
        if self.gauge > diameter:
            yield Incompatibility(
                ("gauge",),
                f"expected at most the diameter of the hole ({diameter:.6g} m), found {self.gauge:.6g} m",
            )


class Parameters(NamedTuple):
    """Clearance and radius [m], stiffness [N/m], damping [N s/m], friction, tilt stiffness [N m], creep [m/s]."""

    clearance: float
    radius: float
    stiffness: float
    damping: float
    friction: float
    tilt: float
    creep: float


def parameters(block: BitStabiliser, model: DiscreteModel) -> Parameters:
    """Compute the clearance of the blades in the hole at the bit."""
    radius = 0.5 * block.gauge
    hole = model.wellbore.clearance[0] + model.contact_radius[0]  # the hole's radius at the bit
    return Parameters(
        float(hole) - radius, radius, block.stiffness, block.damping, block.friction, block.tilt_stiffness,
        block.creep,
    )  # fmt: skip


@kernel
def end_load(
    parameters: Any, rod: Rod, command: Array, time: float, h2: float, u: Array, v: Array, v_old: Array, ends: Array
) -> None:
    """Add N = max(0, K d + C d_dot) at penetration d of the blades, and mu N s / sqrt(|s|^2 + creep^2) at slip s."""
    law, bit = parameters.bit_stabiliser, ends[0]
    for c in range(3, 5):
        bit[c, c] += law.tilt * h2
        bit[c, 7] += law.tilt * u[0, c]
    x, y = u[0, 0], u[0, 1]
    radius = np.sqrt(x * x + y * y)
    if radius <= law.clearance or radius == 0.0:
        return
    nx, ny = x / radius, y / radius
    force = law.stiffness * (radius - law.clearance) + law.damping * (nx * v[0, 0] + ny * v[0, 1])
    if force <= 0.0:
        return
    slope, around = law.stiffness * h2 + law.damping, h2 * force / radius
    slip, along = nx * v[0, 1] - ny * v[0, 0] + law.radius * v[0, 6], v[0, 2]
    size = np.sqrt(slip * slip + along * along + law.creep * law.creep)
    limit = law.friction * force
    ft, fz = limit * slip / size, limit * along / size
    bit[0, 7] += force * nx - ft * ny
    bit[1, 7] += force * ny + ft * nx
    bit[2, 7] += fz
    bit[6, 7] += law.radius * ft
    # d force on (n, across, along, spin) by the same; friction depends on the normal force: unsymmetric
    tt, tz, zz = (
        limit / size * (1.0 - (slip / size) ** 2),
        -ft * along / size**2,
        limit / size * (1.0 - (along / size) ** 2),
    )
    tn, zn = law.friction * slope * slip / size, law.friction * slope * along / size
    nn, cross = slope, around + tt
    bit[0, 0] += nn * nx * nx - tn * ny * nx + cross * ny * ny
    bit[0, 1] += nn * nx * ny - tn * ny * ny - cross * nx * ny
    bit[1, 0] += nn * nx * ny + tn * nx * nx - cross * nx * ny
    bit[1, 1] += nn * ny * ny + tn * nx * ny + cross * nx * nx
    bit[0, 2] -= tz * ny
    bit[1, 2] += tz * nx
    bit[0, 6] -= tt * law.radius * ny
    bit[1, 6] += tt * law.radius * nx
    bit[2, 0] += zn * nx - tz * ny
    bit[2, 1] += zn * ny + tz * nx
    bit[2, 2] += zz
    bit[2, 6] += tz * law.radius
    bit[6, 0] += law.radius * (tn * nx - tt * ny)
    bit[6, 1] += law.radius * (tn * ny + tt * nx)
    bit[6, 2] += law.radius * tz
    bit[6, 6] += law.radius * law.radius * tt
