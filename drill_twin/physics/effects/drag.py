# SPDX-License-Identifier: Apache-2.0
"""Linear drag of the fluid around the string, in the fixed frame."""

from typing import Annotated, Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import LinearDrag, RotaryDrag, Within
from drill_twin.physics.effects.config import EffectConfig, parameters_class
from drill_twin.physics.model import Point, Rod


class Drag(EffectConfig):
    """Viscous drag per length of string, against lateral and axial motion and against spin."""

    energy_class = "heat"

    linear: Annotated[LinearDrag, Within(at_least="0 N s/m^2", at_most="1e6 N s/m^2", reason="a string in cold tar")]
    """Force per length and velocity [N s/m^2]."""
    rotary: Annotated[
        RotaryDrag, Within(at_least="0 N m s/rad/m", at_most="1e6 N m s/rad/m", reason="a string in cold tar")
    ] = 0.0
    """Torque per length and spin rate [N m s/rad/m]."""


Parameters = parameters_class(Drag)


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the force -c v on the centre line and the couple -c_r omega on the spin (paper Eq. 9)."""
    c = parameters.drag.linear
    load[0] -= c * here.vx
    load[1] -= c * here.vy
    load[2] -= c * here.vz
    load[3] -= parameters.drag.rotary * here.spin_rate
    stiff[0, 0] += c
    stiff[1, 1] += c
    stiff[2, 2] += c
    stiff[3, 3] += parameters.drag.rotary
