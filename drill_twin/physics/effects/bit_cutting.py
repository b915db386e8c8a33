# SPDX-License-Identifier: Apache-2.0
"""Drilling bit: rate of penetration and torque by weight and speed, mean law or one draw of a random one."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import (
    AngularSpeed,
    Dimensionless,
    ForceTimesAngle,
    LengthPerAngle,
    Speed,
    SpeedPerForce,
    Stiffness,
    Torque,
    Within,
)
from drill_twin.physics.effects.config import EffectConfig, Incompatibility, Seed
from drill_twin.physics.effects.cutting_law import Parameters, cutting_law, rate_of_penetration, rubbing_share
from drill_twin.physics.effects.random_draws import MOST_SCATTER, generator, random_matrix
from drill_twin.physics.model.bit import (
    BIT_TORQUE,
    DRILLED,
    apply_support,
    contact_weight,
    correct_weight_impulse,
    rock_height,
)
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import SPIN, Rod


class BitCutting(EffectConfig):
    """Tucker and Wang's law (2003) with the constants of Ritto, Soize and Sampaio (2009).

    Weight set at the bit: the rate of penetration follows, and the string does not descend; weight set at the top: the
    string descends with the bit, and the force of the rock is the weight on bit. The cutters act at positive speeds: a
    bit that rotates backwards rubs and does not cut.
    """

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque", "weight")
    seed_is_of = "dispersion"

    threshold: Annotated[Speed, Within(at_least="0 m/s", at_most="1 m/s")] = 3.429e-3
    """a1 [m/s]: rate of penetration lost against a proportional law."""
    cutting: Annotated[SpeedPerForce, Within(above="0 m/(N s)", at_most="1 m/(N s)")] = 5.672e-8
    """a2 [m/(N s)]: rate of penetration per weight on bit."""
    advance: Annotated[LengthPerAngle, Within(at_least="0 m/rad", at_most="1 m/rad")] = 1.374e-4
    """a3 [m/rad]: rate of penetration per speed of rotation."""
    digging: Annotated[ForceTimesAngle, Within(at_least="0 N rad", at_most="1e12 N rad")] = 9.537e6
    """a4 [N rad]: torque of cutting per depth of cut."""
    rubbing: Annotated[Torque, Within(at_least="0 N m", at_most="1e8 N m")] = 1.475e3
    """a5 [N m]: torque of rubbing."""
    regular_speed: Annotated[AngularSpeed, Within(above="0 rad/s", at_most="100 rad/s")] = 2.0
    """e [rad/s]: regularisation at low speed, by Z = w / sqrt(w^2 + e^2)."""
    rock_stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m")] | None = None
    """Stiffness of the rock under the cutters [N/m]; only with a weight set at the top."""
    dispersion: Annotated[
        Dimensionless, Within(at_least="0", below=f"{MOST_SCATTER!r}", reason="sqrt(3/7), the law's limit")
    ] = 0.0
    """Dispersion of the random law about the mean law [-]; 0 = the mean law."""
    seed: Seed = 1
    """Seed of the draw, one for the run; it depends on `numerics.seed` too."""

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:
        """Yield a missing stiffness with a weight set at the top, or a stiffness with a weight set at the bit."""
        at, place = scene.rig.weight_on_bit.at, ("rock_stiffness",)
        if at != "bit" and self.rock_stiffness is None:
            yield Incompatibility(
                place, 'expected a stiffness such as "25e6 N/m" with `rig.weight_on_bit.at: top`, found none'
            )
        if at == "bit" and self.rock_stiffness is not None:
            yield Incompatibility(
                place, "expected none with `rig.weight_on_bit.at: bit`, found one: such a weight needs no rock"
            )


def parameters(block: BitCutting, model: DiscreteModel) -> Parameters:
    """Draw the random matrix and set up the memory."""
    drawn = random_matrix(block.dispersion, generator(model, block.seed, "bit_cutting"))
    return Parameters(
        block.threshold, block.cutting, block.advance, block.digging, block.rubbing, block.regular_speed,
        float(drawn[0, 0]), float(drawn[0, 1]), float(drawn[1, 1]), block.rock_stiffness or 0.0, np.zeros(2),
    )  # fmt: skip


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
    """Add weight and torque of the rock at mid-step, after solving for the rate of penetration."""
    rock, bit, speed = parameters.bit_cutting, parameters.drive.bit, v[0, SPIN]
    push, spring, yields = contact_weight(bit), 0.0, 0.0
    if rock.stiffness > 0.0:
        if rock.memory[1] == 0.0:
            rock.memory[0] = rock_height(bit, rock.stiffness)
            rock.memory[1] = 1.0
        spring = rock.stiffness * half_step
        push = max(rock.stiffness * (rock.memory[0] - u[0, 2]), 0.0)
        yields = spring if push > 0.0 else 0.0
    rate = rate_of_penetration(rock, push, spring, speed)
    cut = cutting_law(rock, rate, speed)
    if rate > 0.0:
        # d rate by push and by speed, from cutting_law(rate, speed) + spring rate = push
        whole = 1.0 / (cut.weight_rate + spring)
        by_speed = -cut.weight_speed * whole
        weight, weight_speed = push - spring * rate, -spring * by_speed
        torque, slope, by_lift = cut.torque, cut.torque_speed + cut.torque_rate * by_speed, -cut.torque_rate * whole
        slower = yields * (1.0 - spring * whole)
    else:
        share = rubbing_share(rock, push, speed)
        weight, weight_speed, slower = push, 0.0, yields
        torque, slope = share * cut.torque, share * cut.torque_speed
        by_lift = -torque / push if push > 0.0 and share < 1.0 else 0.0
    if rock.stiffness > 0.0:
        apply_support(bit, weight, slower, ends)
        ends[0, 2, SPIN] -= weight_speed
    ends[0, SPIN, 7] += torque
    ends[0, SPIN, SPIN] += slope
    ends[0, SPIN, 2] += by_lift * yields


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Lower the bottom of the hole by the depth drilled in the step, and add the impulses of weight and torque."""
    rock, bit = parameters.bit_cutting, parameters.drive.bit
    speed, push, spring = bit.rate[SPIN], contact_weight(bit), 0.0
    if rock.stiffness > 0.0:
        spring = 0.5 * step * rock.stiffness
        push = max(rock.stiffness * (rock.memory[0] - 0.5 * (bit.start[2] + u[0, 2])), 0.0)
    rate = rate_of_penetration(rock, push, spring, speed)
    share = 1.0 if rate > 0.0 else rubbing_share(rock, push, speed)
    bit.impulse[BIT_TORQUE] -= step * share * cutting_law(rock, rate, speed).torque
    if rock.stiffness > 0.0:
        correct_weight_impulse(bit, push - spring * rate, step)
        rock.memory[0] -= step * rate
    bit.impulse[DRILLED] += step * rate
