# SPDX-License-Identifier: Apache-2.0
"""Elastic rock under the bit that is not drilled: it supports a weight set at the top; the bit may lift off."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Damping, Stiffness, Within
from drill_twin.physics.effects.config import EffectConfig, Incompatibility
from drill_twin.physics.model import DiscreteModel, Rod
from drill_twin.physics.model.bit import apply_support, correct_weight_impulse, rock_height


class RockFloor(EffectConfig):
    """Unilateral spring and damper under the bit, for a weight `at: top` or `block`; its force is the weight on bit."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("weight",)

    stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m", reason="the whole string has 1e6")]
    """Stiffness of rock and bit face [N/m]."""
    damping: Annotated[Damping, Within(at_least="0 N s/m", at_most="1e9 N s/m")] = 0.0
    """Damping, without adhesion [N s/m]."""

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:
        """Yield a weight prescribed at the bit."""
        if scene.rig.weight_on_bit.at == "bit":
            yield Incompatibility(
                (),
                "expected `rig.weight_on_bit.at: top` or `block`, found bit: "
                "a weight prescribed at the bit needs no rock to support it",
            )


class Parameters(NamedTuple):
    """Stiffness [N/m], damping [N s/m], and height of the rock [m] with 1 once it is initialised."""

    stiffness: float
    damping: float
    memory: Array


def parameters(block: RockFloor, model: DiscreteModel) -> Parameters:
    """Parameters of the block; the height of the rock is set at the first step from the height of the bit."""
    return Parameters(block.stiffness, block.damping, np.zeros(2))


@kernel
def rock_force(rock: Parameters, place: float, rate: float) -> Pair:
    """Upward force of the rock at a height [m] and velocity [m/s] of the bit [N], and its stiffness [N/m]."""
    force = rock.stiffness * (rock.memory[0] - place) - rock.damping * rate
    return (force, rock.stiffness) if force > 0.0 else (0.0, 0.0)


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
    """Add W = max(0, K d + C d_dot) at the depth d of the bit below the rock's surface."""
    rock, bit = parameters.rock_floor, parameters.drive.bit
    if rock.memory[1] == 0.0:
        rock.memory[0] = rock_height(bit, rock.stiffness)
        rock.memory[1] = 1.0
    force, slope = rock_force(rock, u[0, 2], v[0, 2])
    apply_support(bit, force, half_step * slope + (rock.damping if slope > 0.0 else 0.0), ends)


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Correct the impulse of the weight on bit."""
    rock, bit = parameters.rock_floor, parameters.drive.bit
    correct_weight_impulse(bit, rock_force(rock, 0.5 * (bit.start[2] + u[0, 2]), bit.rate[2])[0], step)
