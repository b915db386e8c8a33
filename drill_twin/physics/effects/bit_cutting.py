# SPDX-License-Identifier: Apache-2.0
"""Drilling bit: rate of penetration and torque by weight and speed, mean law or one draw of a random law.

The law gives weight and torque of cutting by rate of penetration and speed; the rate is solved for.
"""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

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
from drill_twin.physics.effects.config import EffectConfig, Problem, Seed
from drill_twin.physics.effects.random_draws import MOST_SCATTER, generator, random_matrix
from drill_twin.physics.model import SPIN, DiscreteModel, Rod
from drill_twin.physics.model.bit import (
    BIT_TORQUE,
    DRILLED,
    apply_support,
    contact_weight,
    correct_weight_impulse,
    rock_height,
)


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

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a missing stiffness with a weight set at the top, or a stiffness with a weight set at the bit."""
        at, place = scene.rig.weight_on_bit.at, ("rock_stiffness",)
        if at != "bit" and self.rock_stiffness is None:
            yield (place, 'expected a stiffness such as "25e6 N/m" with `rig.weight_on_bit.at: top`, found none')
        if at == "bit" and self.rock_stiffness is not None:
            yield (place, "expected none with `rig.weight_on_bit.at: bit`, found one: such a weight needs no rock")


class Parameters(NamedTuple):
    """Constants a1 to a5 and e in SI units, random matrix, rock stiffness [N/m] (0: weight at the bit), memory."""

    threshold: float
    cutting: float
    advance: float
    digging: float
    rubbing: float
    regular: float
    axial: float  # the random matrix's entries
    mixed: float
    turning: float
    stiffness: float
    memory: Array  # height of the bottom of the hole [m], and 1 once it is initialised; (2,)


class CuttingForces(NamedTuple):
    """Weight [N] and torque [N m] at a rate of penetration, with their slopes by it and by the speed."""

    weight: float
    weight_rate: float
    weight_speed: float
    torque: float
    torque_rate: float
    torque_speed: float


SLOWEST, FADED = 1e-9, 1e-8  # speed [rad/s] and Z^2 at which the law's poles are cut off
NO_RATE = 1e-9  # rate of penetration treated as zero, where the random law has a pole [m/s]
BISECTIONS = 80


@kernel
def cutting_law(rock: Parameters, rate: float, speed: float) -> CuttingForces:
    """Evaluate the law at a rate of penetration x [m/s] and a speed w [rad/s].

    Mean law, with q = w^2 + e^2: weight x q / (a2 w^2) + (a1 - a3 sqrt(q)) / a2, not below the first term, and torque
    x a4 w / q + a5 w / sqrt(q) (Ritto, Soize and Sampaio 2009). The mean law is a diagonal matrix A times (x, w);
    the random law is A^1/2 G A^1/2 with the random matrix G, which is dissipative. Without torque A is singular: only
    the diagonal of G acts.
    """
    w = speed if abs(speed) > SLOWEST else SLOWEST
    q = w * w + rock.regular * rock.regular
    root = np.sqrt(q)
    start, start_w = rock.threshold - rock.advance * root, -rock.advance * w / root
    if start <= 0.0:
        start, start_w = 0.0, 0.0
    z2 = w * w / q
    steep, steep_w = 1.0 / (rock.cutting * z2), -2.0 * rock.regular * rock.regular / (rock.cutting * w * w * w)
    if z2 < FADED:
        steep, steep_w = 1.0 / (rock.cutting * FADED), 0.0
    force, force_w = start / rock.cutting + steep * rate, start_w / rock.cutting + steep_w * rate
    dig = rock.digging * w / q
    torque = dig * rate + rock.rubbing * w / root
    torque_w = rate * rock.digging * (q - 2.0 * w * w) / (q * q) + rock.rubbing * rock.regular**2 / (q * root)
    if rock.mixed == 0.0 or rate < NO_RATE or force <= 0.0 or torque == 0.0:
        return CuttingForces(rock.axial * force, rock.axial * steep, rock.axial * force_w,
                   rock.turning * torque, rock.turning * dig, rock.turning * torque_w)  # fmt: skip
    both = rock.mixed * np.sqrt(force * torque * w / rate)
    both_x = 0.5 * both * (steep / force + dig / torque - 1.0 / rate)
    both_w = 0.5 * both * (force_w / force + torque_w / torque + 1.0 / w)
    share = rate / w
    return CuttingForces(
        rock.axial * force + both, rock.axial * steep + both_x, rock.axial * force_w + both_w,
        rock.turning * torque + both * share, rock.turning * dig + both_x * share + both / w,
        rock.turning * torque_w + both_w * share - both * share / w,
    )  # fmt: skip


@kernel
def rate_of_penetration(rock: Parameters, push: float, spring: float, speed: float) -> float:
    """Solve for the rate x at which the law's weight is push - spring x [m/s]; 0 if the push is too small to cut.

    0 also for a bit that rotates backwards. The rate vanishes with w^2, and the remaining torque of rubbing is odd in
    w: weight, torque and their slopes are continuous at w = 0 (mean law).

    Args:
        rock: The law.
        push: Weight on bit without penetration [N].
        spring: Decrease of that weight by the rate of penetration [N s/m].
        speed: Speed of the bit [rad/s].
    """
    if push <= 0.0 or speed < 0.0:
        return 0.0
    rest = cutting_law(rock, 0.0, speed)
    fastest = (push - rest.weight) / (rest.weight_rate + spring)
    if rock.mixed == 0.0:
        return max(fastest, 0.0)
    # with a random matrix the law has a pole at zero rate: bracket from fast rates, where it rises, then bisect
    high = max(fastest, NO_RATE)
    while cutting_law(rock, high, speed).weight + spring * high < push and high < 1.0:
        high *= 2.0
    low = high
    while cutting_law(rock, low, speed).weight + spring * low >= push:
        high = low
        low *= 0.8
        if low < NO_RATE:
            return 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if cutting_law(rock, middle, speed).weight + spring * middle < push:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def rubbing_share(rock: Parameters, weight: float, speed: float) -> float:
    """Share of the rubbing torque below the weight at which cutting begins: proportional to the weight."""
    start = cutting_law(rock, 0.0, speed).weight
    return min(max(weight, 0.0) / start, 1.0) if start > 0.0 else (1.0 if weight > 0.0 else 0.0)


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
