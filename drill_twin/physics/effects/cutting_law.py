# SPDX-License-Identifier: Apache-2.0
"""Weight and torque of cutting by rate of penetration and speed: mean law, or one draw of the random one."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel


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
    x a4 w / q + a5 w / sqrt(q) (Ritto, Soize and Sampaio 2009). It is a diagonal matrix A times (x, w); the random law
    is A^1/2 G A^1/2 with the random matrix G, which is dissipative. Without torque A is singular, and its mean is used.
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
