# SPDX-License-Identifier: Apache-2.0
"""Spring along the whole string that draws it to the axis of a straight hole (Winkler foundation)."""

from typing import Annotated, Any, NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import LinearStiffness, Within
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import Rod
from drill_twin.physics.model.strain import Point


class LateralSpring(EffectConfig):
    """Force -k r per length of string."""

    energy_class = "kept"

    stiffness: Annotated[LinearStiffness, Within(at_least="0 N/m^2", at_most="1e9 N/m^2")]
    """Stiffness per length k [N/m^2]."""


class Parameters(NamedTuple):
    """Stiffness per length [N/m^2]."""

    stiffness: float


def parameters(block: LateralSpring, model: DiscreteModel) -> Parameters:
    """Uniform along the string."""
    return Parameters(block.stiffness)


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Force per length at mid-step; position grows with the velocity by half_step, hence the tangent k half_step."""
    k = parameters.lateral_spring.stiffness
    load[0] -= k * here.x
    load[1] -= k * here.y
    stiff[0, 0] += k * half_step
    stiff[1, 1] += k * half_step
