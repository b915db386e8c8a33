# SPDX-License-Identifier: Apache-2.0
"""A bit that drills: weight and torque by rate of penetration and speed, as mean law or as one random draw of it."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.effects.config import EffectConfig, Incompatibility, Seed
from drill_twin.effects.random_field import generator
from drill_twin.effects.random_matrix import MOST_SCATTER, random_matrix
from drill_twin.model.bit import BIT_TORQUE, DRILLED, carried, carry, pressed, rock_height
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import SPIN, Rod
from drill_twin.units import (
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


class BitCutting(EffectConfig):
    """Tucker and Wang's law (2003) with the constants of Ritto, Soize and Sampaio (2009).

    Weight set at the bit: the rate of penetration follows and the string stays where it is; weight set at the top: the
    string goes down with the bit, and what the rock gives is the weight on bit. The cutters face the way of positive
    speeds: a bit that turns backwards rubs and does not cut.
    """

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque", "weight")

    threshold: Annotated[Speed, Within(at_least="0 m/s", at_most="1 m/s")] = 3.429e-3
    """a1 [m/s]: how far the rate of penetration falls short of proportional."""
    cutting: Annotated[SpeedPerForce, Within(above="0 m/(N s)", at_most="1 m/(N s)")] = 5.672e-8
    """a2 [m/(N s)]: rate of penetration per weight on bit."""
    advance: Annotated[LengthPerAngle, Within(at_least="0 m/rad", at_most="1 m/rad")] = 1.374e-4
    """a3 [m/rad]: rate of penetration per speed of rotation."""
    digging: Annotated[ForceTimesAngle, Within(at_least="0 N rad", at_most="1e12 N rad")] = 9.537e6
    """a4 [N rad]: torque of cutting per depth of cut."""
    rubbing: Annotated[Torque, Within(at_least="0 N m", at_most="1e8 N m")] = 1.475e3
    """a5 [N m]: torque of rubbing."""
    regular_speed: Annotated[AngularSpeed, Within(above="0 rad/s", at_most="100 rad/s")] = 2.0
    """e [rad/s]: below this speed the law fades, by Z = w / sqrt(w^2 + e^2)."""
    rock_stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m")] | None = None
    """Stiffness of the rock under its cutters [N/m]; for a weight set at the top, and only there."""
    dispersion: Annotated[
        Dimensionless,
        Within(at_least="0", below=f"{MOST_SCATTER!r}", reason="sqrt(3/7), the law's limit"),
    ] = 0.0
    """How far one draw of the random law scatters about the mean law [-]; 0 = the mean law."""
    seed: Seed = 1
    """Of the draw, which holds for the run; `numerics.seed` moves it too."""

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:
        """Rock without stiffness under a weight set at the top, or with one under a weight that needs none."""
        at, place = scene.rig.weight_on_bit.at, ("rock_stiffness",)
        if at == "top" and self.rock_stiffness is None:
            yield Incompatibility(
                place, 'expected a stiffness such as "25e6 N/m" with `rig.weight_on_bit.at: top`, found none'
            )
        if at == "bit" and self.rock_stiffness is not None:
            yield Incompatibility(
                place, "expected none with `rig.weight_on_bit.at: bit`, found one: such a weight needs no rock"
            )


class Parameters(NamedTuple):
    """Constants a1 to a5 and e in SI units, random matrix, rock's stiffness [N/m] (0: weight at the bit), memory."""

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
    memory: Array  # height of the bottom of the hole [m], and 1 once that is known; (2,)


def parameters(block: BitCutting, model: DiscreteModel) -> Parameters:
    """Draw the random matrix."""
    drawn = random_matrix(block.dispersion, generator(model, block.seed, "bit_cutting"))
    return Parameters(
        block.threshold, block.cutting, block.advance, block.digging, block.rubbing, block.regular_speed,
        float(drawn[0, 0]), float(drawn[0, 1]), float(drawn[1, 1]), block.rock_stiffness or 0.0, np.zeros(2),
    )  # fmt: skip


class Cut(NamedTuple):
    """Weight and torque of the random law at one rate of penetration, with their slopes by it and by the speed."""

    weight: float
    weight_rate: float
    weight_speed: float
    torque: float
    torque_rate: float
    torque_speed: float


SLOWEST, FADED = 1e-9, 1e-8  # speed [rad/s] and Z^2 at which the law's poles are cut off
NO_RATE = 1e-9  # rate of penetration taken as none, where the random law has a pole [m/s]
BISECTIONS = 80


@kernel
def law(rock: Parameters, rate: float, speed: float) -> Cut:
    """The law at a rate of penetration x [m/s] and a speed w [rad/s].

    Mean law, with q = w^2 + e^2: weight x q / (a2 w^2) + (a1 - a3 sqrt(q)) / a2, not below the first term, and torque
    x a4 w / q + a5 w / sqrt(q) (Ritto, Soize and Sampaio 2009). It is a diagonal matrix A times (x, w); the random law
    is A^1/2 G A^1/2 with the random matrix G, so that power is never won. Without torque A has no root to mix
    weight with.
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
        return Cut(rock.axial * force, rock.axial * steep, rock.axial * force_w,
                   rock.turning * torque, rock.turning * dig, rock.turning * torque_w)  # fmt: skip
    both = rock.mixed * np.sqrt(force * torque * w / rate)
    both_x = 0.5 * both * (steep / force + dig / torque - 1.0 / rate)
    both_w = 0.5 * both * (force_w / force + torque_w / torque + 1.0 / w)
    share = rate / w
    return Cut(
        rock.axial * force + both, rock.axial * steep + both_x, rock.axial * force_w + both_w,
        rock.turning * torque + both * share, rock.turning * dig + both_x * share + both / w,
        rock.turning * torque_w + both_w * share - both * share / w,
    )  # fmt: skip


@kernel
def rate_of_penetration(rock: Parameters, push: float, spring: float, speed: float) -> float:
    """Rate x at which the law's weight is push - spring x [m/s]; 0 where the push is too small to cut.

    0 for a bit that turns backwards, too. The law's rate goes to nothing with w^2, and what is left of the torque is
    that of rubbing, which is odd in w: weight, torque and their slopes go smoothly through w = 0 (mean law).

    Args:
        rock: The law.
        push: Weight that would be on the bit if it did not advance [N].
        spring: What an advance takes off that weight [N s/m].
        speed: Speed of the bit [rad/s].
    """
    if push <= 0.0 or speed < 0.0:
        return 0.0
    rest = law(rock, 0.0, speed)
    fastest = (push - rest.weight) / (rest.weight_rate + spring)
    if rock.mixed == 0.0:
        return max(fastest, 0.0)
    # with a random matrix the law has a pole at rest: come from fast, where it rises, to the first slow enough rate
    high = max(fastest, NO_RATE)
    while law(rock, high, speed).weight + spring * high < push and high < 1.0:
        high *= 2.0
    low = high
    while law(rock, low, speed).weight + spring * low >= push:
        high = low
        low *= 0.8
        if low < NO_RATE:
            return 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if law(rock, middle, speed).weight + spring * middle < push:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def rubbing_share(rock: Parameters, weight: float, speed: float) -> float:
    """Share of the rubbing torque below the weight at which cutting begins: in proportion to the weight."""
    start = law(rock, 0.0, speed).weight
    return min(max(weight, 0.0) / start, 1.0) if start > 0.0 else (1.0 if weight > 0.0 else 0.0)


@kernel
def end_load(
    parameters: Any, rod: Rod, command: Array, time: float, h2: float, u: Array, v: Array, v_old: Array, ends: Array
) -> None:
    """Weight and torque of the rock at mid-step; the rate of penetration is found from them."""
    rock, bit, speed = parameters.bit_cutting, parameters.drive.bit, v[0, SPIN]
    push, spring, yields = pressed(bit), 0.0, 0.0
    if rock.stiffness > 0.0:
        if rock.memory[1] == 0.0:
            rock.memory[0] = rock_height(bit, rock.stiffness)
            rock.memory[1] = 1.0
        spring = rock.stiffness * h2
        push = max(rock.stiffness * (rock.memory[0] - u[0, 2]), 0.0)
        yields = spring if push > 0.0 else 0.0
    rate = rate_of_penetration(rock, push, spring, speed)
    cut = law(rock, rate, speed)
    if rate > 0.0:
        # d rate by push and by speed, from law(rate, speed) + spring rate = push
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
        carry(bit, weight, slower, ends)
        ends[0, 2, SPIN] -= weight_speed
    ends[0, SPIN, 7] += torque
    ends[0, SPIN, SPIN] += slope
    ends[0, SPIN, 2] += by_lift * yields


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Deepen the hole by what was drilled in the step taken, and count weight and torque."""
    rock, bit = parameters.bit_cutting, parameters.drive.bit
    speed, push, spring = bit.rate[SPIN], pressed(bit), 0.0
    if rock.stiffness > 0.0:
        spring = 0.5 * step * rock.stiffness
        push = max(rock.stiffness * (rock.memory[0] - 0.5 * (bit.start[2] + u[0, 2])), 0.0)
    rate = rate_of_penetration(rock, push, spring, speed)
    share = 1.0 if rate > 0.0 else rubbing_share(rock, push, speed)
    bit.impulse[BIT_TORQUE] -= step * share * law(rock, rate, speed).torque
    if rock.stiffness > 0.0:
        carried(bit, push - spring * rate, step)
        rock.memory[0] -= step * rate
    bit.impulse[DRILLED] += step * rate
