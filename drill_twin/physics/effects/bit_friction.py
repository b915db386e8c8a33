# SPDX-License-Identifier: Apache-2.0
"""Friction of the rotating bit on the rock, viscous for small lateral velocities."""

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, Length, Within
from drill_twin.physics.effects.bit_torque_stribeck import dual_of_step, sign_missed
from drill_twin.physics.effects.config import EffectConfig, Problem, too_large
from drill_twin.physics.effects.friction_dual import no_iterate
from drill_twin.physics.model import SPIN, DiscreteModel, Rod
from drill_twin.physics.model.bit import BIT_TORQUE, contact_weight

SLIDING = ("sliding", "free")
"""Constraints of the bit that let it slide laterally."""


class BitFriction(EffectConfig):
    """Coulomb friction of the rotating, laterally sliding bit; damping mu P / (Omega radius) at low slip."""

    provides = ("torque",)
    energy_class = "heat"
    disabled_for_static = ("coefficient",)

    coefficient: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient of bit on rock [-]."""
    radius: Annotated[Length, Within(above="0 m", at_most="2 m")]
    """Effective radius of friction [m]; at most the hole's radius."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield friction of a bit that cannot slide, or a radius above the hole's radius."""
        if self.coefficient > 0.0 and scene.string.bit_end not in SLIDING:
            yield (
                (),
                (
                    f"expected `string.bit_end` to be {' or '.join(SLIDING)}, found {scene.string.bit_end}: "
                    "a bit held on the axis does not slide"
                ),
            )
        yield from too_large(("radius",), self.radius, scene.hole.radius, "radius of the hole")


class Parameters(NamedTuple):
    """Coefficient, radius [m], and the last Newton iterate of the rim's speed."""

    coefficient: float
    radius: float
    memory: Array  # see `no_iterate`


def parameters(block: BitFriction, model: DiscreteModel) -> Parameters:
    """Parameters of the block, without an iterate."""
    return Parameters(block.coefficient, block.radius, no_iterate())


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
    """Add Coulomb friction of a face in rotation and translation: mu P v / sqrt(v^2 + (Omega r)^2), and its couple.

    Rotation turns dry friction into viscous drag mu P / (Omega r) for small v.
    """
    law = parameters.bit_friction
    weight = contact_weight(parameters.drive.bit)
    vx, vy, spin = v[0, 0], v[0, 1], v[0, 6]
    rim = law.radius * spin
    size = np.sqrt(vx * vx + vy * vy + rim * rim + 1e-12)
    c, share = law.coefficient * weight / size, dual_of_step(law.memory, time, half_step, rim, size)
    d = ends[0]
    d[0, 0] += c
    d[1, 1] += c
    d[6, 6] += c * law.radius * law.radius * (1.0 - share * rim / size)
    d[0, 7] += c * vx
    d[1, 7] += c * vy
    d[6, 7] += c * law.radius * rim


@kernel
def missed(parameters: Any, v: Array) -> float:
    """Share of the friction around the string by which it will change in the next iteration."""
    return float(sign_missed(parameters.bit_friction.memory, parameters.bit_friction.radius * v[0, SPIN]))


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Add the impulse of the torque in the step."""
    law, bit = parameters.bit_friction, parameters.drive.bit
    rim = law.radius * bit.rate[SPIN]
    slide = np.sqrt(bit.rate[0] ** 2 + bit.rate[1] ** 2 + rim * rim + 1e-12)
    bit.impulse[BIT_TORQUE] -= step * law.coefficient * contact_weight(bit) * law.radius * rim / slide
