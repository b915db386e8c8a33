# SPDX-License-Identifier: Apache-2.0
"""Lateral force or bending moment at the bit: pads of a steerable tool, a bent housing."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Angle, Force, Time, Torque, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import DiscreteModel, Rod

SLIDING, TILTING = ("sliding", "free", "stabilised"), ("pinned", "free", "stabilised")
"""Constraints of the bit that leave it free to move laterally, and to tilt."""


class BitSideForce(EffectConfig):
    """Constant lateral force and bending moment at the bit, fixed in space or rotating with the bit."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")

    force: Annotated[Force, Within(at_least="-10 MN", at_most="10 MN")] = 0.0
    """Force on the bit, across the axis of the hole [N]."""
    moment: Annotated[Torque, Within(at_least="-1e8 N m", at_most="1e8 N m")] = 0.0
    """Moment on the bit, about the axis normal to `angle`; positive bends the string as the force does [N m]."""
    angle: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg")] = 0.0
    """Direction of the force from +x, the low side [rad]; `with_bit`, from zero spin."""
    turns: Literal["with_hole", "with_bit"] = "with_hole"
    """`with_hole`: fixed in space, as the pads of a rotary steerable tool; `with_bit`: rotating, as a bent housing."""
    ramp: Annotated[Time, Within(at_least="0 s", at_most="1e6 s")] = 0.0
    """Duration of its cubic increase from the start of the run [s]; 0 s = a jump."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a constraint of the bit against which force or moment have no effect."""
        end = scene.string.bit_end
        for key, size, ends in (("force", self.force, SLIDING), ("moment", self.moment, TILTING)):
            if size != 0.0 and end not in ends:
                yield (
                    (key,),
                    (
                        f"expected `string.bit_end` to be one of {', '.join(ends)}, found {end}: "
                        f"a {key} cannot move such a bit"
                    ),
                )


class Parameters(NamedTuple):
    """Force [N], moment [N m], their direction [rad], 1 if it rotates with the bit, duration of the increase [s]."""

    force: float
    moment: float
    angle: float
    turning: float
    ramp: float


def parameters(block: BitSideForce, model: DiscreteModel) -> Parameters:
    """Parameters of the block."""
    return Parameters(block.force, block.moment, block.angle, float(block.turns == "with_bit"), block.ramp)


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
    """Add a force F and a moment m, both normal to the axis of the hole.

    The moment is conjugate to the angular velocity t x t_dot + omega t of the material
    (`drill_twin.physics.model.strain`): the force (m x a) / g^2 on a = r' and, for a bent string, the couple m.t on the
    spin.
    """
    law, bit = parameters.bit_side_force, ends[0]
    share = min(time / law.ramp, 1.0) if law.ramp > 0.0 else 1.0
    share *= share * (3.0 - 2.0 * share)
    angle = law.angle + law.turning * u[0, 6]
    cos, sin = np.cos(angle), np.sin(angle)
    force, moment = share * law.force, share * law.moment
    turning = half_step * law.turning
    bit[0, 7] -= force * cos
    bit[1, 7] -= force * sin
    bit[0, 6] += turning * force * sin
    bit[1, 6] -= turning * force * cos
    ax, ay, az = u[0, 3], u[0, 4], u[0, 5]
    g2 = ax * ax + ay * ay + az * az
    g = np.sqrt(g2)
    mx, my = moment * sin / g2, -moment * cos / g2
    fx, fy, fz = my * az, -mx * az, mx * ay - my * ax
    couple, fold = (mx * ax + my * ay) * g, max(g * (g + az), 1e-12)
    bit[3, 7] -= fx + couple * ay / fold
    bit[4, 7] -= fy - couple * ax / fold
    bit[5, 7] -= fz
    bit[6, 7] -= couple
    for i in range(3):
        f = fx if i == 0 else (fy if i == 1 else fz)
        for j in range(3):
            bit[3 + i, 3 + j] += 2.0 * half_step * f * u[0, 3 + j] / g2
    bit[3, 5] -= half_step * my
    bit[4, 5] += half_step * mx
    bit[5, 3] += half_step * my
    bit[5, 4] -= half_step * mx
    # the couple by r', where the string is bent in the plane of the moment, in which it is zero
    for j in range(2):
        slope = half_step * g * (mx if j == 0 else my)
        bit[3, 3 + j] -= slope * ay / fold
        bit[4, 3 + j] += slope * ax / fold
        bit[6, 3 + j] -= slope
    # rotation by d psi: (m_x, m_y) changes by (-m_y, m_x) d psi
    bit[3, 6] -= turning * mx * az
    bit[4, 6] -= turning * my * az
