# SPDX-License-Identifier: Apache-2.0
"""Dry friction of bit on rock that falls with speed (Stribeck): the bit can stick, fully, and break loose."""

from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.effects.config import EffectConfig
from drill_twin.model.bit import BIT_TORQUE, pressed, resist
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import SPIN, Rod
from drill_twin.units import AngularSpeed, Dimensionless, Length, TimePerAngle, Within, refuse, show


class BitTorqueStribeck(EffectConfig):
    """T = R W (mu_c + (mu_s - mu_c) exp(-gamma |w|)) against the bit's spin (Navarro-Lopez and Suarez 2004)."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque",)
    energy_class = "heat"

    radius: Annotated[Length, Within(above="0 m", at_most="2 m")]
    """Radius at which the bit rubs, R [m]."""
    sliding: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient at high speed, mu_c [-]."""
    sticking: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient at rest, mu_s [-]; not below `sliding`."""
    decay: Annotated[TimePerAngle, Within(at_least="0 s/rad", at_most="1e4 s/rad")]
    """How fast friction falls with speed, gamma [s/rad]."""
    creep: Annotated[AngularSpeed, Within(at_least="1e-9 rad/s", at_most="0.1 rad/s")] = 1e-4
    """Speed below which a stuck bit creeps under its torque [rad/s]."""

    @model_validator(mode="after")
    def _sticks_harder_than_it_slides(self) -> Self:
        if self.sticking < self.sliding:
            raise refuse(f"expected `sticking` not below `sliding` ({self.sliding:g}), found {show(self.sticking)}")
        return self


class Parameters(NamedTuple):
    """R [m], mu_c, mu_s, gamma [s], creep [rad/s], and Newton's memory."""

    radius: float
    sliding: float
    sticking: float
    decay: float
    creep: float
    memory: Array  # speed, its smoothed size, dual, and the middle and half length of the step they belong to; (5,)


def parameters(block: BitTorqueStribeck, model: DiscreteModel) -> Parameters:
    """Nothing to prepare but the memory."""
    memory = np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    return Parameters(block.radius, block.sliding, block.sticking, block.decay, block.creep, memory)


@kernel
def dual(memory: Array, time: float, h2: float, speed: float, size: float) -> float:
    """Share of the friction limit that Newton's method believes in, -1 to 1, from its last iterate.

    The kink of w / |w| throws Newton's method to and fro; ``dual |w| = w``, linearised in both, does not (Chan, Golub
    and Mulet 1999).
    """
    share = 0.0
    if memory[3] == time and memory[4] == h2:
        share = (speed - memory[2] * memory[0] * (speed - memory[0]) / memory[1]) / memory[1]
        share = max(-1.0, min(1.0, share))
    memory[0], memory[1], memory[2], memory[3], memory[4] = speed, size, share, time, h2
    return share


@kernel
def friction(law: Parameters, weight: float, speed: float) -> tuple[float, float, float]:
    """Friction limit at a speed [N m], its slope by the speed's size [N m s], and the smoothed size of the speed."""
    excess = (law.sticking - law.sliding) * np.exp(-law.decay * abs(speed))
    arm = law.radius * weight
    return arm * (law.sliding + excess), -arm * law.decay * excess, np.sqrt(speed * speed + law.creep * law.creep)


@kernel
def end_load(
    parameters: Any, rod: Rod, command: Array, time: float, h2: float, u: Array, v: Array, v_old: Array, ends: Array
) -> None:
    """Friction against the bit's spin, w / sqrt(w^2 + creep^2) of its limit."""
    law, bit, speed = parameters.bit_torque_stribeck, parameters.drive.bit, v[0, SPIN]
    limit, fall, size = friction(law, pressed(bit), speed)
    share = dual(law.memory, time, h2, speed, size)
    resist(bit, (limit * speed / size, limit / size * (1.0 - share * speed / size) + fall * abs(speed) / size), ends)


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Count the torque of the step taken."""
    bit = parameters.drive.bit
    limit, _, size = friction(parameters.bit_torque_stribeck, pressed(bit), bit.rate[SPIN])
    bit.impulse[BIT_TORQUE] -= step * limit * bit.rate[SPIN] / size
