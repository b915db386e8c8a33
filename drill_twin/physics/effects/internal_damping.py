# SPDX-License-Identifier: Apache-2.0
"""Internal (material) damping in the rotating frame: it resists deformation and can cause forward whirl."""

from typing import Annotated, Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Time, Within
from drill_twin.physics.effects.config import EffectConfig, parameters_class
from drill_twin.physics.model import Rod, Strain
from drill_twin.physics.model.section import BEND_DAMP, COUPLE, MX, MY, MZ, TORQUE, TORQUE_RATE


class InternalDamping(EffectConfig):
    """Kelvin-Voigt damping: stress = E (strain + retardation time x strain rate), strain rate in the material frame."""

    energy_class = "heat"

    bending_time: Annotated[Time, Within(at_least="0 s", at_most="10 s", reason="longer, the material flows")]
    """Retardation time of bending [s]."""
    stretch_time: Annotated[Time, Within(at_least="0 s", at_most="10 s", reason="longer, the material flows")] = 0.0
    """Retardation time of stretch [s]."""
    torsion_time: Annotated[Time, Within(at_least="0 s", at_most="10 s", reason="longer, the material flows")] = 0.0
    """Retardation time of twist [s]."""


Parameters = parameters_class(InternalDamping)


@kernel
def section_stress(parameters: Any, rod: Rod, strain: Strain, half_step: float, resultants: Array) -> None:
    """Add Kelvin-Voigt moments, EI eta times the bending rate in the rotating material frame.

    A whirl slower than the rotation is driven forwards by them (Genta 2005; Muszynska 2005).
    """
    damp = parameters.internal_damping.bending_time * rod.bending[strain.element]
    mx, my, mz = damp * strain.ring_x, damp * strain.ring_y, damp * strain.ring_z
    resultants[MX] += mx
    resultants[MY] += my
    resultants[MZ] += mz
    resultants[COUPLE] += mx * strain.px + my * strain.py + mz * strain.pz
    resultants[BEND_DAMP] += damp
    twist = parameters.internal_damping.torsion_time * rod.torsion[strain.element]
    resultants[TORQUE] += twist * strain.tau_rate
    resultants[TORQUE_RATE] += twist


@kernel
def axial_damping(parameters: Any, element: int, axial: float, rate: float) -> tuple[float, float]:
    """Viscous axial force EA eta times the strain rate [N], and its slope by the strain rate [N s]."""
    slope = parameters.internal_damping.stretch_time * axial
    return slope * rate, slope
