# SPDX-License-Identifier: Apache-2.0
"""Torque of rock on the bit as a smooth function of its speed, with the fall that makes stick-slip."""

from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, Pair
from drill_twin.base.jit import kernel
from drill_twin.effects.config import EffectConfig
from drill_twin.model.bit import BIT_TORQUE, pressed, resist
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.model.mesh import SPIN, Rod
from drill_twin.units import Length, SquaredTimePerAngle, TimePerAngle, Within


class BitTorqueTanh(EffectConfig):
    """T = W a (tanh(b1 w) + b2 w / (1 + b3 w^2)): regularised law of Ritto, with Real's constants (2018)."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque",)
    energy_class = "heat"

    arm: Annotated[Length, Within(at_least="0 m", at_most="2 m", reason="it is a share of the bit's radius")] = 0.0239
    """Torque per weight on bit at high speed, a [m]; 1.4 x 4170 N m / 244.2 kN in the source."""
    rise: Annotated[TimePerAngle, Within(above="0 s/rad", at_most="1e4 s/rad")] = 1.91
    """How fast the torque turns over at zero speed, b1 [s/rad]."""
    excess: Annotated[TimePerAngle, Within(at_least="0 s/rad", at_most="1e4 s/rad")] = 8.5
    """Height of the peak at low speed, b2 [s/rad]; 0 s/rad = no fall with speed."""
    fall: Annotated[SquaredTimePerAngle, Within(above="0 s^2/rad^2", at_most="1e8 s^2/rad^2")] = 5.47
    """How fast the peak falls with speed, b3 [s^2/rad^2]."""


class Parameters(NamedTuple):
    """a [m], b1 [s], b2 [s], b3 [s2]."""

    arm: float
    rise: float
    excess: float
    fall: float


def parameters(block: BitTorqueTanh, model: DiscreteModel) -> Parameters:
    """Nothing to prepare."""
    return Parameters(block.arm, block.rise, block.excess, block.fall)


@kernel
def torque(law: Parameters, weight: float, speed: float) -> Pair:
    """Torque against a speed [rad/s] under a weight [N], and its slope (Ritto, Aguiar and Hbaieb 2017; Real 2018)."""
    scale, square = law.arm * weight, law.fall * speed * speed
    smooth = np.tanh(law.rise * speed)
    peak = law.excess / (1.0 + square)
    slope = law.rise * (1.0 - smooth * smooth) + peak * (1.0 - square) / (1.0 + square)
    return scale * (smooth + peak * speed), scale * slope


@kernel
def end_load(
    parameters: Any, rod: Rod, command: Array, time: float, h2: float, u: Array, v: Array, v_old: Array, ends: Array
) -> None:
    """The rock's torque against the bit's spin."""
    bit = parameters.drive.bit
    resist(bit, torque(parameters.bit_torque_tanh, pressed(bit), v[0, SPIN]), ends)


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Count the torque of the step taken."""
    bit = parameters.drive.bit
    bit.impulse[BIT_TORQUE] -= step * torque(parameters.bit_torque_tanh, pressed(bit), bit.rate[SPIN])[0]
