# SPDX-License-Identifier: Apache-2.0
"""Rigid body at the end of the string: the bit and short heavy tools."""

from typing import Annotated, Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Inertia, Mass, RotationalDamping, Within
from drill_twin.physics.effects.config import EffectConfig, parameters_class
from drill_twin.physics.model import Rod


class BitMass(EffectConfig):
    """Rigid body at the end of the string: inertia only, its weight is part of the weight on bit."""

    mass: Annotated[Mass, Within(at_least="0 kg", at_most="1e6 kg", reason="a whole string has 1e5")] = 0.0
    """Mass [kg]."""
    inertia: Annotated[Inertia, Within(at_least="0 kg m^2", at_most="1e9 kg m^2", reason="above, it is held")] = 0.0
    """Moment of inertia about the string's axis [kg m^2]."""
    damping: Annotated[RotationalDamping, Within(at_least="0 N m s/rad", at_most="1e9 N m s/rad")] = 0.0
    """Viscous damping of its rotation by the mud [N m s/rad]."""


Parameters = parameters_class(BitMass)


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
    """Add the inertia of a body centred on the end of the string: m a, and J alpha about the string's axis."""
    body, bit = parameters.bit_mass, ends[0]
    for c in range(3):
        bit[c, c] += body.mass / half_step
        bit[c, 7] += body.mass * (v[0, c] - v_old[0, c]) / half_step
    bit[6, 6] += body.inertia / half_step + body.damping
    bit[6, 7] += body.inertia * (v[0, 6] - v_old[0, 6]) / half_step + body.damping * v[0, 6]
