# SPDX-License-Identifier: Apache-2.0
"""Quadratic drag of the mud on lateral motion with flow separation."""

from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, Within
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.model import DiscreteModel, Point, Rod


class QuadraticDrag(EffectConfig):
    """Drag C_d rho r_o |v| v per length on the velocity across the string in still mud (Morison and others 1950)."""

    across = True
    requires: ClassVar[tuple[str, ...]] = ("mud",)
    energy_class = "heat"

    coefficient: Annotated[Dimensionless, Within(at_least="0", at_most="10", reason="a cylinder has 0.3 to 2")] = 1.0
    """Drag coefficient C_d of the cross-section, by the outer diameter [-]; 1.0 to 1.2 at Reynolds numbers 1e3 to
    2e5."""


class Parameters(NamedTuple):
    """Half the density times C_d times the diameter [kg/m2], shape (2 n,)."""

    factor: Array


def parameters(block: QuadraticDrag, model: DiscreteModel) -> Parameters:
    """Compute the factor at the Gauss points."""
    return Parameters(model.at_places(block.coefficient * model.fluid_density * model.rod.outer_radius))


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the force -k |w| w with w = v - t (t.v); its derivative is k (|w| (1 - t t) + w w / |w|)."""
    along = here.tx * here.vx + here.ty * here.vy + here.tz * here.vz
    wx, wy, wz = here.vx - here.tx * along, here.vy - here.ty * along, here.vz - here.tz * along
    speed = np.sqrt(wx * wx + wy * wy + wz * wz)
    c = parameters.quadratic_drag.factor[here.place] * speed
    load[0] -= c * wx
    load[1] -= c * wy
    load[2] -= c * wz
    inverse = c / max(speed * speed, 1e-300)
    stiff[0, 0] += c * (1.0 - here.tx * here.tx) + inverse * wx * wx
    stiff[1, 1] += c * (1.0 - here.ty * here.ty) + inverse * wy * wy
    stiff[2, 2] += c * (1.0 - here.tz * here.tz) + inverse * wz * wz
    xy, xz = inverse * wx * wy - c * here.tx * here.ty, inverse * wx * wz - c * here.tx * here.tz
    yz = inverse * wy * wz - c * here.ty * here.tz
    stiff[0, 1] += xy
    stiff[1, 0] += xy
    stiff[0, 2] += xz
    stiff[2, 0] += xz
    stiff[1, 2] += yz
    stiff[2, 1] += yz
