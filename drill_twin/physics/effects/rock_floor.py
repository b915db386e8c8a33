# SPDX-License-Identifier: Apache-2.0
"""Elastic rock under the bit that is not drilled: it supports a weight set at the top; the bit may lift off.

Its surface may have lobes, as under the three cones of a bit, which lift the bit as often in a revolution.
"""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Damping, Dimensionless, Length, Stiffness, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import SPIN, DiscreteModel, Rod
from drill_twin.physics.model.bit import BIT_TORQUE, apply_support, correct_weight_impulse, rock_height


class RockFloor(EffectConfig):
    """Unilateral spring and damper under the bit, for a weight `at: top` or `block`; its force is the weight on bit.

    With a `lobe_height` a the surface is a cos(n psi) high at the angle psi of the bit, with n `lobes`: the bottom that
    the cones of a bit leave (Dareing 1984). It stays where it is: nothing drills it, and its height is an input.
    """

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("weight",)

    stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m", reason="the whole string has 1e6")]
    """Stiffness of rock and bit face [N/m]."""
    damping: Annotated[Damping, Within(at_least="0 N s/m", at_most="1e9 N s/m")] = 0.0
    """Damping, without adhesion [N s/m]."""
    lobes: Annotated[Dimensionless, Within(at_least="1", at_most="100")] = 3.0
    """Lobes in a revolution, a whole number; without a `lobe_height` their number changes nothing."""
    lobe_height: Annotated[Length, Within(at_least="0 m", at_most="0.1 m")] = 0.0
    """Height of the lobes, half of the distance from trough to crest [m]."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a weight prescribed at the bit."""
        if scene.rig.weight_on_bit.at == "bit":
            yield (
                (),
                (
                    "expected `rig.weight_on_bit.at: top` or `block`, found bit: "
                    "a weight prescribed at the bit needs no rock to support it"
                ),
            )


class Parameters(NamedTuple):
    """Stiffness [N/m], damping [N s/m], lobes, their height [m], and height of the rock [m] with 1 once it is known."""

    stiffness: float
    damping: float
    lobes: float
    lobe_height: float
    memory: Array


class Contact(NamedTuple):
    """Upward force of the rock [N], its stiffness [N/m] and damping [N s/m], slope and curvature of the surface."""

    force: float
    stiffness: float
    damping: float
    slope: float
    """Rise of the surface by the bit's angle [m/rad]."""
    curvature: float
    """[m/rad^2]."""


def parameters(block: RockFloor, model: DiscreteModel) -> Parameters:
    """Parameters of the block; the height of the rock is set at the first step from the height of the bit."""
    return Parameters(block.stiffness, block.damping, block.lobes, block.lobe_height, np.zeros(2))


@kernel
def contact(rock: Parameters, place: float, rate: float, angle: float, speed: float) -> Contact:
    """Force of the rock at a height [m], angle [rad], vertical [m/s] and angular velocity [rad/s] of the bit."""
    rise = rock.lobe_height * np.cos(rock.lobes * angle)
    slope = -rock.lobe_height * rock.lobes * np.sin(rock.lobes * angle)
    curvature = -rock.lobes * rock.lobes * rise
    force = rock.stiffness * (rock.memory[0] + rise - place) + rock.damping * (slope * speed - rate)
    if force <= 0.0:
        return Contact(0.0, 0.0, 0.0, slope, curvature)
    return Contact(force, rock.stiffness, rock.damping, slope, curvature)


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
    """Add W = max(0, K d + C d_dot) at the depth d of the bit below the rock's surface, and its torque.

    The torque against the spin is W times the rise of the surface by angle, as the surface is without friction.
    """
    rock, bit, speed = parameters.rock_floor, parameters.drive.bit, v[0, SPIN]
    if rock.memory[1] == 0.0:
        rock.memory[0] = rock_height(bit, rock.stiffness) - rock.lobe_height * np.cos(rock.lobes * bit.start[SPIN])
        rock.memory[1] = 1.0
    floor = contact(rock, u[0, 2], v[0, 2], u[0, SPIN], speed)
    lift = half_step * floor.stiffness + floor.damping  # loss of force by the vertical velocity
    turn = lift * floor.slope + half_step * floor.damping * floor.curvature * speed  # gain by the angular velocity
    apply_support(bit, floor.force, lift, ends)
    ends[0, 2, SPIN] -= turn
    ends[0, SPIN, 7] += floor.force * floor.slope
    ends[0, SPIN, 2] -= lift * floor.slope
    ends[0, SPIN, SPIN] += turn * floor.slope + half_step * floor.force * floor.curvature


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Correct the impulse of the weight on bit, and add the impulse of the torque."""
    rock, bit = parameters.rock_floor, parameters.drive.bit
    place, angle = 0.5 * (bit.start[2] + u[0, 2]), 0.5 * (bit.start[SPIN] + u[0, SPIN])
    floor = contact(rock, place, bit.rate[2], angle, bit.rate[SPIN])
    correct_weight_impulse(bit, floor.force, step)
    bit.impulse[BIT_TORQUE] -= step * floor.force * floor.slope
