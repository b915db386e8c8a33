# SPDX-License-Identifier: Apache-2.0
"""Drag bit whose blades cut what the blade before has left: cutters and wear flats, with memory of the rock.

The depth of cut depends on the bit's position one blade spacing of rotation ago, a delay that depends on the motion
(Richard, Germay and Detournay 2007). The rock's surface is kept over the angle, not over time: a blade spacing of it in
cells of equal angle, so its memory is bounded however slowly the bit turns, and a sticking bit writes nothing.
"""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import AngularSpeed, Dimensionless, Length, Pressure, Speed, Whole, Within
from drill_twin.physics.effects.bit_torque_stribeck import dual_of_step, sign_missed
from drill_twin.physics.effects.config import EffectConfig, Flag, Problem
from drill_twin.physics.effects.friction_dual import no_iterate
from drill_twin.physics.model import SPIN, DiscreteModel, Rod
from drill_twin.physics.model.bit import BIT_TORQUE, DRILLED, Bit, apply_support, correct_weight_impulse

MOST_BLADES = 100
CELLS = 512
"""Cells of the rock's surface in a blade spacing."""
READY, NEWEST, ORIGIN, FARTHEST, DEEPEST = range(5)
"""Indices into the memory: 1 once the surface is set, number of its newest cell, angle of cell 0 and farthest angle of
the bit [rad], lowest place of the surface [m]."""


class BitRegenerative(EffectConfig):
    """Cutting and friction of a drag bit, with T = a/2 (eps a d + mu gamma Wf) and W = zeta eps a d + Wf.

    The laws follow Detournay and Defourny (1992). The depth of cut d of n blades is regenerative (Richard, Germay
    and Detournay 2007): n times the depth of the bit below the surface that it left 2 pi / n of rotation before. A bit
    that turns backwards does not cut: the surface stays, and the same torque is against the rotation.
    """

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque", "weight")

    radius: Annotated[Length, Within(above="0 m", at_most="2 m")]
    """Radius of the bit, a [m]."""
    blades: Annotated[int, Whole(1, MOST_BLADES)] = 4
    """Blades, evenly spaced, n; without regeneration their number changes nothing."""
    specific_energy: Annotated[Pressure, Within(above="0 Pa", at_most="1e11 Pa")]
    """Intrinsic specific energy of the rock, eps [Pa]."""
    thrust: Annotated[Dimensionless, Within(above="0", at_most="10")] = 0.6
    """Thrust over cutting force of a cutter, zeta [-]."""
    wear: Annotated[Length, Within(at_least="0 m", at_most="1 m")] = 0.0
    """Length of all wear flats together across the cutters, l [m]; 0 m = a sharp bit, which has no friction, `spread`,
    `contact_depth` and `settling`."""
    contact_strength: Annotated[Pressure, Within(at_least="0 Pa", at_most="1e11 Pa")] = 0.0
    """Contact stress under the wear flats while the bit goes down, sigma [Pa]: their weight is Wf = a l sigma."""
    friction: Annotated[Dimensionless, Within(at_least="0", at_most="5")] = 0.6
    """Friction coefficient of the wear flats, mu [-]."""
    spread: Annotated[Dimensionless, Within(above="0", at_most="4", reason="1 to 4/3 for flat bits")] = 1.0
    """Distribution of the wear flats over the radius, gamma [-]."""
    regeneration: Flag = True
    """False: depth of cut 2 pi V / Omega of the present speeds, without memory (Detournay and Defourny 1992)."""
    contact_depth: Annotated[Length, Within(above="0 m", at_most="0.1 m")] = 1e-5
    """Depth of cut from which the wear flats are in full contact [m] (Detournay, Richard and Shepherd 2008)."""
    settling: Annotated[Speed, Within(at_least="1e-12 m/s", at_most="0.01 m/s")] = 1e-6
    """Speed of regularisation of the wear flats' contact [m/s]: half of it is lost at axial rest."""
    creep: Annotated[AngularSpeed, Within(at_least="1e-9 rad/s", at_most="0.1 rad/s")] = 1e-3
    """Speed of regularisation of the torque: a sticking bit creeps below it [rad/s]."""

    def torque_arm(self, weight: float) -> float:
        """Torque over weight in steady drilling under a weight [N]: a length [m]; 0 without weight."""
        worn = min(self.radius * self.wear * self.contact_strength, weight)
        if weight <= 0.0:
            return 0.0
        return 0.5 * self.radius * ((weight - worn) / self.thrust + self.friction * self.spread * worn) / weight

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a weight prescribed at the bit, and wear flats that carry nothing."""
        missing = self.contact_strength > 0.0 and "wear" not in self.model_fields_set
        if missing or (self.wear > 0.0 and self.contact_strength == 0.0):
            given, other = ("contact_strength", "wear") if missing else ("wear", "contact_strength")
            yield ((given,), f"expected `{other}` with it, found none: the wear flats would carry no weight")
        if scene.rig.weight_on_bit.at == "bit":
            yield (
                (),
                (
                    "expected `rig.weight_on_bit.at: top` or `block`, found bit: the depth of cut needs a string that "
                    "descends with its bit"
                ),
            )


class Parameters(NamedTuple):
    """Constants of the law per depth of cut of all blades, and the rock's surface."""

    axial: float  # zeta eps a [N/m]
    turning: float  # eps a^2 / 2 [N]
    worn: float  # a l sigma [N]
    arm: float  # mu gamma a / 2 [m]
    blades: float
    regenerative: float  # 1, or 0 for the depth of cut by the present speeds
    contact_depth: float  # [m]
    settling: float  # [m/s]
    creep: float  # [rad/s]
    surface: Array  # height over the angle, a ring of CELLS + 2 cells [m]
    memory: Array  # (5,) see READY
    turn_iterate: Array  # of the torque's sign, see `no_iterate`
    fall_iterate: Array  # of the wear flats' contact


class Forces(NamedTuple):
    """Weight [N] and torque limit [N m], each with its slopes by the depth of cut and by the speed downwards."""

    weight: float
    weight_depth: float
    weight_fall: float
    torque: float
    torque_depth: float
    torque_fall: float


class Regeneration(NamedTuple):
    """Linear regeneration about steady drilling: force b (c.q(t) - c.q(t - delay)) with q = (z, psi) of the bit."""

    delay: float  # [s]
    rate: float  # of penetration [m/s]
    force: Array  # b, downwards and against the rotation, by depth of one blade [N/m, N]; (2,)
    arm: Array  # c (1, m/rad); (2,)


def parameters(block: BitRegenerative, model: DiscreteModel) -> Parameters:
    """Parameters of the block; the surface is set at the first step."""
    area = block.specific_energy * block.radius
    return Parameters(
        block.thrust * area, 0.5 * area * block.radius, block.radius * block.wear * block.contact_strength,
        0.5 * block.friction * block.spread * block.radius, float(block.blades), float(block.regeneration),
        block.contact_depth, block.settling, block.creep,
        np.zeros(CELLS + 2), np.zeros(5), no_iterate(), no_iterate(),
    )  # fmt: skip


def regeneration(rock: Parameters, weight: float, speed: float) -> Regeneration | None:
    """Linear regeneration in steady drilling at a weight [N] and a speed [rad/s]; None where the bit does not drill."""
    depth = (weight - rock.worn) / rock.axial
    if depth <= 0.0 or speed <= 0.0 or rock.regenerative == 0.0:
        return None
    advance = depth / (2.0 * np.pi)
    force = rock.blades * np.array([rock.axial, -rock.turning])
    return Regeneration(2.0 * np.pi / (rock.blades * speed), advance * speed, force, np.array([1.0, advance]))


@kernel
def set_surface(rock: Parameters, bit: Bit) -> None:
    """Set the surface that steady drilling under the initial weight would have left, or a flat one below the bit."""
    memory, surface = rock.memory, rock.surface
    weight = bit.now[2]
    depth = max(weight - rock.worn, 0.0) / (rock.axial * rock.blades) if rock.regenerative > 0.0 else 0.0
    top = bit.start[2] - bit.off_bottom
    for k in range(-CELLS - 1, 1):
        surface[k % surface.shape[0]] = top - depth * k / CELLS
    memory[READY], memory[NEWEST] = 1.0, 0.0
    memory[ORIGIN] = memory[FARTHEST] = bit.start[SPIN]
    memory[DEEPEST] = top


@kernel
def depth_of_cut(rock: Parameters, bit: Bit, z: float, angle: float, half_step: float) -> Triple:
    """Depth of cut of all blades at a height and an angle of the bit at mid-step [m], its slopes by both."""
    memory, surface = rock.memory, rock.surface
    if rock.regenerative == 0.0:
        turn = angle - bit.start[SPIN]
        size = np.sqrt(turn * turn + (rock.creep * half_step) ** 2)
        depth = 2.0 * np.pi * (memory[DEEPEST] - z) / size
        return (depth, -2.0 * np.pi / size, -depth * turn / (size * size)) if depth > 0.0 else (0.0, 0.0, 0.0)
    pitch = 2.0 * np.pi / (rock.blades * CELLS)
    ahead = max(angle, memory[FARTHEST]) - memory[ORIGIN]
    place = ahead / pitch - CELLS
    cell = np.floor(place)
    if cell + 1.0 <= memory[NEWEST]:
        left = surface[int(cell) % surface.shape[0]]
        right = surface[int(cell + 1.0) % surface.shape[0]]
        depth, by_z = left + (place - cell) * (right - left) - z, -1.0
        by_angle = (right - left) / pitch
    else:  # the blade passes over what is cut in this step
        newest = surface[int(memory[NEWEST]) % surface.shape[0]]
        span = ahead - memory[NEWEST] * pitch
        share = pitch * CELLS / span
        depth, by_z = (newest - z) * share, -share
        by_angle = -depth / span
    if depth <= 0.0:
        return 0.0, 0.0, 0.0
    return rock.blades * depth, rock.blades * by_z, rock.blades * by_angle if angle >= memory[FARTHEST] else 0.0


@kernel
def forces(rock: Parameters, depth: float, pressed: float, pressed_fall: float) -> Forces:
    """Law of Detournay and Defourny (1992) at a depth of cut, with a share of the wear flats pressed on."""
    if depth <= 0.0:
        return Forces(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    share, share_depth = 1.0, 0.0
    if depth < rock.contact_depth:
        share, share_depth = depth / rock.contact_depth, 1.0 / rock.contact_depth
    worn, by_depth, by_fall = rock.worn * share * pressed, rock.worn * share_depth * pressed, rock.worn * share
    return Forces(
        rock.axial * depth + worn, rock.axial + by_depth, by_fall * pressed_fall,
        rock.turning * depth + rock.arm * worn, rock.turning + rock.arm * by_depth, rock.arm * by_fall * pressed_fall,
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
    """Add weight and torque of the rock at mid-step."""
    rock, bit = parameters.bit_regenerative, parameters.drive.bit
    if rock.memory[READY] == 0.0:
        set_surface(rock, bit)
    depth, by_z, by_angle = depth_of_cut(rock, bit, u[0, 2], u[0, SPIN], half_step)
    fall, speed = -v[0, 2], v[0, SPIN]
    fall_size, turn_size = np.sqrt(fall * fall + rock.settling**2), np.sqrt(speed * speed + rock.creep**2)
    fall_dual = dual_of_step(rock.fall_iterate, time, half_step, fall, fall_size)
    turn_dual = dual_of_step(rock.turn_iterate, time, half_step, speed, turn_size)
    pressed_fall = 0.5 / fall_size * (1.0 - fall_dual * fall / fall_size)
    law = forces(rock, depth, 0.5 * (1.0 + fall / fall_size), pressed_fall)
    sign, sign_speed = speed / turn_size, (1.0 - turn_dual * speed / turn_size) / turn_size
    apply_support(bit, law.weight, law.weight_fall - half_step * by_z * law.weight_depth, ends)
    ends[0, 2, SPIN] -= half_step * by_angle * law.weight_depth
    ends[0, SPIN, 7] += law.torque * sign
    ends[0, SPIN, SPIN] += law.torque * sign_speed + half_step * by_angle * law.torque_depth * sign
    ends[0, SPIN, 2] += (half_step * by_z * law.torque_depth - law.torque_fall) * sign


@kernel
def missed(parameters: Any, v: Array) -> float:
    """Share of the torque by which it will change in the next iteration."""
    return float(sign_missed(parameters.bit_regenerative.turn_iterate, v[0, SPIN]))


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Cut the surface where the blades passed, and add the impulses of weight and torque."""
    rock, bit = parameters.bit_regenerative, parameters.drive.bit
    memory, surface, half_step = rock.memory, rock.surface, 0.5 * step
    fall, speed = -bit.rate[2], bit.rate[SPIN]
    z, angle = 0.5 * (bit.start[2] + u[0, 2]), 0.5 * (bit.start[SPIN] + u[0, SPIN])
    pressed = 0.5 * (1.0 + fall / np.sqrt(fall * fall + rock.settling**2))
    law = forces(rock, depth_of_cut(rock, bit, z, angle, half_step)[0], pressed, 0.0)
    correct_weight_impulse(bit, law.weight, step)
    bit.impulse[BIT_TORQUE] -= step * law.torque * speed / np.sqrt(speed * speed + rock.creep**2)
    deepest = memory[DEEPEST]
    if rock.regenerative == 0.0:
        memory[DEEPEST] = min(deepest, u[0, 2])
    else:
        pitch = 2.0 * np.pi / (rock.blades * CELLS)
        first, last = bit.start[SPIN] - memory[ORIGIN], u[0, SPIN] - memory[ORIGIN]
        cell = memory[NEWEST] + 1.0
        while cell * pitch <= last:
            share = (cell * pitch - first) / (last - first)
            cut = bit.start[2] + share * (u[0, 2] - bit.start[2])
            before = surface[int(cell - CELLS) % surface.shape[0]]
            surface[int(cell) % surface.shape[0]] = min(cut, before)
            memory[DEEPEST] = min(memory[DEEPEST], cut)
            cell += 1.0
        memory[NEWEST] = cell - 1.0
        memory[FARTHEST] = max(memory[FARTHEST], u[0, SPIN])
    bit.impulse[DRILLED] += deepest - memory[DEEPEST]
