# SPDX-License-Identifier: Apache-2.0
"""Torque on bit as a smooth function of speed, with the velocity weakening that causes stick-slip."""

from typing import Annotated, Any, ClassVar

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Length, SquaredTimePerAngle, TimePerAngle, Within
from drill_twin.physics.effects.config import EffectConfig, parameters_class
from drill_twin.physics.model import SPIN, Rod
from drill_twin.physics.model.bit import BIT_TORQUE, apply_torque, contact_weight


class BitTorqueTanh(EffectConfig):
    """T = W a (tanh(b1 w) + b2 w / (1 + b3 w^2)): regularised law of Ritto, with Real's constants (2018)."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque",)
    energy_class = "heat"

    arm: Annotated[Length, Within(at_least="0 m", at_most="2 m", reason="it is a share of the bit's radius")] = 0.0239
    """Torque per weight on bit at high speed, a [m]; 1.4 x 4170 N m / 244.2 kN in the source."""
    rise: Annotated[TimePerAngle, Within(above="0 s/rad", at_most="1e4 s/rad")] = 1.91
    """Steepness of the torque at zero speed, b1 [s/rad]."""
    excess: Annotated[TimePerAngle, Within(at_least="0 s/rad", at_most="1e4 s/rad")] = 8.5
    """Height of the peak at low speed, b2 [s/rad]; 0 s/rad = no fall with speed."""
    fall: Annotated[SquaredTimePerAngle, Within(above="0 s^2/rad^2", at_most="1e8 s^2/rad^2")] = 5.47
    """Decay of the peak with speed, b3 [s^2/rad^2]."""


Parameters = parameters_class(BitTorqueTanh)


@kernel
def torque(law: Any, weight: float, speed: float) -> Pair:
    """Torque against a speed [rad/s] under a weight [N], and its slope (Ritto, Aguiar and Hbaieb 2017; Real 2018)."""
    scale, square = law.arm * weight, law.fall * speed * speed
    smooth = np.tanh(law.rise * speed)
    peak = law.excess / (1.0 + square)
    slope = law.rise * (1.0 - smooth * smooth) + peak * (1.0 - square) / (1.0 + square)
    return scale * (smooth + peak * speed), scale * slope


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
    """Add the torque of the rock against the bit's spin."""
    bit = parameters.drive.bit
    apply_torque(bit, torque(parameters.bit_torque_tanh, contact_weight(bit), v[0, SPIN]), ends)


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Add the impulse of the torque in the step."""
    bit = parameters.drive.bit
    bit.impulse[BIT_TORQUE] -= step * torque(parameters.bit_torque_tanh, contact_weight(bit), bit.rate[SPIN])[0]
