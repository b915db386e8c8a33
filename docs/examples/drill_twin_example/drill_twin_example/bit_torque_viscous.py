# SPDX-License-Identifier: Apache-2.0
"""Torque on the bit in proportion to its speed."""

from typing import Annotated, Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import RotationalDamping, Within
from drill_twin.physics.effects.config import EffectConfig, parameters_class
from drill_twin.physics.model.bit import BIT_TORQUE
from drill_twin.physics.model.mesh import SPIN, Rod


class BitTorqueViscous(EffectConfig):
    """Torque c omega against the spin of the bit, whatever the weight on it."""

    requires = ("stretch", "torsion")
    provides = ("torque",)
    energy_class = "heat"

    damping: Annotated[RotationalDamping, Within(at_least="0 N m s/rad", at_most="1e6 N m s/rad")]
    """Torque per speed c [N m s/rad]."""


Parameters = parameters_class(BitTorqueViscous)


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
    """Residual and tangent of the torque, in the row of the bit's spin."""
    c = parameters.bit_torque_viscous.damping
    ends[0, SPIN, 7] += c * v[0, SPIN]
    ends[0, SPIN, SPIN] += c


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Count the impulse of the torque in the step taken, of which the rig's state has the mean."""
    bit = parameters.drive.bit
    bit.impulse[BIT_TORQUE] -= step * parameters.bit_torque_viscous.damping * bit.rate[SPIN]
